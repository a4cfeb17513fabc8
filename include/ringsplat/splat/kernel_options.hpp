#pragma once
#include <string>

namespace ringsplat {

struct Footprint;

/// How a Renderer finds a kernel's weight in a pixel.
enum class KernelMethod {
  qee,     ///< computed from the quadratic's coefficients (Neumann 1992, section 2.3)
  texture  ///< looked up in a table of the footprint (section 2.1; Westover 1990)
};

/// What divides the kernels' weights.
enum class Normalisation {
  none,      ///< nothing: Q² as it is, which makes opacities π radius² / 3 times too large on the average
  constant,  ///< the mean of the lattice's sum of weights; what is left is the kernel's ripple
  exact      ///< that sum itself, at each pixel
};

struct KernelOptions {
  KernelMethod method = KernelMethod::qee;
  /// Textures: the table holds the footprint for this many sub-pixel positions along each axis, 1 to 16. A
  /// splat is drawn at the nearest of them, at most 1 / (2 phases) of a pixel away along each axis.
  int phases = 4;
  /// 0: Q is computed in float32. 2 to 16: in fixed point with so many bits of result; the Quadratic
  /// Expression Evaluator of Pixel-Planes 5 had ten (section 4.1). draw_splats in src/splat says how.
  int qee_bits = 0;
  Normalisation normalisation = Normalisation::constant;
  bool operator==(const KernelOptions&) const = default;
};

std::string name(KernelMethod method);
std::string name(Normalisation normalisation);

/// Throws InputError that names the option: phases or bits out of range or without effect, or an exact
/// normalisation of kernels that leave gaps between them (radius below 1).
void check(const KernelOptions& options, double radius);
/// Throws InputError when a table or fixed-point numbers cannot hold kernels as wide as these.
void check(const KernelOptions& options, const Footprint& footprint);

}  // namespace ringsplat
