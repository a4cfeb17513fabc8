#pragma once

namespace ringsplat {

/// What a ray makes of the values it meets: light through classified space; the largest value, the least one,
/// the mean over its length in the volume, or the integral over world length, whose colour and opacity the
/// transfer function gives; or the first surface of one value.
enum class Mode { composite, mip, minip, mean, sum, surface };
const char* name(Mode mode);

}  // namespace ringsplat
