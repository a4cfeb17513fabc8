#pragma once
#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "decode/dicom/elements.hpp"

namespace ringsplat::detail {

/// What tells images at one place apart, in the order that counts: Temporal Position, diffusion b-value, Echo
/// Time, Trigger Time, Acquisition Number, Acquisition Time, and the images' order. 0 where missing.
using DicomTimes = std::array<double, 7>;

/// Where an image lies, and when or how it was taken.
struct DicomPlane {
  glm::dvec3 position{0};  ///< of its first pixel, Image Position Patient
  DicomTimes times{};
};

/// The times of a single image. What is no number counts as missing.
DicomTimes dicom_times(const DicomFile& file);

/// The planes of a multi-frame image, which lie parallel.
struct DicomPlanes {
  glm::dvec3 row{1, 0, 0}, column{0, 1, 0};  ///< directions of a row and of a column, unit length
  glm::dvec2 spacing{1};                     ///< of columns and of rows
  std::vector<DicomPlane> planes;            ///< in the frames' order
};

/// Reads the functional groups of a checked file. Nothing when they do not give all frames a place. Throws
/// InputError when frames are not parallel or differ in their pixels' spacing.
std::optional<DicomPlanes> dicom_planes(const DicomFile& file, int frames);

}  // namespace ringsplat::detail
