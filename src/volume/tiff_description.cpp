#include "volume/tiff_description.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/log.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/text.hpp"
#include "volume/tiff_pages.hpp"

namespace ringsplat::detail {
namespace {

/// The description in a microscope's file.
struct Microscopy {
  std::string by;       ///< "ImageJ" or "OME-XML"
  std::string problem;  ///< why its pages are no single image of this file; empty when they are
  std::int64_t channels = 1, times = 1;
  std::optional<std::int64_t> slices;  ///< or the number of images, when only that is given
  std::array<double, 3> voxel{1, 1, 1};
  std::string unit;
};

using Attributes = std::map<std::string, std::string>;

std::optional<std::int64_t> count_in(const Attributes& a, const char* key) {
  const auto found = a.find(key);
  return found == a.end() ? std::nullopt : number_in<std::int64_t>(trimmed(found->second));
}

double size_in(const Attributes& a, const char* key, double otherwise) {
  const auto found = a.find(key);
  if (found == a.end()) return otherwise;
  const auto size = std::abs(number_in<double>(trimmed(found->second)).value_or(otherwise));
  return std::isfinite(size) && size > 0 ? size : otherwise;
}

/// Writes a unit in ASCII: there are two micro signs, and ImageJ's escape for one.
std::string ascii_unit(std::string unit) {
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC", "\xB5", "\\u00B5"})
    if (const auto at = unit.find(micro); at != std::string::npos)
      unit = unit.substr(0, at) + 'u' + unit.substr(at + micro.size());
  return excerpt(unit);
}

Microscopy read_image_j(const TiffNotes& notes) {
  Attributes lines;
  for (std::size_t at = 0; at < notes.description.size();) {
    const auto end = std::min(notes.description.find('\n', at), notes.description.size());
    const auto line = notes.description.substr(at, end - at);
    if (const auto equals = line.find('='); equals != std::string::npos)
      lines[trimmed(line.substr(0, equals))] = trimmed(line.substr(equals + 1));
    at = end + 1;
  }
  Microscopy said;
  said.by = "ImageJ";
  said.channels = count_in(lines, "channels").value_or(1);
  said.times = count_in(lines, "frames").value_or(1);
  said.slices = count_in(lines, "slices");
  // A stack of more than 4 GB has one page; its other slices follow it.
  const auto images = count_in(lines, "images");
  if (!said.slices && said.channels == 1 && said.times == 1) said.slices = images;
  said.unit = ascii_unit(lines["unit"]);
  if (!said.unit.empty() && said.unit != "pixel")
    for (std::size_t i = 0; i < 2; ++i)
      if (notes.resolution[i] > 0) said.voxel[i] = 1 / notes.resolution[i];
  said.voxel[2] = size_in(lines, "spacing", 1);
  return said;
}

Attributes attributes_in(const std::string& element) {
  Attributes attributes;
  for (auto at = element.find_first_of(" \t\r\n"); at < element.size();) {
    const auto equals = element.find('=', at);
    const auto open = equals == std::string::npos ? equals : element.find_first_of("\"'", equals);
    const auto close = open == std::string::npos ? open : element.find(element[open], open + 1);
    if (close == std::string::npos) break;
    attributes[trimmed(element.substr(at, equals - at))] = element.substr(open + 1, close - open - 1);
    at = close + 1;
  }
  return attributes;
}

/// The attributes of each XML element of a name, whatever its namespace.
std::vector<Attributes> xml_elements(const std::string& xml, const std::string& name) {
  std::vector<Attributes> found;
  for (auto at = xml.find('<'); at != std::string::npos; at = xml.find('<', at)) {
    const auto end = std::min(xml.find('>', at), xml.size());
    const auto element = xml.substr(at + 1, end - at - 1);
    const auto full = element.substr(0, element.find_first_of(" \t\r\n/", 1));
    if (full.substr(full.find(':') + 1) == name) found.push_back(attributes_in(element));
    at = end;
  }
  return found;
}

Microscopy read_ome(const std::string& xml) {
  Microscopy said;
  said.by = "OME-XML";
  if (const auto elsewhere = xml_elements(xml, "BinaryOnly"); !elsewhere.empty()) {
    const auto file = elsewhere[0].find("MetadataFile");
    said.problem = fmt::format("what its pages are is in another file{}",
                               file == elsewhere[0].end() ? "" : ", " + excerpt(file->second));
    return said;
  }
  const auto images = xml_elements(xml, "Pixels");
  std::set<std::string> files;
  for (const auto& uuid : xml_elements(xml, "UUID"))
    if (const auto name = uuid.find("FileName"); name != uuid.end()) files.insert(name->second);
  if (files.size() > 1)
    said.problem = fmt::format("it is one of {} files of an image", files.size());
  else if (images.size() != 1)
    said.problem = fmt::format("it holds {} images", images.size());
  if (!said.problem.empty()) return said;
  const auto& pixels = images[0];
  const auto channels = count_in(pixels, "SizeC"), times = count_in(pixels, "SizeT");
  said.slices = count_in(pixels, "SizeZ");
  if (!channels || !times || !said.slices) said.problem = "SizeC, SizeT or SizeZ is missing";
  said.channels = channels.value_or(1);
  said.times = times.value_or(1);
  const char* const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
  for (std::size_t i = 0; i < 3; ++i) said.voxel[i] = size_in(pixels, sizes[i], 1);
  const auto unit = pixels.find("PhysicalSizeXUnit");
  said.unit = unit == pixels.end() ? "um" : ascii_unit(unit->second);
  return said;
}

std::optional<Microscopy> read_notes(const std::filesystem::path& path) {
  const auto notes = read_tiff_notes(path);
  if (notes.description.starts_with("ImageJ=")) return read_image_j(notes);
  if (notes.description.find("<OME") != std::string::npos ||
      notes.description.find(":OME ") != std::string::npos)
    return read_ome(notes.description);
  return {};
}

}  // namespace

void require_one_stack(const std::filesystem::path& path, std::uint64_t pages) {
  const auto said = read_notes(path);
  if (!said) return;
  constexpr const char* how =
      "extract one channel and time point as a stack, in Fiji with Image > Duplicate, or with tiffsplit";
  if (!said->problem.empty())
    throw InputError(fmt::format("{}: {} (by its {})", path.string(), said->problem, said->by), how);
  if (said->channels != 1 || said->times != 1)
    throw InputError(fmt::format("{}: its {} pages are {} channels, {} time points and {} slices (by its {})",
                                 path.string(), pages, said->channels, said->times,
                                 said->slices ? std::to_string(*said->slices) : "some", said->by),
                     how);
  if (said->slices && std::uint64_t(*said->slices) != pages)
    throw InputError(fmt::format("{}: it says that it has {} slices (by its {}), and has {} pages",
                                 path.string(), *said->slices, said->by, pages),
                     "write all slices as pages of one file");
}

void warn_of_voxel_size(const std::filesystem::path& path) {
  const auto said = read_notes(path);
  if (!said || said->voxel == std::array<double, 3>{1, 1, 1}) return;
  const auto& v = said->voxel;
  log_warning_once(
      "{}: voxels of {:.6g} x {:.6g} x {:.6g}{} (by its {}) are taken for 1 x 1 x 1: give --spacing {:.6g} "
      "{:.6g} {:.6g}",
      path.string(), v[0], v[1], v[2], said->unit.empty() ? "" : " " + said->unit, said->by, v[0], v[1],
      v[2]);
}

}  // namespace ringsplat::detail
