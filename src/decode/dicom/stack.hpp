#pragma once
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "decode/dicom/planes.hpp"

namespace ringsplat::detail {

/// A slice of a stack: one image, or, where one is missing, the mean of two by their distances.
struct DicomSlice {
  std::size_t image = 0, next = 0;
  double part = 0;  ///< of `next`; 0: `image` alone
};

/// One time point of parallel images as an even stack.
struct DicomStack {
  int frames = 1;  ///< time points there are
  std::vector<DicomSlice> slices;
  glm::dvec3 origin{0};  ///< position of the first slice
  glm::dvec3 step{0};    ///< from slice to slice; 0 when there is only one
};

/// What stack_planes() needs to know and to say beside the planes.
struct DicomPlacing {
  glm::dvec3 normal{0, 0, 1};                       ///< of the planes, unit length
  double pixel = 1;                                 ///< the smaller distance of pixels, in mm
  std::optional<int> frame = {};                    ///< the time point, from 0
  std::string where;                                ///< the file or the folder, for messages
  std::function<std::string(std::size_t)> name_of;  ///< of an image, for messages
};

/// Puts the planes of one series into their order in space; several at one place are time points, in the
/// order of their times. Where single slices are missing in an even stack they are filled in, with a warning.
///
/// Positions may be off an even lattice by 1 % of its step or 0.01 mm, with a warning by 5 % or, as much as
/// positions written in tenths, 0.05 mm. Throws InputError when they are more, when more than a third of the
/// slices is missing, when places hold different numbers of images, and when there is no such time point.
DicomStack stack_planes(const std::vector<DicomPlane>& planes, const DicomPlacing& placing);

}  // namespace ringsplat::detail
