#pragma once
#include <filesystem>
#include <map>
#include <string>

namespace ringsplat {

/// What a NRRD file's labels are called, as 3D Slicer writes segmentations (SegmentN_LabelValue and
/// SegmentN_Name). None where there are no such names, or where the file cannot be read.
std::map<double, std::string> label_names(const std::filesystem::path& file);

}  // namespace ringsplat
