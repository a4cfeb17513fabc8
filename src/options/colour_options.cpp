#include "options/colour_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "classify/colour_maps.hpp"
#include "options/option_tables.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using Render = RenderOptions;
constexpr OptionRow<Render> colour_rows[] = {
    {"--range", "LO:HI", nullptr,
     "Window of values that the transfer function spans; a preset or a file is stretched onto it",
     [](Render& o) { return parsed(o.colour.range, parse_window); }},
    {"--opacity", "F", "1", "Makes the volume so many times as dense: 2 thicker, 0.5 thinner",
     [](Render& o) { return parsed(o.colour.opacity, parse_density); }},
    {"--colours", "NAME", nullptr,
     "A colour map instead of the transfer function's own colours; list: shows the names",
     [](Render& o) { return value(o.colour.colours); }},
    {"--log", nullptr, nullptr,
     "Colours and opacities on a logarithmic axis of the positive values; all others are clear",
     [](Render& o) { return flag(o.colour.log); }},
    {"--labels", nullptr, nullptr,
     "Each whole number is a label with a colour of its own, 0 is clear; found by itself in most files of "
     "labels",
     [](Render& o) { return flag(o.colour.labels); }},
    {"--interpolation", nullptr, nullptr,
     "The values between voxels, which sheets and the field's truth ask for: linear, or the nearest voxel's; "
     "without it nearest for labels, else linear",
     [](Render& o) {
       return choice(o.colour.interpolation,
                     {{"linear", Interpolation::linear}, {"nearest", Interpolation::nearest}});
     }},
};

}  // namespace

constexpr OptionGroup<Render> colour_options{"Colours", colour_rows};

ValueWindow parse_window(const std::string& text, const std::string& option) {
  const auto wrong = [&](const char* what) -> InputError {
    return {fmt::format("{} {}: {}", option, text, what), fmt::format("for instance {}=-100:300", option)};
  };
  const auto colon = text.find(':');
  if (colon == std::string::npos) throw wrong("is no window of values");
  const auto low = parse_numbers(text.substr(0, colon)), high = parse_numbers(text.substr(colon + 1));
  if (!low || !high || low->size() != 1 || high->size() != 1) throw wrong("is no window of values");
  const ValueWindow window{low->front(), high->front()};
  if (!std::isfinite(window.low) || !std::isfinite(window.high)) throw wrong("is not finite");
  if (!(window.low < window.high)) throw wrong("does not ascend");
  return window;
}

double parse_density(const std::string& text, const std::string& option) {
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != 1 || !(numbers->front() > 0) || !std::isfinite(numbers->front()))
    throw InputError(fmt::format("{} {} is no number above 0", option, text),
                     fmt::format("for instance {} 2, for a picture twice as dense", option));
  return numbers->front();
}

std::string list_of_colour_maps() {
  std::string text;
  for (const auto& map : colour_map_names()) text += fmt::format("{:<22}{}\n", map.name, map.description);
  return text;
}

}  // namespace ringsplat::app
