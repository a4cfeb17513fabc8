#include "options/frames_option.hpp"

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <vector>

#include "base/printable.hpp"
#include "options/option_tables.hpp"
#include "options/split.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* form = "give FIRST:END or FIRST:END:STEP, END not included, or all";

/// A number from 0, or nothing where the text is empty. False when it is neither.
bool take(std::string_view text, std::optional<int>& number) {
  if (text.empty()) return true;
  int value = 0;
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || parsed != end || value < 0) return false;
  number = value;
  return true;
}

}  // namespace

FrameRange parse_frames(const std::string& text, const std::string& option) {
  const std::string given = fmt::format("{} '{}'", option, printable(text));
  const auto parts = split(text, ":");
  FrameRange range;
  range.text = text;
  // Launchers take a : that stands alone for the beginning of another program's arguments.
  if (text == "all") return range;
  std::optional<int> step;
  if (parts.size() < 2 || parts.size() > 3 || !take(parts[0], range.first) || !take(parts[1], range.end) ||
      (parts.size() == 3 && !take(parts[2], step)))
    throw InputError(fmt::format("{} is no range of frames", given), form);
  if (step == 0) throw InputError(fmt::format("{} has a step of 0", given), form);
  range.step = step.value_or(1);
  if (range.end && *range.end <= range.first.value_or(0))
    throw InputError(fmt::format("{} has no frame: FIRST must be less than END", given), form);
  return range;
}

namespace {

constexpr OptionRow<RenderOptions> series_rows[] = {
    {"--frames", "A:B[:STEP]|all", nullptr,
     "The volumes of a series, from A to before B, or all; VOLUME is a file with several time points, or "
     "a quoted pattern: 'step_*.nrrd', counted from 0, or step_%04d.nrrd, with the names' own numbers",
     [](RenderOptions& o) { return parsed(o.frames, parse_frames); }},
};

}  // namespace

constexpr OptionGroup<RenderOptions> series_options{"Volume", series_rows};

}  // namespace ringsplat::app
