#include "options/option_values.hpp"

#include <glm/geometric.hpp>
#include <numeric>

#include "options/option_list.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// `text` as 1 or `count` numbers within the bounds, separated by x, * or commas; one number stands for all.
/// Throws InputError: it is not what is `wanted`.
template <int count, class T>
glm::vec<count, T> one_or_all(const std::string& text, const std::string& option, const Bounds<T>& bounds,
                              const char* wanted, const char* example) {
  const auto parts = split(text, "xX*,");
  bool right = parts.size() == 1 || parts.size() == count;
  glm::vec<count, T> values{};
  for (int k = 0; right && k < count; ++k) {
    const auto value = detail::number_in<T>(parts[parts.size() == 1 ? 0 : std::size_t(k)]);
    right = value && bounds.hold(*value);
    values[k] = value.value_or(T{});
  }
  if (!right)
    throw InputError(fmt::format("{} '{}' is {}", option, text, wanted),
                     fmt::format("for instance {} {}", option, example));
  return values;
}

/// With blanks around it or not.
std::optional<double> one_number(const std::string& text) {
  return detail::number_in<double>(detail::trimmed(text));
}

constexpr std::pair<std::string_view, std::uint32_t> named_colours[] = {
    {"black", 0x000000},  {"white", 0xffffff}, {"grey", 0x808080}, {"gray", 0x808080},
    {"red", 0xff0000},    {"green", 0x008000}, {"blue", 0x0000ff}, {"navy", 0x000080},
    {"silver", 0xc0c0c0}, {"slate", 0x2f3e4e}, {"ivory", 0xfffff0}};

glm::dvec3 linear(const glm::dvec3& srgb) {
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c) light[c] = srgb_to_linear(static_cast<float>(srgb[c]));
  return light;
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

glm::ivec2 parse_size(const std::string& text, const std::string& option) {
  return one_or_all<2, int>(text, option, {}, "no image size", "512x512");
}

glm::ivec2 parse_mesh(const std::string& text, const std::string& option) {
  // The product stays far inside an int.
  return one_or_all<2, int>(text, option, {1, 4096}, "not a number of columns and of rows, each 1 to 4096",
                            "4x4");
}

double parse_memory(const std::string& text, const std::string& option) {
  constexpr std::string_view units = "KMGT";
  const auto unit = text.empty() ? text.npos : units.find(text.back());
  const auto number = unit == text.npos
                          ? std::nullopt
                          : detail::number_in<double>(std::string_view(text).substr(0, text.size() - 1));
  if (!number || !(*number > 0 && std::isfinite(*number)))
    throw InputError(fmt::format("{} '{}' is no size with a unit (K, M, G or T)", option, text),
                     fmt::format("for instance {} 8G", option));
  return *number * std::pow(1024.0, double(unit + 1));
}

glm::ivec3 parse_dims(const std::string& text, const std::string& option) {
  return one_or_all<3, int>(text, option, {.least = 1}, "not three numbers of voxels, each at least 1",
                            "256x256x128");
}

glm::dvec3 parse_spacing(const std::string& text, const std::string& option) {
  using Limits = std::numeric_limits<double>;
  return one_or_all<3, double>(text, option, {Limits::denorm_min(), Limits::max()},
                               "not three positive distances", "0.5x0.5x1.2");
}

DataRange parse_window(const std::string& text, const std::string& option) {
  const auto wrong = [&](const char* what) -> InputError {
    return {fmt::format("{} {}: {}", option, text, what), fmt::format("for instance {}=-100:300", option)};
  };
  const auto colon = std::min(text.find(':'), text.size());
  const auto low = one_number(text.substr(0, colon)), high = one_number(text.substr(colon).erase(0, 1));
  if (!low || !high) throw wrong("is no window of values");
  if (!std::isfinite(*low) || !std::isfinite(*high)) throw wrong("is not finite");
  if (!(*low < *high)) throw wrong("does not ascend");
  return {*low, *high};
}

double parse_positive(const std::string& text, const std::string& option, const std::string& hint) {
  const auto number = one_number(text);
  if (!number || !(*number > 0) || !std::isfinite(*number))
    throw InputError(fmt::format("{} {} is no number above 0", option, text), hint);
  return *number;
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

ShownLabels parse_mask(const std::string& text, const std::string& option) {
  const auto at = text.rfind('=');
  ShownLabels mask;
  mask.path = text.substr(0, at);
  const auto refuse = [&](const char* what) {
    throw InputError(fmt::format("{} '{}' {}", option, printable(text), what),
                     fmt::format("{0} seg.nrrd, or with labels {0} seg.nrrd=1,3-5", option));
  };
  if (mask.path.empty()) refuse("names no file");
  if (at == std::string::npos) return mask;
  for (const std::string_view part : split(std::string_view(text).substr(at + 1), ",")) {
    const auto ends = split(part, "-");
    std::optional<int> first, last;
    if (ends.size() > 2 || !take(ends.front(), first) || !take(ends.back(), last) || !first || !last)
      refuse("has something else than labels behind =");
    if (*last < *first) refuse("has a range of labels that ends before it begins");
    mask.labels.emplace_back(*first, *last);
  }
  return mask;
}

std::vector<std::string> colour_names() {
  return detail::mapped(named_colours, [](const auto& colour) { return std::string(colour.first); });
}

std::optional<glm::dvec3> parse_colour(const std::string& text, const std::string& option) {
  if (text == "none" || text == "transparent") return std::nullopt;
  if (const auto rgb = detail::found(named_colours, text)) return linear(colour_of(*rgb));
  if (const auto colour = text.starts_with('#') ? hex_colour(text.substr(1)) : std::nullopt)
    return linear(*colour);
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

std::string closest(const std::string& word, const std::vector<std::string>& known) {
  const auto distance = [&](const std::string& candidate) { return edit_distance(word, candidate); };
  const auto best = std::ranges::min_element(known, {}, distance);
  const bool close = best != known.end() && distance(*best) <= std::max<std::size_t>(1, word.size() / 3);
  return close ? *best : "";
}

// Options that are like an unknown one.

namespace {

/// Options of ParaView, VTK, matplotlib, Fiji, Slicer and the like.
struct Alike {
  const char *ours, *theirs;
  const char* more = "";
};

constexpr const char* or_whole = " --tf changes opacities, too.";
constexpr Alike table[] = {
    {"range", "window window-level level clim vmin vmax"},
    {"colours", "cmap colormap colourmap color-map colors lut palette", or_whole},
    {"tf", "transfer-function preset"},
    {"mode", "mip minip attenuated-mip projection-mode blend-mode isosurface"},
    {"isovalue", "iso contour"},
    {"opacity", "alpha density"},
    {"size", "resolution width height"},
    {"eye", "camera camera-position position"},
    {"target", "focal-point look-at"},
    {"up", "view-up"},
    {"azimuth", "rotate angle"},
    {"orbit", "turntable"},
    {"clip", "roi"},
    {"frame", "timestep"},
    {"threads-per-rank", "threads jobs"},
    {"background", "bgcolor"},
    {"type", "dtype"},
    {"dims", "shape"},
    {"spacing", "voxel-size"},
    {"quality", "sampling-rate"},
};

std::string plain(const std::string& name) {
  std::string text = name.substr(std::min(name.find_first_not_of('-'), name.size()));
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

}  // namespace

std::string likely_option(const std::string& unknown, const std::vector<std::string>& known) {
  for (const auto& [ours, theirs, more] : table)
    for (const std::string& word : detail::words_of(theirs))
      for (const auto& name : known)
        if (word == plain(unknown) && plain(name) == ours)
          return fmt::format("did you mean {}?{}", name, more);
  const std::string alike = closest(unknown, known);
  return alike.empty() ? "" : fmt::format("did you mean {}?", alike);
}

// Clip boxes.

namespace {

struct Part {
  std::string text;  ///< as typed, for messages
  std::optional<double> first, end;
  bool distances = false;
  bool slice = false;  ///< the one voxel at `first`
};

struct ClipText {
  std::string option;  ///< for messages
  std::array<Part, 3> parts;
  VoxelBox operator()(const Grid& grid) const;
};

/// Takes the unit off, where there is one.
bool take_unit(std::string& text) {
  constexpr std::string_view unit = "mm";
  if (!text.ends_with(unit)) return false;
  text.resize(text.size() - unit.size());
  return true;
}

[[noreturn]] void refuse(const std::string& option, Axis axis, const Part& part, const std::string& why,
                         const std::string& hint) {
  throw InputError(fmt::format("{}: the {} part, '{}', {}", option, name(axis), part.text, why), hint);
}

/// One number, or nothing where the text is empty. False when it is no number.
bool take_number(const std::string& text, std::optional<double>& number) {
  if (detail::trimmed(text).empty()) return true;
  number = one_number(text);
  return number && std::isfinite(*number);
}

Part parse_part(std::string_view given, const std::string& option, Axis axis) {
  Part part;
  part.text = printable(given);
  std::string text = detail::trimmed(given);
  part.distances = take_unit(text);
  if (detail::trimmed(text).empty() && !part.distances) return part;
  const auto colon = text.find(':');
  if (colon == std::string_view::npos || !take_number(text.substr(0, colon), part.first) ||
      !take_number(text.substr(colon + 1), part.end))
    refuse(option, axis, part, "is no range", "give FIRST:END, FIRST:, :END, or nothing for all of the axis");
  return part;
}

/// The number of voxel faces up to a place, rounded to the nearest face; of a slice's the voxel there.
int faces_to(double number, const Part& part, Axis axis, const ClipText& clip, const Grid& grid) {
  const int k = static_cast<int>(axis), last = grid.dims[k];
  if (!part.distances && number != std::floor(number))
    refuse(clip.option, axis, part, "has a voxel that is no whole number", "for distances add mm");
  const double voxel = grid.spacing[k] * glm::length(grid.direction[k]),
               faces = !part.distances ? number
                       : part.slice    ? std::floor(number / voxel)
                                       : std::ceil(number / voxel - 0.5);
  if (!(faces >= 0 && faces <= last - int(part.slice)))
    refuse(clip.option, axis, part, "does not lie within the volume",
           part.distances ? fmt::format("it is {:g} long there, in the file's units", last * voxel)
                          : fmt::format("it has voxels 0:{} there", last));
  return static_cast<int>(faces);
}

VoxelBox ClipText::operator()(const Grid& grid) const {
  VoxelBox box = whole_box(grid);
  for (const Axis axis : all_axes) {
    const auto k = static_cast<int>(axis);
    const Part& part = parts[std::size_t(axis)];
    if (part.first) box.first[k] = faces_to(*part.first, part, axis, *this, grid);
    if (part.end) box.end[k] = faces_to(*part.end, part, axis, *this, grid);
    if (part.slice) box.end[k] = box.first[k] + 1;
    if (box.first[k] >= box.end[k])
      refuse(option, axis, part, "has no voxel",
             part.distances ? "a voxel counts when its centre lies between" : "FIRST must be less than END");
  }
  return box;
}

}  // namespace

BoxOf parse_clip(const std::string& text, const std::string& option) {
  ClipText clip;
  clip.option = option;
  const auto parts = split(text, ",");
  if (parts.size() != clip.parts.size())
    throw InputError(fmt::format("{} '{}' has {} part{} instead of three", option, printable(text),
                                 parts.size(), parts.size() == 1 ? "" : "s"),
                     fmt::format("give x0:x1,y0:y1,z0:z1; for instance {} 10:200,:,0:64", option));
  for (const Axis axis : all_axes)
    clip.parts[std::size_t(axis)] = parse_part(parts[std::size_t(axis)], option, axis);
  if (clip.parts.back().distances)
    for (Part& part : clip.parts) part.distances = true;
  return clip;
}

std::pair<BoxOf, Axis> parse_slice(const std::string& text, const std::string& option) {
  ClipText clip;
  clip.option = option;
  const auto words = split(text, "=");
  const std::string letter = words.empty() ? "" : detail::trimmed(words.front());
  for (const Axis axis : all_axes) {
    if (words.size() != 2 || letter != std::string(1, name(axis))) continue;
    std::string place = detail::trimmed(words.back());
    Part& part = clip.parts[std::size_t(axis)];
    part.text = printable(place);
    part.slice = true;
    part.distances = take_unit(place);
    if (take_number(place, part.first) && part.first) return {clip, axis};
  }
  throw InputError(
      fmt::format("{} '{}' names no slice", option, printable(text)),
      fmt::format("give an axis and a voxel from 0, a distance, or a plane: {0} x=40, {0} z=12.5mm, {0} "
                  "plane:1,1,0,0",
                  option));
}

ClipPlane parse_clip_plane(std::string_view text, const std::string& option) {
  const auto n = parse_numbers(text);
  if (!n || n->size() != 4)
    throw InputError(fmt::format("{} '{}' is no plane", option, printable(text)),
                     "give NX,NY,NZ,D: a direction, and how far along it from the volume's middle the plane "
                     "is; for instance 0,1,0,0");
  return {{(*n)[0], (*n)[1], (*n)[2]}, (*n)[3]};
}

std::optional<VoxelBox> clip_box(const BoxOf& clip, const Grid& grid, const VolumeNotes& notes) {
  if (!clip) return std::nullopt;
  const Grid& counted = notes.finest ? *notes.finest : grid;
  return box_in_level(clip(counted), counted.dims, grid.dims);
}

}  // namespace ringsplat::app
