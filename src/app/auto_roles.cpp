#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "app/loading.hpp"
#include "app/places.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "forecast/forecast.hpp"
#include "forecast/sampled_volume.hpp"
#include "forecast/this_machine.hpp"
#include "net/blocks.hpp"
#include "net/launcher.hpp"
#include "program/layouts.hpp"

namespace ringsplat::app {
namespace {

std::vector<Layout> those_that_fit(std::vector<Layout> layouts, const Grid& grid, const LoadOptions& load) {
  const double machine = machine_memory_bytes();
  const auto too_large = [&](const Layout& layout) {
    return double(predict_memory(grid, load, dealing_of(layout)).predicted.front()) > machine;
  };
  std::vector<Layout> fitting;
  std::remove_copy_if(layouts.begin(), layouts.end(), std::back_inserter(fitting), too_large);
  // When none fits, the later check of the chosen layout's memory reports it.
  return fitting.empty() ? layouts : fitting;
}

void say_choice(const std::vector<Prediction>& predictions) {
  const Prediction& best = predictions.front();
  std::string others;
  if (predictions.size() > 1)
    others = fmt::format("; next {} with {:.2f} ms, last {} with {:.2f} ms", describe(predictions[1].layout),
                         1e3 * predictions[1].seconds, describe(predictions.back().layout),
                         1e3 * predictions.back().seconds);
  log_info("chose {}: {:.2f} ms a frame predicted, limited by {}{}", describe(best.layout),
           1e3 * best.seconds, name(best.limit), others);
}

/// What the real ranks run on. A hop says little of a machine where ranks wait for cores.
Machine machine_of(const std::vector<Place>& places, double hop) {
  const int hosts = hosts_of(places), ranks = int(places.size());
  Machine machine = this_machine(hosts, std::max(1, shared_cores(places) / hosts));
  if (!shares_cores(machine, ranks) && ranks > 1) machine.platform.latency = hop;
  return machine;
}

}  // namespace

Layout choose_roles(const RenderOptions& o, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, const std::vector<Place>& places, Launch& launch) {
  const auto& described = o.run.simulation.machine;
  const int ranks = launch.ranks();
  auto layouts =
      layouts_to_choose_from(o.run, launch.over_mpi(), ranks,
                             described ? ranks_with_own_cores(*described, ranks) : ranks_with_cores(places));
  if (!described) layouts = those_that_fit(std::move(layouts), grid, load);
  const double hop = described ? 0 : measure_hop(*launch.transport());
  Layout chosen;
  launch.check_on_rank_0([&] {
    const auto source = open_volume(o.volume);
    const Machine machine = described ? *described : machine_of(places, hop);
    Forecast forecast(*source, o.frame, TransferFunctionChoice(o.transfer_function, o.colour),
                      some_views(cameras.empty() ? std::vector{o.frame.shown.camera} : cameras), machine,
                      o.run.simulation.voxel_weight, ranks, o.run.protocol);
    const auto predictions =
        o.run.bundle || !described ? forecast.predict_all(layouts) : forecast.predict_bundles(layouts);
    chosen = predictions.front().layout;
    say_choice(predictions);
  });
  return value_of<Layout>(launch.collectives().broadcast(block_of_value(chosen), 0), "a layout");
}

int drawing_renderers(const Layout& layout, const std::vector<Place>& places, const Launch& launch) {
  // Dedicated Renderers have no other work; a simulated machine's cores are not this machine's.
  if (layout.placement != Placement::colocated || !launch.over_mpi() || simulated()) return layout.renderers;
  const int cores = shared_cores(places);
  return cores < layout.working_ranks() ? std::min(2 * cores, layout.renderers) : layout.renderers;
}

}  // namespace ringsplat::app
