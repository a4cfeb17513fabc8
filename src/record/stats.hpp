#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "net/mesh.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// What one node did for one frame. Sent as it is in its report.
struct NodeStats {
  // Seconds by what the node was doing; they add up to the node's part of the frame.
  double computing = 0, waiting_for_token = 0,
         sending = 0;  // GP: classify + shade + encode; slice ready, no token; payload not yet accepted
  double drawing = 0, compositing = 0, delivering = 0;  // Renderer
  double idle = 0;
  std::uint64_t splats_sent = 0, splats_drawn = 0, splats_clipped = 0, splats_hidden = 0;
  std::uint64_t payloads_sent = 0, payloads_drawn = 0;
  std::uint64_t payload_bytes_sent = 0, payload_bytes_received = 0;
  std::uint64_t tokens_issued = 0, tokens_retired = 0, tokens_passed = 0;
  std::uint64_t tiles = 0, tile_bytes = 0;
  std::uint64_t slices = 0, passes = 0;
  std::uint64_t blocks = 0, samples = 0;  ///< looked through (sheets); composited or painted by a Renderer
  std::uint64_t visible_voxels = 0, voxels_outside = 0;  ///< outside the image: not looked at, may be visible
  std::uint64_t peak_memory = 0;                         ///< bytes, of the process
  std::uint64_t slice_memory = 0;                        ///< bytes of slices held, GPs only
  NodeStats& operator+=(const NodeStats& other);         ///< keeps the larger peak
};

/// A node's seconds by its activity (record/trace.hpp), without one at the end.
inline constexpr double NodeStats::*node_seconds[] = {
    &NodeStats::computing,   &NodeStats::waiting_for_token, &NodeStats::sending, &NodeStats::drawing,
    &NodeStats::compositing, &NodeStats::delivering,        &NodeStats::idle};

struct FrameStats {
  std::int64_t frame = 0;
  double seconds = 0;     ///< announcement to last tile
  double period = 0;      ///< since the frame before was complete (the first: since it was announced)
  bool ascending = true;  ///< the order in which the slices were traversed
  int slices = 0;
  bool dropped = false;  ///< nobody wanted it: payloads were left out or not drawn
  std::vector<NodeStats> gps, renderers;
  std::vector<LinkCounts> links;  ///< of a mesh with manhattan routing, by rank
  NodeStats total() const {
    NodeStats sum;
    for (const auto* group : {&gps, &renderers})
      for (const auto& stats : *group) sum += stats;
    return sum;
  }
};

/// Throws RunError naming the sums unless splats sent = drawn + clipped + hidden, tokens issued = retired and
/// bytes sent = received.
void check_conservation(const FrameStats& stats);

nlohmann::json to_json(const Layout& layout);
/// One object (docs/formats.md, "Statistics"). `settings` is the frame's; `axis` names the slice set that was
/// traversed.
nlohmann::json to_json(const FrameStats& stats, const Layout& layout, const nlohmann::json& settings,
                       char axis);

}  // namespace ringsplat
