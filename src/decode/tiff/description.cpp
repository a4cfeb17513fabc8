#include "decode/tiff/description.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/srgb.hpp"
#include "base/text.hpp"
#include "formats/axes.hpp"
#include "formats/xml_reader.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::int64_t most_planes = std::int64_t{1} << 40;  ///< keeps products of counts within 64 bits

using Attributes = XmlReader::Attributes;

std::optional<std::int64_t> count_in(const Attributes& a, const char* key) {
  return number_in<std::int64_t>(trimmed(text_in(a, key)));
}

/// ImageJ's pixels have a size when they have a unit; one that it does not write is 1 (ij/io/FileSaver.java).
void read_sizes(const std::array<double, 2>& resolution, Attributes& lines, Microscopy& said) {
  const auto& unit = lines["unit"];
  if (!unit.empty() && unit != "pixel" && unit != "pixels") {
    const auto scale = micrometres_in(unit);
    said.sized = true;
    said.unit = scale ? "um" : excerpt(unit);
    for (int i = 0; i < 2; ++i)
      if (resolution[std::size_t(i)] > 0) said.spacing[i] = 1 / resolution[std::size_t(i)];
    said.spacing *= scale.value_or(1);
  }
  const auto depth = number_in<double>(lines["spacing"]);
  if (!depth || !std::isfinite(*depth) || *depth == 0) return;
  said.depth = true;
  said.spacing.z *= std::abs(*depth);
}

Microscopy read_image_j(const std::string& description, const std::array<double, 2>& resolution) {
  Attributes lines;
  std::istringstream text(description);
  for (std::string line; std::getline(text, line);)
    if (const auto equals = line.find('='); equals != std::string::npos)
      lines[trimmed(line.substr(0, equals))] = trimmed(line.substr(equals + 1));
  Microscopy said;
  said.by = "ImageJ";
  said.channels = count_in(lines, "channels").value_or(1);
  said.frames = count_in(lines, "frames").value_or(1);
  said.slices = count_in(lines, "slices");
  const auto images = count_in(lines, "images");
  if (!said.slices && said.channels == 1 && said.frames == 1) said.slices = images;
  if (!said.slices && images) said.slices = 1;
  read_sizes(resolution, lines, said);
  return said;
}

/// A start tag, whatever its namespace.
using Element = std::pair<std::string, Attributes>;

/// The start tags with one of these names, in the text's order.
struct StartTags : XmlReader {
  StartTags(const char* encoding, const std::set<std::string>& wanted, std::string_view xml)
      : XmlReader(encoding), names(wanted) {
    problem = parse([&](std::span<std::byte> window) {
      const auto count = std::min(window.size(), xml.size());
      std::memcpy(window.data(), xml.data(), count);
      xml.remove_prefix(count);
      return count;
    });
  }
  void on_start(const std::string& full, const Attributes& attributes) override {
    const auto name = full.substr(full.find(':') + 1);
    if (names.contains(name)) found.push_back({name, attributes});
  }

  const std::set<std::string>& names;
  std::vector<Element> found;
  std::string problem;  ///< why the text is no XML; then `found` is what came before
};

std::vector<Element> start_tags(const std::string& xml, const std::set<std::string>& names) {
  const StartTags tags(nullptr, names, xml);
  if (tags.problem.empty()) return tags.found;
  // Some programs write the micro sign in Latin-1 and do not say so.
  const StartTags latin("ISO-8859-1", names, xml);
  return latin.problem.empty() ? latin.found : tags.found;
}

/// PhysicalSizeX, PhysicalSizeXUnit and so on. A missing unit is micrometres.
void read_sizes(const Attributes& pixels, Microscopy& said) {
  std::array<std::optional<double>, 3> sizes, scales;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto name = std::string("PhysicalSize") + char('X' + i);
    const auto size = number_in<double>(trimmed(text_in(pixels, name.c_str())));
    const auto unit = trimmed(text_in(pixels, (name + "Unit").c_str()));
    if (size && std::isfinite(*size) && *size != 0) sizes[i] = std::abs(*size);
    scales[i] = unit.empty() ? 1 : micrometres_in(unit);
  }
  said.sized = sizes[0].has_value();
  if (!said.sized) return;
  said.unit = scales[0] ? "um" : "";
  said.depth = sizes[2].has_value() && scales[2].has_value() == scales[0].has_value();
  for (std::size_t i = 0; i < 3; ++i) {
    const bool like_x = !sizes[i] || scales[i].has_value() != scales[0].has_value();
    const auto from = like_x ? 0 : i;
    said.spacing[int(i)] = *sizes[from] * scales[from].value_or(1);
  }
}

/// Where runs of planes lie in the file by TiffData. A run without a count goes on to where the next begins.
void read_runs(const std::vector<Element>& tags, std::int64_t samples, Microscopy& said) {
  const auto slices = said.slices.value_or(1);
  for (const auto& [name, a] : tags) {
    if (name != "TiffData") continue;
    const auto ifd = count_in(a, "IFD");
    const auto c = count_in(a, "FirstC").value_or(0) / samples, z = count_in(a, "FirstZ").value_or(0),
               t = count_in(a, "FirstT").value_or(0);
    const auto all = std::int64_t(said.planes(slices).value_or(0));
    const auto count = count_in(a, "PlaneCount").value_or(all);
    if (c < 0 || z < 0 || t < 0 || c >= said.channels || z >= slices || t >= said.frames || count < 1 ||
        ifd.value_or(0) < 0) {
      said.problem = "a TiffData element lies outside of its sizes";
      return;
    }
    Microscopy whole = said;
    whole.runs.clear();
    said.runs[*whole.plane(c, z, t, slices)] = {std::uint64_t(ifd.value_or(0)), std::uint64_t(count)};
  }
}

void read_channels(const std::vector<Element>& tags, Microscopy& said, std::int64_t& samples) {
  for (const auto& [name, a] : tags) {
    if (name != "Channel") continue;
    if (said.of_channels.empty()) samples = count_in(a, "SamplesPerPixel").value_or(1);
    ChannelNotes& notes = said.of_channels.emplace_back();
    notes.name = trimmed(text_in(a, "Name"));
    // Red, green, blue and alpha of 8 bits, from the top down, in a signed number.
    if (const auto rgba = count_in(a, "Color")) notes.colour = colour_of(std::uint32_t(*rgba >> 8));
  }
  // The colours of a page count as channels there.
  if (samples < 1 || said.channels % samples != 0) samples = 1;
  said.channels /= samples;
  if (said.channels < std::int64_t(said.of_channels.size()))
    said.of_channels.resize(std::size_t(said.channels));
}

Microscopy read_ome(const std::string& xml) {
  Microscopy said;
  said.by = "OME-XML";
  const auto tags = start_tags(xml, {"BinaryOnly", "Pixels", "Channel", "TiffData", "UUID"});
  std::set<std::string> files;
  std::int64_t images = 0;
  Attributes pixels;
  for (const auto& [name, a] : tags) {
    if (name == "BinaryOnly") {
      const auto file = text_in(a, "MetadataFile");
      said.problem = "what its pages are is in another file" + (file.empty() ? "" : ", " + excerpt(file));
      return said;
    }
    if (name == "UUID" && a.contains("FileName")) files.insert(a.at("FileName"));
    if (name == "Pixels" && ++images == 1) pixels = a;
  }
  if (files.size() > 1)
    said.problem = fmt::format("it is one of {} files of an image", files.size());
  else if (images != 1)
    said.problem = fmt::format("it holds {} images", images);
  if (!said.problem.empty()) return said;
  const auto channels = count_in(pixels, "SizeC"), frames = count_in(pixels, "SizeT");
  said.slices = count_in(pixels, "SizeZ");
  if (!channels || !frames || !said.slices) said.problem = "SizeC, SizeT or SizeZ is missing";
  said.channels = channels.value_or(1);
  said.frames = frames.value_or(1);
  read_sizes(pixels, said);
  const auto order = text_in(pixels, "DimensionOrder");
  if (auto sorted = order.substr(std::min<std::size_t>(2, order.size())); order.starts_with("XY")) {
    said.order = sorted;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != "CTZ") said.problem = fmt::format("DimensionOrder is '{}'", excerpt(order));
  } else {
    said.order = "ZCT";
  }
  std::int64_t samples = 1;
  read_channels(tags, said, samples);
  if (said.problem.empty() && said.planes(said.slices.value_or(1))) read_runs(tags, samples, said);
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

std::optional<Microscopy> read_microscopy(const std::string& description,
                                          const std::array<double, 2>& resolution) {
  if (description.starts_with("ImageJ=")) return read_image_j(description, resolution);
  if (description.find("<OME") != std::string::npos || description.find(":OME ") != std::string::npos)
    return read_ome(description);
  return {};
}

}  // namespace ringsplat::detail
