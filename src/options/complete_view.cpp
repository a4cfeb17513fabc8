#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "frame/frame_geometry.hpp"
#include "frame/slices.hpp"
#include "options/option_tables.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

void stand_at(Camera& camera, Side side, World world) {
  // A patient who faces the viewer has his left, world +x, at the picture's right.
  const double left = world == World::patient ? 90 : -90;
  const glm::dvec2 angles[] = {{0, 0}, {180, 0}, {left, 0}, {-left, 0}, {0, 90}, {0, -90}};  // by side
  camera.azimuth = angles[static_cast<int>(side)].x;
  camera.elevation = angles[static_cast<int>(side)].y;
}

/// The lattice's extents along the world's axes; nothing when it lies askew.
std::optional<glm::dvec3> extents_in_world(const Grid& grid) {
  glm::dvec3 extents{0};
  for (int k = 0; k < 3; ++k) {
    const int axis = nearest_axis(grid.direction[k]);
    if (extents[axis] > 0) return std::nullopt;
    extents[axis] = grid.dims[k] * grid.spacing[k];
  }
  return extents;
}

/// The broad side of a volume whose front shows less than a third of it; of a patient, whom people expect to
/// face them, less than a fifth. A few axial slices are seen from the feet, sagittal ones from the left, as
/// radiologists do.
std::optional<Side> broad_side(const std::optional<glm::dvec3>& extents, bool patient) {
  const double flat = patient ? 5 : 3;
  if (!extents || !(extents->y > flat * std::min(extents->x, extents->z))) return std::nullopt;
  if (extents->x <= extents->z) return patient ? Side::left : Side::right;
  return patient ? Side::bottom : Side::top;
}

/// Of a solid two sides and the top say more than one side, of a plate they do not.
bool is_solid(std::optional<glm::dvec3> extents) {
  if (!extents) return true;
  std::sort(&extents->x, &extents->x + 3);
  return 3 * extents->x >= extents->y;
}

}  // namespace

std::string complete_view(RenderOptions& o, const Grid& grid, const VolumeNotes& notes) {
  Camera& camera = o.frame.shown.camera;
  if (o.side) stand_at(camera, *o.side, notes.world);
  const bool patient = notes.world == World::patient;
  if (o.slice || o.oblique_slice) {
    auto& planes = o.frame.shown.clip_planes;
    const LatticeFrame lattice = lattice_frame(grid);
    const Camera facing = o.slice ? facing_slices(lattice, *o.slice, patient)
                                  : facing_plane(lattice, planes.front().normal, planes.front().distance);
    if (o.oblique_slice && o.volume.mask.covered != Covered::alone)
      throw InputError("--mask-as: an oblique slice shows no labels", "give one across x, y or z");
    if (o.oblique_slice) planes = planes_of_slice(planes.front(), grid);
    camera.target = facing.target;
    camera.eye = facing.eye;
    camera.up = facing.up;
    camera.zoom *= facing.zoom;
  }
  if (o.cut_across)
    o.frame.shown.cut = plane_along_slices(grid, *o.cut_across, clip_box(o.cut_at, grid, notes)->first);
  if (o.direction_chosen) return {};
  const auto extents = extents_in_world(grid);
  const auto side = notes.world == World::microscope ? std::nullopt : broad_side(extents, patient);
  if (!side) {
    if (!patient && is_solid(extents)) camera.azimuth = 30, camera.elevation = 20;
    return {};
  }
  stand_at(camera, *side, notes.world);
  return fmt::format("the volume is flat: it is seen from the {}, --view front shows its narrow side",
                     name(*side));
}

}  // namespace ringsplat::app
