#include "record/stats_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "net/message.hpp"

namespace ringsplat {
namespace {

double busy_seconds(const NodeStats& s) { return s.computing + s.drawing + s.compositing + s.delivering; }
double waiting_seconds(const NodeStats& s) { return s.waiting_for_token + s.sending + s.idle; }
double megabytes(std::uint64_t bytes) { return double(bytes) / 1e6; }

}  // namespace

StatsTable::StatsTable(const Layout& layout)
    : layout_(layout), gps_(std::size_t(layout.gps)), renderers_(std::size_t(layout.renderers)) {}

void StatsTable::add(const FrameStats& frame) {
  ++frames_;
  for (std::size_t g = 0; g < frame.gps.size(); ++g) gps_.at(g) += frame.gps[g];
  for (std::size_t r = 0; r < frame.renderers.size(); ++r) renderers_.at(r) += frame.renderers[r];
}

std::string StatsTable::text(const char* items) const {
  std::string text =
      fmt::format("{} frame{}, sums\n{:>6}  {:<24}{:>10}{:>11}{:>7}{:>11}{:>13}{:>11}{:>15}{:>15}\n", frames_,
                  frames_ == 1 ? "" : "s", "rank", "nodes", "busy s", "waiting s", "busy", "sent MB",
                  "received MB", "memory MB", fmt::format("{} sent", items), fmt::format("{} drawn", items));
  for (int rank = 0; rank < layout_.working_ranks(); ++rank) {
    NodeStats sum;
    std::string nodes;
    double there = 0;  // a rank's nodes take turns: while one works the other waits
    for (const NodeId node : layout_.nodes_on(rank)) {
      if (node == frame_buffer_id) continue;
      const NodeStats& one = (node.role == Role::gp ? gps_ : renderers_).at(std::size_t(node.index));
      sum += one;
      there = std::max(there, busy_seconds(one) + waiting_seconds(one));
      nodes += (nodes.empty() ? "" : ", ") + to_string(node);
    }
    const double busy = busy_seconds(sum), waiting = std::max(0.0, there - busy);
    text +=
        fmt::format("{:>6}  {:<24}{:>10.3f}{:>11.3f}{:>5.0f} %{:>11.2f}{:>13.2f}{:>11.0f}{:>15}{:>15}\n",
                    rank, nodes, busy, waiting, busy > 0 ? 100 * busy / (busy + waiting) : 0.0,
                    megabytes(sum.payload_bytes_sent + sum.tile_bytes), megabytes(sum.payload_bytes_received),
                    megabytes(sum.peak_memory), sum.splats_sent, sum.splats_drawn);
  }
  if (layout_.idle > 0) text += fmt::format("{:>6}  idle\n", fmt::format("+{}", layout_.idle));
  return text;
}

}  // namespace ringsplat
