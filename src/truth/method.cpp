#include "truth/method.hpp"

#include "truth/field.hpp"
#include "truth/sheet_method.hpp"
#include "truth/splat_method.hpp"

namespace ringsplat::truth {

std::vector<Rgba> method_truth(const Scene& scene, std::span<const Pixel> pixels) {
  return scene.sheets ? sheet_method_truth(scene, pixels) : splat_method_truth(scene, pixels);
}

ScreenBounds method_bounds(const Scene& scene) {
  return scene.sheets ? field_bounds(scene) : splat_method_bounds(scene);
}

}  // namespace ringsplat::truth
