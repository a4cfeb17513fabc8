#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine_parts/frame_engine.hpp"
#include "frame/work_estimate.hpp"
#include "net/message.hpp"
#include "net/transport.hpp"
#include "options/transfer_function_option.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/volume/source.hpp"
#include "simulate/machine.hpp"
#include "volume/volume_sketch.hpp"

namespace ringsplat::app {

/// What a frame's work takes, in seconds of one core, with one GP and one Renderer.
struct FrameWork {
  double visible_voxels = 0, items = 0;
  const char* items_name = "splats";  ///< or "blocks"
  double gp = 0;                      ///< to classify, shade and encode all slices
  double frame = 0;                   ///< a GP's setup before its first slice
  double renderer = 0;                ///< to draw, composite and deliver
};

struct Prediction {
  Layout layout;
  double gp = 0;           ///< seconds of the busiest GP
  double renderer = 0;     ///< seconds of the busiest Renderer
  double shared = 0;       ///< the work of all ranks of a host over its cores
  double tokens = 0;       ///< passing the tokens through all slices
  double seconds = 0;      ///< of a frame
  const char* limit = "";  ///< "the GPs", "the Renderers" or "the cores"
};

/// "668005 visible voxels of 39.5 ns on a GP, 725382 splats of 59.1 ns on a Renderer, ...", for messages.
std::string describe(const FrameWork& work);
/// A line for each prediction, with a heading.
std::string to_table(const std::vector<Prediction>& predictions);

/// Foresees frames on a machine, of either method, from a sketch of the volume: it deals regions as the
/// program does, then follows every Renderer's token from slice to slice with what encoding, messages and
/// drawing cost, by layers of the sketch. A frame takes no less than its work takes a host's cores. Of links
/// it counts the bytes (ranks fill hosts in order); it ignores collisions.
class Forecast {
 public:
  /// `views`: the run's, or some of them. `voxel_weight`: as SimulationOptions'. `ranks`: about as many
  /// Renderers get regions. Throws InputError when voxels cannot be read or no view can be drawn.
  Forecast(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
           const std::vector<Camera>& views, const Machine& machine, double voxel_weight, int ranks,
           const ProtocolOptions& protocol);
  ~Forecast();

  FrameWork work();
  Prediction predict(const Layout& layout);
  /// The fastest first. Of many it first looks at some, then at those next to the fastest; at all meshes.
  std::vector<Prediction> predict_all(const std::vector<Layout>& layouts);
  /// The same with bundles of 1, 2, 4 … slices: of the fewest with which the fastest is within 1 % of the
  /// best.
  std::vector<Prediction> predict_bundles(const std::vector<Layout>& layouts);

 private:
  struct View;
  Prediction predict(const View& view, const Layout& layout);
  FrameGeometry dealt(const View& view, const Layout& layout);

  Machine machine_;
  ProtocolOptions protocol_;
  double voxel_weight_;
  bool sheets_;
  double bytes_of_voxel_ = 0;  ///< of a visible one's payload
  EngineSetup setup_;
  RegionDealer dealer_;
  std::vector<std::unique_ptr<View>> views_;
};

/// How many ranks have a core of their own where there are too few; 0 where each has one, or where the last
/// ranks may be all of a host's.
inline int ranks_with_own_cores(const Machine& machine, int ranks) {
  return machine.platform.hosts == 1 && shares_cores(machine, ranks) ? machine.platform.cores : 0;
}

/// This machine, as it would be described: the usual costs (frame/work_estimate.hpp) times what GPs and
/// Renderers of either method take here for a small ball, and so many hosts with so many cores each. What
/// they take is measured once, in some tenths of a second, and kept in the user's cache folder for this build
/// on this host.
Machine this_machine(int hosts, int cores);

/// Seconds a message takes to the next rank, measured by one that goes round all ranks many times. All ranks
/// call it, while no other message is on its way; the result is valid on rank 0. Zero with one rank.
double measure_hop(Transport& transport);

/// The transfer function that a choice makes for the volume: of one of more than 2²⁴ voxels from three
/// sections of z slices, which bounds memory. Throws InputError when the volume is unreadable or has no
/// finite value.
TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice);

/// The views of a run to foresee: the first, or three evenly spread ones of a long run.
inline std::vector<Camera> some_views(const std::vector<Camera>& cameras) {
  if (cameras.size() < 12) return {cameras.front()};
  return {cameras.front(), cameras[cameras.size() / 3], cameras[2 * cameras.size() / 3]};
}

class Hosts {
 public:
  Hosts(const Machine& machine, const Layout& layout)
      : machine_(machine),
        layout_(layout),
        hosts_(machine.platform.hosts > 0 ? machine.platform.hosts
                                          : (layout.ranks() - 1) / machine.platform.cores + 1) {}

  /// Whether more ranks work than there are cores.
  bool share_cores() const { return shares_cores(machine_, layout_.working_ranks()); }
  /// The longest of all hosts' work over its cores. `seconds`: by rank.
  double shared_seconds(const std::vector<double>& seconds) const {
    std::vector<double> work(std::size_t(hosts_), 0.0);
    for (std::size_t rank = 0; rank < seconds.size(); ++rank) work[host_of(int(rank))] += seconds[rank];
    return *std::max_element(work.begin(), work.end()) / machine_.platform.cores;
  }
  /// Seconds of the busiest link, which at best is busy all the time, when GPs send Renderers so many bytes
  /// together, each of them as much.
  double link_seconds(double bytes) const {
    const auto& platform = machine_.platform;
    if (platform.kind != PlatformKind::backbone && platform.kind != PlatformKind::fat_tree) return 0;
    std::vector<double> gps(std::size_t(hosts_), 0.0), renderers = gps;
    for (int g = 0; g < layout_.gps; ++g) gps[host_of(layout_.rank_of({Role::gp, g}))] += 1.0 / layout_.gps;
    for (int r = 0; r < layout_.renderers; ++r)
      renderers[host_of(layout_.rank_of({Role::renderer, r}))] += 1.0 / layout_.renderers;
    double most_of_host = 0, between_hosts = 0;
    for (std::size_t h = 0; h < gps.size(); ++h) {
      const double out = gps[h] * (1 - renderers[h]), in = renderers[h] * (1 - gps[h]);
      most_of_host = std::max({most_of_host, out, in});
      between_hosts += out;
    }
    const double shared =
        platform.backbone_bandwidth > 0 ? between_hosts * bytes / platform.backbone_bandwidth : 0;
    return std::max(most_of_host * bytes / platform.bandwidth, shared);
  }

 private:
  std::size_t host_of(int rank) const {
    return std::size_t(machine_.platform.hosts > 0 ? std::int64_t{rank} * hosts_ / layout_.ranks()
                                                   : rank / machine_.platform.cores);
  }

  const Machine& machine_;
  const Layout& layout_;
  int hosts_;
};

/// What each Renderer draws.
struct Shares {
  /// By layer and Renderer, of a slice: seconds for its payload besides what every payload costs, and seconds
  /// that may be spent later, between payloads.
  std::vector<std::vector<double>> of_layer, painted;
  std::vector<bool> has_tile;
  std::vector<double> pixels;  ///< that it delivers
};

/// Mean hops of messages between neighbours in the order of slices, and between a GP and a Renderer, there
/// and back.
struct MeanHops {
  double token = 1, payload = 1, accept = 1;
};
MeanHops mean_hops(const Layout& layout);

/// What every slice costs, in seconds.
struct TokenCosts {
  double slice = 0, message = 0;  ///< a Renderer, for a slice of a payload, and once for the payload
  double table = 0;               ///< a Renderer, with its first payload
  double hop = 0;                 ///< from sending a message without a payload to having it
  double wake = 0;                ///< until a rank that waited goes on
  double software = 0;            ///< a GP's for a token, its payload and accept
  double longest_piece = 0;       ///< computed before messages are taken
  double painting_piece = 0;      ///< the same, of work between payloads
  double pixel = 0;               ///< to deliver one, or to hand on a layer's
  double end = 0;                 ///< after all have delivered
  bool in_layers = false;         ///< tokens pass those slices only of which their Renderers get some
  MeanHops hops = {};             ///< of one hop each where messages are not handed on
};
/// What a machine's description says of them; a payload's slices are left out.
TokenCosts token_costs(const Machine& machine, const Layout& layout);

/// All tokens pass a bundle.
struct BundlePass {
  std::size_t gp = 0;
  std::vector<std::size_t> layers;  ///< of its slices
  double encoding = 0;              ///< seconds that its GP needs
};

/// Of one frame, in seconds.
struct TokenTimes {
  double end = 0, busiest_gp = 0, busiest_renderer = 0;
  std::vector<double> busy_ranks;
};

/// When the tokens of one frame pass its slices: followed from slice to slice, Renderer by Renderer. Messages
/// that come to a rank that computes wait for half of its piece.
TokenTimes token_times(const Machine& machine, const Layout& layout, int slots, const Shares& shares,
                       const TokenCosts& costs, const std::vector<BundlePass>& bundles);

}  // namespace ringsplat::app
