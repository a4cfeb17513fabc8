#include "app/truth_scene.hpp"

namespace ringsplat::app {

void set_frame(truth::Scene& scene, const FrameSpec& spec) {
  scene.transfer_function = spec.shown.transfer_function;
  scene.camera = spec.shown.camera;
  scene.width = spec.shown.width;
  scene.height = spec.shown.height;
  scene.shaded = spec.shown.shading == Shading::phong;
  scene.material = spec.shown.material;
  scene.light = spec.shown.light;
  scene.radius = spec.as<Splats>().kernel_radius;
  scene.normalisation = spec.as<Splats>().kernel.normalisation;
  scene.opacity_correction = spec.shown.opacity_correction;
}

}  // namespace ringsplat::app
