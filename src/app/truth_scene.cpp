#include "ringsplat/app/truth_scene.hpp"

namespace ringsplat::app {

void set_frame(truth::Scene& scene, const FrameSpec& spec) {
  scene.transfer_function = spec.transfer_function;
  scene.camera = spec.camera;
  scene.width = spec.width;
  scene.height = spec.height;
  scene.shaded = spec.shading == Shading::phong;
  scene.material = spec.material;
  scene.light = spec.light;
  scene.radius = spec.kernel_radius;
  scene.normalisation = spec.kernel.normalisation;
  scene.opacity_correction = spec.opacity_correction;
}

}  // namespace ringsplat::app
