#include "study/truth_scene.hpp"

#include <variant>

namespace ringsplat::app {
namespace {

void set_method(truth::Scene& scene, const Splats& splats) {
  scene.sheets.reset();
  scene.radius = splats.kernel_radius;
  scene.normalisation = splats.kernel.normalisation;
}

void set_method(truth::Scene& scene, const Sheets& sheets) {
  scene.sheets = {sheets.slabs, sheets.light_points};
}

}  // namespace

void set_frame(truth::Scene& scene, const FrameSpec& spec) {
  scene.transfer_function = spec.shown.transfer_function;
  scene.nearest = spec.shown.interpolation == Interpolation::nearest;
  scene.camera = spec.shown.camera;
  scene.clip = spec.shown.clip;
  scene.width = spec.shown.width;
  scene.height = spec.shown.height;
  scene.shaded = spec.shown.shading == Shading::phong;
  scene.material = spec.shown.material;
  scene.light = spec.shown.light;
  scene.opacity_correction = spec.shown.opacity_correction;
  std::visit([&](const auto& how) { set_method(scene, how); }, spec.how);
}

}  // namespace ringsplat::app
