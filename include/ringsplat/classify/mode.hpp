#pragma once

namespace ringsplat {

/// What a ray makes of the values it meets: light through classified space; the largest value, the least one,
/// the mean over its length in the volume, or the integral over world length, whose colour and opacity the
/// transfer function gives; the first surface of one value; or the largest of values that what lies before
/// them has dimmed.
enum class Mode { composite, mip, minip, mean, sum, surface, attenuated };
const char* name(Mode mode);

}  // namespace ringsplat
