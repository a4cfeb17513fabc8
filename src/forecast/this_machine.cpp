#include <time.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "base/clock.hpp"
#include "base/log.hpp"
#include "base/output_file.hpp"
#include "base/process.hpp"
#include "forecast/forecast.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"
#include "session/render_frames.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Seconds, or how often the usual ones.
struct Spent {
  double gp = 0, renderer = 0;
};

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

Grid small_grid() { return {.dims = glm::ivec3(96), .type = ScalarType::uint8}; }

const TransferFunctionChoice& ramp() {
  static const TransferFunctionChoice choice("grey");
  return choice;
}

FrameSpec small_frame(const Method& how) {
  FrameSpec frame;
  frame.how = how;
  frame.shown.camera = {.azimuth = 30, .elevation = 20};
  frame.shown.width = frame.shown.height = 256;
  frame.shown.opaque_threshold = 0;
  return frame;
}

/// Of a few frames in this process that in which this thread had its core most; in processor seconds, so that
/// other users of the machine change little.
Spent measured(FrameSpec frame) {
  constexpr int repetitions = 6;
  const Grid grid = small_grid();
  OpenedVolume volume{grid, true, synth_source("ball", grid)};
  frame.shown.transfer_function = function_for(*volume.source, ramp());
  SoloCollectives solo;
  const Wiring wiring{solo};
  const Layout layout{.gps = 1, .renderers = 1};
  Scene scene = load_scene(volume, needed_to_render(frame, grid), layout, wiring);
  Spent calmest;
  int announced = 0;
  double cpu = 0, wall = 0, most = 0;
  const Director director{
      [&]() -> std::optional<FrameSpec> {
        if (announced++ == repetitions) return std::nullopt;
        cpu = thread_seconds();
        wall = now_seconds();
        return frame;
      },
      [&](FrameResult&& result) {
        const double share = std::min(1.0, (thread_seconds() - cpu) / std::max(1e-9, now_seconds() - wall));
        if (share <= most) return;
        most = share;
        const NodeStats sum = result.stats.total();
        calmest = {share * sum.computing, share * (sum.drawing + sum.compositing + sum.delivering)};
      }};
  render_frames(std::move(scene), layout, {.frames_in_flight = 1}, director, wiring);
  return calmest;
}

/// The costs by which real ranks deal regions, and usual ones of what these leave out.
Machine usual_machine() {
  constexpr double voxels_of_block = usual_sheet_costs.block * usual_sheet_costs.block;
  const WorkCosts &splats = usual_splat_costs, &sheets = usual_sheet_costs;
  Machine m;
  m.name = "this machine";
  m.gp = {.visible_voxel = splats.visible, .transparent_voxel = splats.hollow, .frame = 0.1e-3};
  m.renderer = {.splat = splats.voxel, .slice = splats.payload, .composite = splats.pixel, .pixel = 3e-9};
  m.sheets = {.look = voxels_of_block * sheets.hollow,
              .copy = voxels_of_block * (sheets.visible - sheets.hollow),
              .place = voxels_of_block * sheets.voxel,
              .slice = sheets.payload,
              .sample = sheets.pixel,
              .table = 1e-3};
  m.message.wake = 0.1e-3;
  m.poll_interval = 0.2e-3;
  // Sixteen ranks on two cores take 1.4 to 1.9 times as long as two.
  m.sharing = 1.4;
  m.platform = {.bandwidth = 1e10, .latency = 2.5e-6};
  return m;
}

/// What frames of the method take here, by what they would take usually.
Spent measured_ratio(const Method& how) {
  const FrameSpec frame = small_frame(how);
  const auto ball = synth_source("ball", small_grid());
  const FrameWork usual =
      Forecast(*ball, frame, ramp(), {frame.shown.camera}, usual_machine(), 1, 1, {}).work();
  const Spent here = measured(frame);
  return {here.gp / usual.gp, here.renderer / usual.renderer};
}

/// What GPs and Renderers spend on splats, then on sheets.
using Speed = std::array<double, 4>;

/// Identifies this build, as one version may be built more than once, on this host.
std::string build_and_host() {
  const fs::path program = "/proc/self/exe";
  std::error_code ignored;  // zeros when it cannot be read
  return fmt::format("{} {} {} {}", fs::file_size(program, ignored),
                     fs::last_write_time(program, ignored).time_since_epoch().count(), build_id(),
                     host_name());
}

/// In the user's cache folder (XDG base directory specification, which says to ignore a relative
/// XDG_CACHE_HOME); empty without a home folder.
fs::path file_for_machine() {
  const char *const cache = std::getenv("XDG_CACHE_HOME"), *const home = std::getenv("HOME");
  const bool has_cache = cache != nullptr && fs::path(cache).is_absolute();
  if (!has_cache && (home == nullptr || *home == '\0')) return {};
  const fs::path folder = has_cache ? fs::path(cache) : fs::path(home) / ".cache";
  return folder / "ringsplat" /
         fmt::format("machine-{:016x}.json", std::hash<std::string>{}(build_and_host()));
}

/// Nothing when there is no such file, or when it cannot be understood, of which it warns.
std::optional<Speed> kept_speed(const fs::path& file) try {
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  const auto speed = json::parse(in).at("measured").get<Speed>();
  if (!std::ranges::all_of(speed, [](double n) { return n > 0 && n < 1e6; }))
    throw std::domain_error("a measurement in it is impossible");
  return speed;
} catch (const std::exception& e) {
  log_warning("the machine {} cannot be used and is measured again: {}", file.string(), e.what());
  return {};
}

/// Only warns on failure: the next run then measures again.
void keep(const fs::path& file, const Speed& speed) try {
  if (file.empty()) return;
  fs::create_directories(file.parent_path());
  write_text(file, json{{"measured", speed}}.dump(1) + "\n");
} catch (const std::exception& e) {
  log_warning("the machine cannot be kept for the next run: {}; hint: XDG_CACHE_HOME says where", e.what());
}

/// Of this build on this host it is measured once.
Speed known_speed() {
  const fs::path file = file_for_machine();
  if (const auto kept = kept_speed(file)) return *kept;
  log_info("measuring what a core of this machine does");
  const Spent splats = measured_ratio(Splats{}), sheets = measured_ratio(sheets_of(usual_quality));
  const Speed speed{splats.gp, splats.renderer, sheets.gp, sheets.renderer};
  keep(file, speed);
  return speed;
}

}  // namespace

Machine this_machine(int hosts, int cores) {
  const auto [splat_gp, splat_renderer, sheet_gp, sheet_renderer] = known_speed();
  Machine m = usual_machine();
  for (double* cost : {&m.gp.visible_voxel, &m.gp.transparent_voxel}) *cost *= splat_gp;
  for (double* cost : {&m.renderer.splat, &m.renderer.slice, &m.renderer.composite, &m.renderer.pixel})
    *cost *= splat_renderer;
  for (double* cost : {&m.sheets.look, &m.sheets.copy}) *cost *= sheet_gp;
  for (double* cost : {&m.sheets.place, &m.sheets.slice, &m.sheets.sample, &m.sheets.table})
    *cost *= sheet_renderer;
  m.platform.hosts = hosts;
  m.platform.cores = cores;
  return m;
}

double measure_hop(Transport& transport) {
  const int ranks = transport.ranks(), rank = transport.rank(), next = (rank + 1) % ranks;
  if (ranks == 1) return 0;
  const int rounds = std::max(8, 200 / ranks);
  const auto pass_on = [&] {
    transport.send(next, Message({.kind = Kind::token, .source = rank, .destination = next}));
  };
  double begun = 0;
  if (rank == 0) pass_on();
  for (int taken = 0; taken < rounds;) {
    if (!transport.receive()) {
      transport.wait_next();
      continue;
    }
    transport.note_progress();
    if (++taken == 1) begun = now_seconds();  // in the first round ranks get connected
    if (rank != 0 || taken < rounds) pass_on();
  }
  const double hop = (now_seconds() - begun) / (rounds - 1) / ranks;
  while (!transport.sends_done()) transport.wait_next();
  return hop;
}

}  // namespace ringsplat::app
