#pragma once
#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "decode/dicom/elements.hpp"
#include "ringsplat/volume/grid.hpp"

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
  std::vector<DicomPlane> planes = {};       ///< in the frames' order
};

/// Reads the functional groups of a checked file. Nothing when they do not give all frames a place. Throws
/// InputError when frames are not parallel or differ in their pixels' spacing.
std::optional<DicomPlanes> dicom_planes(const DicomFile& file, int frames);

/// A slice of a stack: one image, or, where one is missing, the mean of two by their distances.
struct DicomSlice {
  std::size_t image = 0, next = 0;
  double part = 0;  ///< of `next`; 0: `image` alone
};

/// One time point of parallel images as an even stack.
struct DicomStack {
  int frames = 1;  ///< time points there are
  std::vector<DicomSlice> slices;
};

/// Puts the planes of one series into their order in space; several at one place are time points, in the
/// order of their times. Where single slices are missing in an even stack they are filled in, with a warning.
///
/// Positions may be off an even lattice by 1 % of its step or 0.01 mm, with a warning by 5 % or, as much as
/// positions written in tenths, 0.05 mm. Throws InputError when they are more, when more than a third of the
/// slices is missing, when places hold different numbers of images, and when there is no such time point.
///
/// `grid`: of an image, becomes that of the stack. The third axis comes from the slices' positions: a tilted
/// gantry shears the lattice. `frame`: the time point, from 0. `where`: the file or the folder, and
/// `name_of`: of an image, for messages.
DicomStack stack_planes(const std::vector<DicomPlane>& planes, const std::optional<int>& frame,
                        const std::string& where, const std::function<std::string(std::size_t)>& name_of,
                        Grid& grid);

}  // namespace ringsplat::detail
