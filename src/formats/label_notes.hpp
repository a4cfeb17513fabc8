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

/// By their values, of a NRRD file's labels, as 3D Slicer writes segmentations (SegmentN_LabelValue, _Name
/// and _Color), or of an OME-Zarr image's or its level's (image-label, 0.4). None where nothing is said, or
/// where the file cannot be read.
std::map<double, LabelNotes> label_notes(const std::filesystem::path& file);

/// Of an OME-Zarr image or level alone. Throws where its metadata are not as they should be.
std::map<double, LabelNotes> zarr_label_notes(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
