#include "options/option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "base/printable.hpp"
#include "base/text.hpp"
#include "images/srgb.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// `text` as 1 or `count` numbers separated by x, * or commas; one number stands for all.
template <class T>
std::optional<std::vector<T>> one_or_all(std::string_view text, std::size_t count) {
  std::vector<T> values;
  for (const auto part : split(text, "xX*,")) {
    const auto value = detail::number_in<T>(part);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  if (values.size() == 1) values.resize(count, values.front());
  if (values.size() != count) return std::nullopt;
  return values;
}

constexpr std::pair<std::string_view, std::uint32_t> named_colours[] = {
    {"black", 0x000000},  {"white", 0xffffff}, {"grey", 0x808080}, {"gray", 0x808080},
    {"red", 0xff0000},    {"green", 0x008000}, {"blue", 0x0000ff}, {"navy", 0x000080},
    {"silver", 0xc0c0c0}, {"slate", 0x2f3e4e}, {"ivory", 0xfffff0}};

glm::dvec3 linear(const glm::dvec3& srgb) {
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c) light[c] = linear_of_srgb(static_cast<float>(srgb[c]));
  return light;
}

glm::dvec3 from_hex(std::uint32_t rgb) {
  return linear(glm::dvec3(rgb >> 16 & 255U, rgb >> 8 & 255U, rgb & 255U) / 255.0);
}

std::optional<std::uint32_t> hex(std::string_view text) {
  std::uint32_t rgb = 0;
  if (text.size() != 7 || text.front() != '#') return std::nullopt;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, rgb, 16);
  if (error != std::errc{} || end != text.data() + 7) return std::nullopt;
  return rgb;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({replace, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return row.back();
}

constexpr const char* form = "give FIRST:END or FIRST:END:STEP, END not included, or all";

/// A number from 0, or nothing where the text is empty. False when it is neither.
bool take(std::string_view text, std::optional<int>& number) {
  if (text.empty()) return true;
  number = detail::number_in<int>(text);
  return number && *number >= 0;
}

}  // namespace

Size parse_size(const std::string& text, const std::string& option) {
  const auto sides = one_or_all<int>(text, 2);
  if (!sides)
    throw InputError(fmt::format("{} '{}' is no image size", option, text),
                     fmt::format("for instance {} 512x512", option));
  return {(*sides)[0], (*sides)[1]};
}

Size parse_mesh(const std::string& text, const std::string& option) {
  const auto shape = one_or_all<int>(text, 2);
  constexpr int most = 4096;  // the product stays far inside an int
  if (!shape || std::any_of(shape->begin(), shape->end(), [](int n) { return n < 1 || n > most; }))
    throw InputError(
        fmt::format("{} '{}' is not a number of columns and of rows, each 1 to {}", option, text, most),
        fmt::format("for instance {} 4x4", option));
  return {(*shape)[0], (*shape)[1]};
}

int parse_count(const std::string& text, const std::string& option) {
  const auto count = detail::number_in<int>(text);
  if (!count)
    throw InputError(fmt::format("{} cannot be '{}'", option, text),
                     fmt::format("for instance {} 4", option));
  return *count;
}

glm::ivec3 parse_dims(const std::string& text, const std::string& option) {
  const auto dims = one_or_all<int>(text, 3);
  if (!dims || std::any_of(dims->begin(), dims->end(), [](int n) { return n < 1; }))
    throw InputError(fmt::format("{} '{}' is not three numbers of voxels, each at least 1", option, text),
                     fmt::format("for instance {} 256x256x128", option));
  return {(*dims)[0], (*dims)[1], (*dims)[2]};
}

glm::dvec3 parse_spacing(const std::string& text, const std::string& option) {
  const auto spacing = one_or_all<double>(text, 3);
  if (!spacing ||
      std::any_of(spacing->begin(), spacing->end(), [](double s) { return !(s > 0 && std::isfinite(s)); }))
    throw InputError(fmt::format("{} '{}' is not three positive distances", option, text),
                     fmt::format("for instance {} 0.5x0.5x1.2", option));
  return {(*spacing)[0], (*spacing)[1], (*spacing)[2]};
}

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

std::vector<std::string> colour_names() {
  std::vector<std::string> names;
  for (const auto& [name, rgb] : named_colours) names.emplace_back(name);
  return names;
}

std::optional<glm::dvec3> parse_colour(const std::string& text, const std::string& option) {
  if (text == "none" || text == "transparent") return std::nullopt;
  for (const auto& [name, rgb] : named_colours)
    if (text == name) return from_hex(rgb);
  if (const auto rgb = hex(text)) return from_hex(*rgb);
  const auto parts = parse_numbers(text);
  if (parts && parts->size() == 3 &&
      std::all_of(parts->begin(), parts->end(), [](double v) { return v >= 0 && v <= 1; }))
    return linear({(*parts)[0], (*parts)[1], (*parts)[2]});
  throw InputError(
      fmt::format("{} '{}' is no colour", option, text),
      fmt::format("a name ({}), #rrggbb, three numbers from 0 to 1 such as 0.2,0.2,0.25, or none",
                  joined(colour_names(), " ")));
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> values;
  for (const auto part : split(text, " ,;\t\r")) {
    if (part.empty()) continue;
    const auto value = detail::number_in<double>(part);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string closest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const auto& candidate : known)
    if (const auto distance = edit_distance(word, candidate); distance < least) {
      least = distance;
      best = candidate;
    }
  return best;
}

}  // namespace ringsplat::app
