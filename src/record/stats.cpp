#include "record/stats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

using nlohmann::json;

constexpr const char* second_names[] = {"computing",   "waiting_for_token", "sending", "drawing",
                                        "compositing", "delivering",        "idle"};

struct Count {
  const char* name;
  std::uint64_t NodeStats::*part;
};
constexpr Count counts[] = {{"splats_sent", &NodeStats::splats_sent},
                            {"splats_drawn", &NodeStats::splats_drawn},
                            {"splats_clipped", &NodeStats::splats_clipped},
                            {"splats_hidden", &NodeStats::splats_hidden},
                            {"payloads_sent", &NodeStats::payloads_sent},
                            {"payloads_drawn", &NodeStats::payloads_drawn},
                            {"payload_bytes_sent", &NodeStats::payload_bytes_sent},
                            {"payload_bytes_received", &NodeStats::payload_bytes_received},
                            {"tokens_issued", &NodeStats::tokens_issued},
                            {"tokens_retired", &NodeStats::tokens_retired},
                            {"tokens_passed", &NodeStats::tokens_passed},
                            {"tiles", &NodeStats::tiles},
                            {"tile_bytes", &NodeStats::tile_bytes},
                            {"slices", &NodeStats::slices},
                            {"passes", &NodeStats::passes},
                            {"blocks", &NodeStats::blocks},
                            {"samples", &NodeStats::samples},
                            {"visible_voxels", &NodeStats::visible_voxels},
                            {"voxels_outside", &NodeStats::voxels_outside},
                            {"slice_memory", &NodeStats::slice_memory}};

json to_json(const NodeStats& stats) {
  json j;
  for (std::size_t k = 0; k < std::size(node_seconds); ++k)
    j["seconds"][second_names[k]] = stats.*node_seconds[k];
  for (const auto& count : counts) j[count.name] = stats.*count.part;
  j["peak_memory"] = stats.peak_memory;
  return j;
}

json node_json(NodeId node, const Layout& layout, const NodeStats& stats) {
  json j = to_json(stats);
  j["node"] = to_string(node);
  j["rank"] = layout.rank_of(node);
  return j;
}

json to_json(const LinkCounts& link) {
  return {{"messages", link.messages},           {"bytes", link.bytes},   {"payloads", link.payloads},
          {"payload_bytes", link.payload_bytes}, {"shared", link.shared}, {"waited", link.waited},
          {"wait_seconds", link.wait_seconds}};
}

}  // namespace

NodeStats& NodeStats::operator+=(const NodeStats& other) {
  for (const auto part : node_seconds) this->*part += other.*part;
  for (const auto& count : counts) this->*count.part += other.*count.part;
  peak_memory = std::max(peak_memory, other.peak_memory);
  return *this;
}

NodeStats FrameStats::total() const {
  NodeStats sum;
  for (const auto* group : {&gps, &renderers})
    for (const auto& stats : *group) sum += stats;
  return sum;
}

void check_conservation(const FrameStats& stats) {
  const NodeStats sum = stats.total();
  if (!stats.dropped && sum.splats_sent != sum.splats_drawn + sum.splats_clipped + sum.splats_hidden)
    throw RunError(fmt::format("frame {}: {} splats sent, but {} drawn, {} clipped and {} hidden",
                               stats.frame, sum.splats_sent, sum.splats_drawn, sum.splats_clipped,
                               sum.splats_hidden));
  if (sum.tokens_issued != sum.tokens_retired)
    throw RunError(fmt::format("frame {}: {} tokens issued, but {} retired", stats.frame, sum.tokens_issued,
                               sum.tokens_retired));
  if (sum.payload_bytes_sent != sum.payload_bytes_received)
    throw RunError(fmt::format("frame {}: {} bytes sent, but {} received", stats.frame,
                               sum.payload_bytes_sent, sum.payload_bytes_received));
}

std::string to_json_text(const FrameStats& stats, const Layout& layout, const std::string& settings,
                         char axis) {
  json j;
  j["frame"] = stats.frame;
  j["seconds"] = stats.seconds;
  j["period"] = stats.period;
  j["settings"] = json::parse(settings);
  j["layout"] = {{"gps", layout.gps},
                 {"renderers", layout.renderers},
                 {"ranks", layout.ranks()},
                 {"idle", layout.idle},
                 {"bundle", layout.bundle},
                 {"topology", layout.topology == Topology::ring ? "ring" : "mesh"},
                 {"roles", layout.placement == Placement::dedicated ? "dedicated" : "colocated"}};
  if (layout.topology == Topology::mesh) {
    j["layout"]["mesh"] = {layout.mesh_columns, layout.mesh_rows};
    j["layout"]["routing"] = layout.routing == Routing::manhattan ? "manhattan" : "direct";
  }
  j["traversal"] = {{"axis", std::string(1, axis)}, {"ascending", stats.ascending}, {"slices", stats.slices}};
  j["total"] = to_json(stats.total());
  if (layout.routed()) {
    j["links"] = json::array();
    for (const LinkCounts& link : stats.links) {
      json& one = j["links"].emplace_back(to_json(link));
      one["link"] = name(layout, link.link);
      one["from"] = link.link.from;
      one["to"] = neighbour(layout, link.link.from, link.link.direction).value();
    }
    j["links_total"] = to_json(total(stats.links));
  }
  j["nodes"] = json::array();
  for (std::size_t g = 0; g < stats.gps.size(); ++g)
    j["nodes"].push_back(node_json({Role::gp, int(g)}, layout, stats.gps[g]));
  for (std::size_t r = 0; r < stats.renderers.size(); ++r)
    j["nodes"].push_back(node_json({Role::renderer, int(r)}, layout, stats.renderers[r]));
  return j.dump();
}

}  // namespace ringsplat
