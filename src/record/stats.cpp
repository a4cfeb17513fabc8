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

constexpr std::pair<const char*, std::uint64_t NodeStats::*> counts[] = {
    {"splats_sent", &NodeStats::splats_sent},
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
  for (const auto& [name, part] : counts) j[name] = stats.*part;
  j["peak_memory"] = stats.peak_memory;
  return j;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LinkCounts, messages, bytes, payloads, payload_bytes, shared, waited,
                                   wait_seconds)

NodeStats& NodeStats::operator+=(const NodeStats& other) {
  for (const auto part : node_seconds) this->*part += other.*part;
  for (const auto& [name, part] : counts) this->*part += other.*part;
  peak_memory = std::max(peak_memory, other.peak_memory);
  return *this;
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

json to_json(const Layout& layout) {
  json j{{"gps", layout.gps},
         {"renderers", layout.renderers},
         {"ranks", layout.ranks()},
         {"idle", layout.idle},
         {"bundle", layout.bundle},
         {"topology", layout.topology == Topology::ring ? "ring" : "mesh"},
         {"roles", layout.placement == Placement::dedicated ? "dedicated" : "colocated"}};
  if (layout.topology == Topology::mesh) {
    j["mesh"] = {layout.mesh_columns, layout.mesh_rows};
    j["routing"] = layout.routing == Routing::manhattan ? "manhattan" : "direct";
  }
  return j;
}

json to_json(const FrameStats& stats, const Layout& layout, const json& settings, char axis) {
  json j;
  j["frame"] = stats.frame;
  j["seconds"] = stats.seconds;
  j["period"] = stats.period;
  j["settings"] = settings;
  j["layout"] = to_json(layout);
  j["traversal"] = {{"axis", std::string(1, axis)}, {"ascending", stats.ascending}, {"slices", stats.slices}};
  j["total"] = to_json(stats.total());
  if (layout.routed()) {
    j["links"] = json::array();
    for (const LinkCounts& link : stats.links) {
      json& one = j["links"].emplace_back(link);
      one["link"] = name(layout, link.link);
      one["from"] = link.link.from;
      one["to"] = neighbour(layout, link.link.from, link.link.direction).value();
    }
    j["links_total"] = total(stats.links);
  }
  j["nodes"] = json::array();
  for (const auto& [role, nodes] : {std::pair(Role::gp, &stats.gps), {Role::renderer, &stats.renderers}})
    for (std::size_t k = 0; k < nodes->size(); ++k) {
      const NodeId node{role, int(k)};
      json& one = j["nodes"].emplace_back(to_json((*nodes)[k]));
      one["node"] = to_string(node);
      one["rank"] = layout.rank_of(node);
    }
  return j;
}

}  // namespace ringsplat
