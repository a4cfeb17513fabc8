#include "app/auto_roles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/log.hpp"
#include "base/process.hpp"
#include "forecast/machine_forecast.hpp"
#include "forecast/probe.hpp"
#include "net/blocks.hpp"
#include "net/launcher.hpp"
#include "program/progress.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat::app {
namespace {

std::vector<Layout> those_that_fit(std::vector<Layout> layouts, const Grid& grid, const LoadOptions& load) {
  const double machine = machine_memory_bytes();
  const auto too_large = [&](const Layout& layout) {
    return double(SliceStore::bytes_needed(grid, 0, dealing_of(layout), load.kept_axes, load.with_normals)) >
           machine;
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

void say(const FrameCosts& costs, const RankCosts& ranks, const std::vector<Prediction>& predictions) {
  log_info("measured {}; a message takes {:.1f} us, the ranks share {} core{}", describe(costs),
           1e6 * ranks.hop, ranks.cores, ranks.cores == 1 ? "" : "s");
  say_choice(predictions);
}

/// By the described machine's costs, which rank 0 works out.
Layout choose_on_machine(const RenderOptions& o, const std::vector<Camera>& cameras, const Machine& machine,
                         Launch& launch) {
  const auto layouts = layouts_to_choose_from(o.run, launch.over_mpi(), launch.ranks());
  Layout chosen;
  launch.check_on_rank_0([&] {
    const auto source = open_volume(o.volume);
    const MachineForecast forecast(*source, o.frame, TransferFunctionChoice(o.transfer_function, o.colour),
                                   probe_views(cameras.empty() ? std::vector{o.frame.shown.camera} : cameras),
                                   machine, o.run.simulation.voxel_weight, launch.ranks(), o.run.protocol);
    const auto predictions = o.run.bundle ? forecast.predict_all(layouts) : forecast.predict_bundles(layouts);
    chosen = predictions.front().layout;
    say_choice(predictions);
  });
  return value_of<Layout>(launch.collectives().broadcast(block_of_value(chosen), 0), "a layout");
}

}  // namespace

Layout choose_roles(const RenderOptions& o, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, const std::vector<Place>& places, Launch& launch) {
  if (const auto& machine = o.run.simulation.machine) return choose_on_machine(o, cameras, *machine, launch);
  auto layouts = layouts_to_choose_from(o.run, launch.over_mpi(), launch.ranks(), ranks_with_cores(places));
  if (std::holds_alternative<Sheets>(o.frame.how))
    if (const auto ring = colocated_ring(layouts)) {
      if (launch.rank() == 0)
        log_info("chose {} without a measurement: sheets are the Renderers' work, so each of them draws",
                 describe(*ring));
      return *ring;
    }
  layouts = those_that_fit(std::move(layouts), grid, load);
  RankCosts ranks = usual_rank_costs(launch.ranks(), shared_cores(places));
  ranks.hop = measure_hop(*launch.transport());
  Layout chosen;
  launch.check_on_rank_0([&] {
    Progress progress;
    progress.begin("measuring a frame", 0);
    const auto source = open_volume(o.volume);
    const auto views = probe_views(cameras.empty() ? std::vector{o.frame.shown.camera} : cameras);
    const FrameCosts costs = measure_frame_costs(
        *source, o.frame, TransferFunctionChoice(o.transfer_function, o.colour), views, load);
    progress.end();
    const auto predictions = predict_all(costs, ranks, layouts);
    chosen = predictions.front().layout;
    say(costs, ranks, predictions);
  });
  const Block block = launch.collectives().broadcast(block_of_value(chosen), 0);
  return value_of<Layout>(block, "a layout");
}

int drawing_renderers(const Layout& layout, const std::vector<Place>& places, const Launch& launch) {
  // Dedicated Renderers have no other work; a simulated machine's cores are not this machine's.
  if (layout.placement != Placement::colocated || !launch.over_mpi() || simulated()) return layout.renderers;
  const int cores = shared_cores(places);
  return cores < layout.working_ranks() ? std::min(2 * cores, layout.renderers) : layout.renderers;
}

}  // namespace ringsplat::app
