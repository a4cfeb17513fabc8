#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raster/slice_buffer.hpp"
#include "splat/footprint.hpp"

namespace ringsplat {

/// The footprint's weights Q² in the pixels round an anchor, for each of phases × phases positions of the
/// kernel's centre: ((i + ½) / phases, (j + ½) / phases) pixels from the anchor's centre (Westover 1990).
struct FootprintTable {
  int phases = 1;
  std::int64_t reach_x = 0, reach_y = 0;  ///< the window is anchor − reach … anchor + reach + 1
  std::size_t row = 0;            ///< floats of a row; more than its pixels, as vectors read past them
  std::vector<float> weights;     ///< [phase][2 reach_y + 2][row]
  std::vector<PixelRun> covered;  ///< [phase][2 reach_y + 2]: pixels with a weight, from the anchor
  double x_of_a = 0, x_of_b = 0, y_of_a = 0, y_of_b = 0;  ///< give the centre from a splat's a and b

  std::size_t rows() const { return static_cast<std::size_t>(2 * reach_y + 2); }
  /// The phase of the kernel with the coefficients a and b.
  ///
  /// They are linear in the centre, so it need not travel beside them. It is recovered within 2⁻²⁴ times the
  /// square of the ellipse's ratio of axes: a thousandth of a pixel where that ratio is a hundred.
  std::size_t phase_of(float a, float b) const;
};

/// Uses fewer phases where the table would be larger than 16 MiB: with four phases, for kernels of more than
/// 500 pixels, to which half a pixel is little. Takes footprints that check(KernelOptions, Footprint) allows.
FootprintTable make_footprint_table(const Footprint& footprint, int phases);

}  // namespace ringsplat
