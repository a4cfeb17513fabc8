#pragma once
#include <memory>
#include <string>
#include <vector>

#include "engine_parts/frame_plan.hpp"
#include "frame/work_estimate.hpp"
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
int ranks_with_own_cores(const Machine& machine, int ranks);

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
std::vector<Camera> some_views(const std::vector<Camera>& cameras);

}  // namespace ringsplat::app
