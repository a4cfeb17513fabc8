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
  return {.voxel = voxel_weight * drawing_seconds(m, 1, 0, 0, 0),
          .pixel = drawing_seconds(m, 0, 0, 1, 0),
          .payload = drawing_seconds(m, 0, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel_weight * encoding_seconds(m, 1, 1, 0),
          .hollow = voxel_weight * encoding_seconds(m, 1, 0, 0)};
}

WorkCosts sheet_costs(const Machine& m, double voxel_weight, int bundle) {
  constexpr double side = CellRanges::side;
  const double voxel = voxel_weight / (side * side);
  return {.voxel = voxel * placing_seconds(m, 0, 1, 0),
          .pixel = painting_seconds(m, 1),
          .payload = placing_seconds(m, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel * selecting_seconds(m, 1, 1, 0),
          .hollow = voxel * selecting_seconds(m, 1, 0, 0),
          .block = side / std::sqrt(voxel_weight)};
}

glm::dvec2 narrowed(const glm::dvec2& half, double voxel_weight) {
  return glm::min(half, glm::max(half / std::sqrt(voxel_weight), glm::dvec2(narrowest_half_width)));
}

}  // namespace ringsplat
