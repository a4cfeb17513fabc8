#pragma once
#include <initializer_list>

namespace ringsplat {

/// What a ray makes of the values it meets: light through classified space; the largest value, the least one,
/// the mean over its length in the volume, or the integral over world length, whose colour and opacity the
/// transfer function gives; the first surface of one value; or the largest of values that what lies before
/// them has dimmed.
enum class Mode { composite, mip, minip, mean, sum, surface, attenuated };
const char* name(Mode mode);
/// In the order in which people are shown them.
inline constexpr std::initializer_list<Mode> every_mode{
    Mode::composite, Mode::mip, Mode::attenuated, Mode::minip, Mode::mean, Mode::sum, Mode::surface};

}  // namespace ringsplat
