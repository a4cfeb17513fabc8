#pragma once
#include <vector>

#include "forecast/role_choice.hpp"
#include "net/transport.hpp"
#include "options/transfer_function_option.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "scene/load.hpp"
#include "simulate/machine.hpp"

/// Measurements from which layouts are chosen.
namespace ringsplat::app {

/// The transfer function that a choice makes for the volume, of which it reads a part.
TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice);

/// The views of a run to measure: the first, or three evenly spread ones of a long run.
std::vector<Camera> probe_views(const std::vector<Camera>& cameras);

/// Renders these views in this process, with a GP and a Renderer and then with a Renderer for each region,
/// and takes the quickest of a few repetitions. Counts this thread's processor seconds, so that other users
/// of the machine change little.
///
/// A volume of more than 2²⁴ voxels is sampled by three sections of z slices, whose costs stand for the
/// others'. This bounds memory, but a file that must be decoded in order is decoded once more up to the last
/// section. With a `machine` nothing is measured: the frames' counts are charged at its nodes' costs. `frame`
/// is what all frames share; its transfer function is made from the voxels read. Throws InputError when the
/// volume is unreadable or has no finite value.
FrameCosts measure_frame_costs(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                               const std::vector<Camera>& views, LoadOptions load,
                               const Machine* machine = nullptr);

/// Seconds a message takes to the next rank, measured by one that goes round all ranks many times. All ranks
/// call it, while no other message is on its way; the result is valid on rank 0. Zero with one rank.
double measure_hop(Transport& transport);

/// Costs of this machine from docs/performance.md, for when there are no other ranks to measure with: a hop
/// takes 2.5 µs with a core for each rank; ranks that share cores wait for one, and rendering takes longer.
RankCosts usual_rank_costs(int ranks, int cores);

/// A described machine's cost of a hop between neighbours on different hosts, and its cores, or one for each
/// rank.
RankCosts described_rank_costs(const Machine& machine, int ranks);

}  // namespace ringsplat::app
