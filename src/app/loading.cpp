#include "app/loading.hpp"

#include <fmt/format.h>

#include "base/log.hpp"
#include "base/process.hpp"
#include "record/trace.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

OpenedVolume open(const VolumeOptions& volume, Launch& launch) {
  const Watched watched(launch.collectives(), fmt::format("opening {}", volume.path));
  return open_everywhere(
      launch.collectives(), [&] { return open_volume(volume); }, volume.path);
}

TransferFunction stand_in_function() {
  return {
      .name = "ramp", .colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}}, .opacities = {{0, 0}, {1, 1}}};
}

SliceMemory predict_memory(const Grid& grid, const LoadOptions& load, SliceDealing dealing) {
  SliceMemory memory{load.kept_axes, std::vector<std::uint64_t>(std::size_t(dealing.gps), 0)};
  for (const int factor : load.factors) {
    const Grid level = reduced_grid(grid, {factor, load.prefilter});
    for (int gp = 0; gp < dealing.gps; ++gp)
      memory.predicted[std::size_t(gp)] +=
          SliceStore::bytes_needed(level, gp, dealing, load.kept_axes, load.with_normals);
  }
  return memory;
}

namespace {

/// Of the GPs in this process.
double slice_bytes_here(const SliceMemory& slices, const Layout& layout, const Launch& launch) {
  double held = 0;
  for (int gp = 0; gp < layout.gps; ++gp)
    if (!launch.over_mpi() || layout.rank_of({Role::gp, gp}) == launch.rank())
      held += double(slices.predicted[std::size_t(gp)]);
  return held;
}

double picture_bytes_here(int width, int height, std::size_t pictures, const Launch& launch) {
  return launch.rank() == 0 ? 4.0 * sizeof(float) * width * height * double(pictures) : 0;
}

void check_memory(int width, int height, std::size_t pictures, const SliceMemory& slices,
                  const Layout& layout, const Launch& launch) {
  const double machine = machine_memory_bytes(), held = slice_bytes_here(slices, layout, launch),
               frames = picture_bytes_here(width, height, pictures, launch);
  if (held + frames <= machine) return;
  throw InputError(fmt::format("this needs {:.1f} GiB for slices and {:.1f} GiB for pictures in one process, "
                               "but the machine has {:.1f} GiB",
                               held / (1 << 30), frames / (1 << 30), machine / (1 << 30)),
                   held > frames ? "use more ranks on more machines, --axes needed or --shading none"
                                 : "use a smaller --size");
}

}  // namespace

std::size_t room_to_read_ahead(int width, int height, std::size_t pictures, const SliceMemory& slices,
                               const Layout& layout, const Launch& launch) {
  const double held = slice_bytes_here(slices, layout, launch),
               needed = 2 * held + picture_bytes_here(width, height, pictures, launch);
  return needed <= machine_memory_bytes() ? std::size_t(held) : 0;
}

SliceMemory settle_layout(RenderOptions& o, Layout& layout, const std::vector<Camera>& cameras,
                          const Grid& grid, const LoadOptions& load, std::size_t pictures,
                          const std::vector<Place>& places, Launch& launch, std::size_t volumes) {
  if (o.run.choose_roles) layout = choose_roles(o, cameras, grid, load, places, launch);
  o.frame.division.dealt_to = drawing_renderers(layout, places, launch);
  SliceMemory memory = predict_memory(grid, load, dealing_of(layout));
  for (std::uint64_t& bytes : memory.predicted) bytes *= volumes;
  launch.check_on_all_ranks(
      [&] { check_memory(o.frame.shown.width, o.frame.shown.height, pictures, memory, layout, launch); });
  return memory;
}

Scene load(OpenedVolume& volume, const LoadOptions& options, const Layout& layout, const Wiring& wiring,
           Progress& progress) {
  const PlainFloats as_before_the_first_frame;
  const Watched watched(wiring.collectives, fmt::format("reading {}", volume.name));
  progress.begin("loading", 1);
  LoadOptions told = options;
  told.told = [&](double part) {
    // Memory for the slices comes before, at no pace that tells of the rest.
    if (part == 0) progress.begin("loading", 1);
    progress.at(part);
  };
  Scene scene = load_scene(volume, told, layout, wiring);
  progress.end();
  volume.source.reset();
  if (scene.values.range.empty())
    throw InputError("the volume has no finite value: every voxel is not-a-number or infinite",
                     "check the file's --type and --endian");
  return scene;
}

void render_all(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                const Wiring& wiring, const EngineOptions& engine) {
  try {
    if (protocol.trace) protocol.trace->compare_clocks(wiring.collectives);
    render_frames(std::move(scene), layout, protocol, std::move(director), wiring, engine);
  } catch (const InputError& e) {
    throw RunError(e.what());
  }
}

void log_roles(const Layout& layout, const SliceMemory& memory, const Launch& launch) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (memory.kept_axes[std::size_t(axis)]) axes += name(axis);
  for (int rank = 0; rank < layout.ranks(); ++rank) {
    if (launch.over_mpi() && rank != launch.rank()) continue;
    for (const NodeId node : layout.nodes_on(rank))
      if (node.role == Role::gp)
        log_debug("{} keeps slices of axes {}: {:.1f} MiB", to_string(node), axes,
                  double(memory.predicted[std::size_t(node.index)]) / (1 << 20));
      else
        log_debug("{} is here", to_string(node));
  }
}

}  // namespace ringsplat::app
