#pragma once
#include <vector>

#include "app/role_choice.hpp"
#include "app/transfer_function_option.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/model/machine.hpp"
#include "ringsplat/net/collectives.hpp"
#include "ringsplat/net/transport.hpp"
#include "ringsplat/volume/source.hpp"
#include "scene/load.hpp"

/// What layouts are chosen by, measured.
namespace ringsplat::app {

/// The views of a run that are worth measuring: the first, and of long runs three, evenly spread.
std::vector<Camera> probe_views(const std::vector<Camera>& cameras);

/// Renders these views in this process, with a GP and a Renderer and then with a Renderer for each region,
/// and takes the quickest of a few repetitions. Counts the seconds that this thread has had a core, so that
/// others who use the machine change little.
///
/// A volume of more than 2²⁴ voxels is sampled: three slabs of z slices, whose costs stand for the others'.
/// So memory is bounded, but a file that has to be decoded in order is decoded once more up to the last slab.
/// With a `machine` nothing is measured: what its nodes would spend is charged for what the same frames
/// count. `frame` is what all frames share; its transfer function is made from the voxels read. Throws
/// InputError: unreadable, no finite value.
FrameCosts measure_frame_costs(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                               const std::vector<Camera>& views, const LoadOptions& load,
                               const Machine* machine = nullptr);

/// Seconds a message takes to the next rank: one goes round all ranks many times. All ranks call it, and do
/// so while no other message is on its way; the result is rank 0's. Zero on one rank.
double measure_hop(Transport& transport);

struct Places {
  int cores = 1;  ///< that the job's ranks share: on each machine its cores, or as many as there are ranks
  int machines = 1;
};
/// Where the job's ranks run. Collective.
Places count_places(Collectives& collectives);

/// What is known of this machine where no other rank is there to measure it, from docs/performance.md: a hop
/// takes 2.5 µs with a core for each rank; ranks that share cores wait for one, and what they render takes
/// longer.
RankCosts usual_rank_costs(int ranks, int cores);

/// What a hop takes on a described machine between neighbours on different hosts; its cores, or one for each
/// rank.
RankCosts described_rank_costs(const Machine& machine, int ranks);

}  // namespace ringsplat::app
