#pragma once
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>

namespace ringsplat::detail {

/// What a file says of a label.
struct LabelNotes {
  std::string name;                  ///< empty: none
  std::optional<glm::dvec3> colour;  ///< display (sRGB) values, 0 to 1
};

/// What a file says of its labels, by their values. None where nothing is said, or where the file cannot be
/// read.
std::map<double, LabelNotes> label_notes(const std::filesystem::path& file);

/// As 3D Slicer writes segmentations (SegmentN_LabelValue, _Name and _Color). Throws InputError where the
/// header is damaged.
std::map<double, LabelNotes> nrrd_label_notes(const std::filesystem::path& file);
/// Of an OME-Zarr image or one of its levels (image-label, 0.4). Throws InputError where metadata cannot be
/// read.
std::map<double, LabelNotes> zarr_label_notes(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
