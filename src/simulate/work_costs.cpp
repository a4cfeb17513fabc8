#include "simulate/work_costs.hpp"

#include <cmath>
#include <glm/common.hpp>

#include "net/message.hpp"
#include "splat/footprint.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {

double payload_message_seconds(const Machine& m) {
  return sending_seconds(m, sizeof(Header)) + m.message.receive;
}

WorkCosts splat_costs(const Machine& m, double voxel_weight, int bundle) {
  return {voxel_weight * m.renderer.splat, m.renderer.composite,
          m.renderer.slice + payload_message_seconds(m) / bundle, voxel_weight * m.gp.visible_voxel,
          voxel_weight * m.gp.transparent_voxel};
}

WorkCosts sheet_costs(const Machine& m, double voxel_weight, int bundle) {
  constexpr double side = CellRanges::side;
  const double voxel = voxel_weight / (side * side);
  return {voxel * m.sheets.place,
          m.sheets.sample,
          m.sheets.slice + payload_message_seconds(m) / bundle,
          voxel * (m.sheets.copy + m.sheets.look),
          voxel * m.sheets.look,
          side / std::sqrt(voxel_weight)};
}

glm::dvec2 narrowed(const glm::dvec2& half, double voxel_weight) {
  return glm::min(half, glm::max(half / std::sqrt(voxel_weight), glm::dvec2(narrowest_half_width)));
}

}  // namespace ringsplat
