#include "decode/tiff/description.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/text.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::int64_t most_planes = std::int64_t{1} << 40;  ///< keeps products of counts within 64 bits

using Lines = std::map<std::string, std::string>;

Lines lines_of(const std::string& description) {
  Lines lines;
  for (std::size_t at = 0; at < description.size();) {
    const auto end = std::min(description.find('\n', at), description.size());
    const auto line = description.substr(at, end - at);
    if (const auto equals = line.find('='); equals != std::string::npos)
      lines[trimmed(line.substr(0, equals))] = trimmed(line.substr(equals + 1));
    at = end + 1;
  }
  return lines;
}

std::optional<std::int64_t> count_in(const Lines& lines, const char* key) {
  const auto found = lines.find(key);
  return found == lines.end() ? std::nullopt : number_in<std::int64_t>(found->second);
}

/// ImageJ's pixels have a size when they have a unit; one that it does not write is 1 (ij/io/FileSaver.java).
void read_sizes(const TiffNotes& notes, Lines& lines, Microscopy& said) {
  const auto& unit = lines["unit"];
  if (!unit.empty() && unit != "pixel" && unit != "pixels") {
    const auto scale = micrometres_in(unit);
    said.sized = true;
    said.unit = scale ? "um" : excerpt(unit);
    for (int i = 0; i < 2; ++i)
      if (notes.resolution[std::size_t(i)] > 0) said.spacing[i] = 1 / notes.resolution[std::size_t(i)];
    said.spacing *= scale.value_or(1);
  }
  const auto depth = number_in<double>(lines["spacing"]);
  if (!depth || !std::isfinite(*depth) || *depth == 0) return;
  said.depth = true;
  said.spacing.z *= std::abs(*depth);
}

Microscopy read_image_j(const TiffNotes& notes) {
  auto lines = lines_of(notes.description);
  Microscopy said;
  said.by = "ImageJ";
  said.channels = count_in(lines, "channels").value_or(1);
  said.frames = count_in(lines, "frames").value_or(1);
  said.slices = count_in(lines, "slices");
  const auto images = count_in(lines, "images");
  if (!said.slices && said.channels == 1 && said.frames == 1) said.slices = images;
  if (!said.slices && images) said.slices = 1;
  read_sizes(notes, lines, said);
  return said;
}

}  // namespace

std::optional<std::uint64_t> Microscopy::planes(std::int64_t slice_count) const {
  std::int64_t all = 1;
  for (const auto count : {channels, frames, slice_count}) {
    if (count < 1 || count > most_planes / all) return {};
    all *= count;
  }
  return std::uint64_t(all);
}

std::optional<std::uint64_t> Microscopy::plane(std::int64_t channel, std::int64_t slice, std::int64_t frame,
                                               std::int64_t slice_count) const {
  std::int64_t place = 0, step = 1;
  for (const char axis : order) {
    place += step * (axis == 'C' ? channel : axis == 'Z' ? slice : frame);
    step *= axis == 'C' ? channels : axis == 'Z' ? slice_count : frames;
  }
  if (runs.empty()) return std::uint64_t(place);
  auto run = runs.upper_bound(std::uint64_t(place));
  if (run == runs.begin()) return {};
  --run;
  const auto into = std::uint64_t(place) - run->first;
  if (into >= run->second.count) return {};
  return run->second.plane + into;
}

std::optional<double> micrometres_in(const std::string& unit) {
  constexpr std::array<std::pair<std::string_view, double>, 24> units{
      {{"um", 1},           {"\xC2\xB5m", 1},   {"\xCE\xBCm", 1},       {"\xB5m", 1},       {"\\u00B5m", 1},
       {"\\u00b5m", 1},     {"micron", 1},      {"microns", 1},         {"micrometer", 1},  {"micrometre", 1},
       {"pm", 1e-6},        {"\xC3\x85", 1e-4}, {"\xE2\x84\xAB", 1e-4}, {"angstrom", 1e-4}, {"nm", 1e-3},
       {"nanometer", 1e-3}, {"mm", 1e3},        {"millimeter", 1e3},    {"cm", 1e4},        {"dm", 1e5},
       {"m", 1e6},          {"meter", 1e6},     {"in", 25400},          {"inch", 25400}}};
  for (const auto& [name, size] : units)
    if (name == unit) return size;
  return {};
}

std::optional<Microscopy> read_microscopy(const TiffNotes& notes) {
  const auto& text = notes.description;
  if (text.starts_with("ImageJ=")) return read_image_j(notes);
  if (text.find("<OME") != std::string::npos || text.find(":OME ") != std::string::npos)
    return read_ome(text);
  return {};
}

}  // namespace ringsplat::detail
