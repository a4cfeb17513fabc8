#pragma once
// DICOM images made of the sample volume.
#include <string>
#include <vector>

#include "formats/compressed_frames.hpp"
#include "formats/files.hpp"

namespace files {

inline constexpr const char* implicit = "1.2.840.10008.1.2";
inline constexpr const char* big_endian = "1.2.840.10008.1.2.2";
inline constexpr const char* deflated_syntax = "1.2.840.10008.1.2.1.99";
inline constexpr const char* rle = "1.2.840.10008.1.2.5";
inline constexpr const char* lossless = "1.2.840.10008.1.2.4.70";
inline constexpr const char* enhanced_ct = "1.2.840.10008.5.1.4.1.1.2.1";

/// All slices of the sample volume in one file.
inline Dicom all_frames() {
  Dicom frames;
  frames.frames = nz;
  frames.pixels = samples<short>();
  return frames;
}

inline std::string groups(unsigned id, const std::vector<std::string>& items) {
  return Dicom::sequence(0x5200, id, items);
}
inline std::string plane_at(const std::string& position) {
  return Dicom::sequence(0x20, 0x9113, {Dicom::element(0x20, 0x32, "DS", position)});
}
inline std::string shared_group(const std::string& slope) {
  return Dicom::sequence(0x20, 0x9116, {Dicom::element(0x20, 0x37, "DS", "0\\1\\0\\0\\0\\-1")}) +
         Dicom::sequence(0x28, 0x9110, {Dicom::element(0x28, 0x30, "DS", "2\\1")}) +
         Dicom::sequence(
             0x28, 0x9145,
             {Dicom::element(0x28, 0x1052, "DS", "5") + Dicom::element(0x28, 0x1053, "DS", slope)});
}

/// An enhanced multi-frame image, whose geometry is in groups only.
inline Dicom enhanced(const std::vector<std::string>& positions) {
  auto image = all_frames();
  image.storage_class = enhanced_ct;
  image.position = image.orientation = image.spacing = image.slope = image.intercept = "";
  std::vector<std::string> planes;
  for (const auto& position : positions) planes.push_back(plane_at(position));
  image.more = groups(0x9229, {shared_group("2")}) + groups(0x9230, planes);
  return image;
}

}  // namespace files
