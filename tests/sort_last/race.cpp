/// Sort-last rendering, to be raced against the ring: every rank draws the picture of a section of slices
/// with the renderer's own painter, and IceT composites the pictures. On real ranks, or on SimGrid's.
#include <IceT.h>
#include <fmt/format.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "base/process.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/quality.hpp"
#include "images/image_io.hpp"
#include "net/launcher.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/formats/open.hpp"
#include "simulate/charge.hpp"
#include "sort_last/icet_communicator.hpp"
#include "sort_last/section_painter.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat::sort_last {
namespace {

struct Options {
  std::string volume, transfer_function, output, strategy = "radixk", machine;
  int size = 512, region = 0, frames = 1;
  bool even = false;
  double turn = 0;
  double voxel_weight = 1;
  int pixel_weight = 1;
  double blend_seconds_per_byte = 0, compress_seconds_per_pixel = 0;
  std::vector<double> spacing;
  FrameSpec spec{.how = Splats{}};
};

Options options_of(int argc, char** argv) {
  Options o;
  Shown& shown = o.spec.shown;
  std::string shading = "phong", engine = Splats::name;
  Splats splats;
  CLI::App app("Draws sections of slices on all ranks and composites them with IceT");
  app.add_option("volume", o.volume)->required();
  app.add_option("--tf", o.transfer_function, "a ParaView JSON file")->required();
  app.add_option("--spacing", o.spacing)->delimiter('x');
  app.add_option("--size", o.size)->check(CLI::Range(1, 1 << 15));
  app.add_option("--region", o.region);
  app.add_option("--azimuth", shown.camera.azimuth);
  app.add_option("--elevation", shown.camera.elevation);
  app.add_option("--zoom", shown.camera.zoom);
  app.add_option("--fov", shown.camera.fov, "degrees, in perspective");
  app.add_option("--turn", o.turn, "degrees of azimuth from frame to frame");
  app.add_option("--engine", engine)->check(CLI::IsMember({Splats::name, Sheets::name}));
  app.add_option("--shading", shading)->check(CLI::IsMember({"phong", "none"}));
  app.add_option("--radius", splats.kernel_radius);
  app.add_option("--strategy", o.strategy)->check(CLI::IsMember({"bswap", "radixk", "tree"}));
  app.add_option("--frames", o.frames)->check(CLI::PositiveNumber);
  app.add_flag("--even", o.even, "sections that cost the same, by a frame that is drawn before");
  app.add_option("--machine", o.machine, "what is simulated");
  app.add_option("--voxel-weight", o.voxel_weight);
  app.add_option("--pixel-weight", o.pixel_weight)->check(CLI::PositiveNumber);
  app.add_option("--blend-seconds-per-byte", o.blend_seconds_per_byte);
  app.add_option("--compress-seconds-per-pixel", o.compress_seconds_per_pixel);
  app.add_option("-o,--output", o.output, "the last frame's picture");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    throw InputError(e.what(), "call it with --help");
  }
  shown.width = shown.height = o.size;
  shown.shading = shading == "phong" ? Shading::phong : Shading::none;
  shown.transfer_function = read_transfer_function(o.transfer_function);
  // Runs that only count leave out nothing behind opaque pixels, and this one is compared with them.
  if (!o.machine.empty()) shown.opaque_threshold = 0;
  if (engine == Splats::name)
    o.spec.how = splats;
  else
    o.spec.how = sheets_of(Quality::best);
  o.spec.division.region_size = o.region;
  check(o.spec);
  return o;
}

IceTEnum strategy_of(const std::string& name) {
  if (name == "bswap") return ICET_SINGLE_IMAGE_STRATEGY_BSWAP;
  if (name == "tree") return ICET_SINGLE_IMAGE_STRATEGY_TREE;
  return ICET_SINGLE_IMAGE_STRATEGY_RADIXK;
}

void prepare(const Options& o) {
  icetSetColorFormat(ICET_IMAGE_COLOR_RGBA_FLOAT);
  icetSetDepthFormat(ICET_IMAGE_DEPTH_NONE);
  icetCompositeMode(ICET_COMPOSITE_MODE_BLEND);
  icetEnable(ICET_ORDERED_COMPOSITE);
  icetStrategy(ICET_STRATEGY_SEQUENTIAL);
  icetSingleImageStrategy(strategy_of(o.strategy));
  icetResetTiles();
  icetAddTile(0, 0, o.size, o.size, 0);
}

/// Front to back.
void set_order(bool ascending, int ranks) {
  std::vector<IceTInt> order(static_cast<std::size_t>(ranks));
  std::iota(order.begin(), order.end(), 0);
  if (!ascending) std::reverse(order.begin(), order.end());
  icetCompositeOrder(order.data());
}

/// A frame's seconds and what passed, on one rank.
struct Frame {
  double seconds = 0, painting = 0, compositing = 0, blending = 0, compressing = 0;
  double items = 0, pixels = 0, messages = 0, bytes = 0;
};

double icet_seconds(IceTEnum what) {
  IceTDouble seconds = 0;
  icetGetDoublev(what, &seconds);
  return seconds;
}

std::uint64_t hash_of(const Image& image) {
  std::uint64_t hash = 1469598103934665603U;
  for (const float value : image.rgba) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 1099511628211U;
  }
  return hash;
}

class Race {
 public:
  Race(const Options& o, MPI_Comm comm) : o_(o), comm_(comm) {
    MPI_Comm_rank(comm, &rank_);
    MPI_Comm_size(comm, &ranks_);
    if (!o.machine.empty()) machine_ = read_machine(o.machine);
    traffic_.weight = o.pixel_weight;
    if (machine_) {
      traffic_.send = machine_->message.send;
      traffic_.receive = machine_->message.receive;
      traffic_.seconds_per_byte = o.blend_seconds_per_byte;
    }
    RawDescription raw;
    if (o.spacing.size() == 3) raw.spacing = glm::dvec3(o.spacing[0], o.spacing[1], o.spacing[2]);
    source_ = open_volume(o.volume, raw);
    traversal_ = make_geometry(o.spec, source_->grid()).traversal;
    if (of_sheets())
      find_range();
    else
      traversal_.axis = Axis::z;
    take_section(section_of(rank_, ranks_, source_->grid().slices(traversal_.axis)));
    const IceTCommunicator communicator = make_icet_communicator(comm, traffic_);
    context_ = icetCreateContext(communicator);
    destroy_icet_communicator(communicator);
    prepare(o);
    set_order(traversal_.ascending, ranks_);
    if (o.even) deal_evenly();
  }

  Frame frame() {
    const Image before(o_.size, o_.size);
    picture_ = before;
    const Traffic passed = traffic_;
    barrier();
    Frame f;
    const double start = MPI_Wtime();
    const Drawn drawn = painter_->draw(o_.spec, picture_);
    f.painting = MPI_Wtime() - start;
    composite(drawn, f);
    o_.spec.shown.camera.azimuth += o_.turn;
    ++o_.spec.frame;
    f.seconds = MPI_Wtime() - start;
    f.compositing = f.seconds - f.painting;
    f.items = drawn.items;
    f.pixels = double(drawn.reached.width()) * double(drawn.reached.height());
    f.messages = double(traffic_.messages - passed.messages);
    f.bytes = double(traffic_.bytes - passed.bytes);
    return f;
  }

  double slice_memory() const { return double(painter_->slice_memory()); }
  const Image& picture() const { return picture_; }

 private:
  bool of_sheets() const { return std::holds_alternative<Sheets>(o_.spec.how); }

  void take_section(const Section& section) {
    painter_.reset();
    const SectionSetup setup{*source_, section, machine_, o_.voxel_weight, double(o_.pixel_weight)};
    painter_ = of_sheets() ? make_sheet_section(setup, traversal_.axis, low_, high_)
                           : make_splat_section(setup, o_.spec.shown.shading == Shading::phong);
  }

  /// Of the whole volume's values, each rank looking at some of the z slices.
  void find_range() {
    const Grid& grid = source_->grid();
    const Section part = section_of(rank_, ranks_, grid.dims.z);
    std::vector<std::byte> slice(grid.slice_bytes(Axis::z));
    for (int z = part.first; z < part.end; ++z) {
      source_->read_slices(z, 1, slice);
      const SliceRange range = slice_range({Axis::z, z, grid.dims.x, grid.dims.y, grid.type, slice.data()});
      low_ = std::min(low_, range.low);
      high_ = std::max(high_, range.high);
    }
    MPI_Allreduce(MPI_IN_PLACE, &low_, 1, MPI_DOUBLE, MPI_MIN, comm_);
    MPI_Allreduce(MPI_IN_PLACE, &high_, 1, MPI_DOUBLE, MPI_MAX, comm_);
  }

  void deal_evenly() {
    Image picture(o_.size, o_.size);
    std::vector<double> costs = painter_->draw(o_.spec, picture).costs;
    MPI_Allreduce(MPI_IN_PLACE, costs.data(), int(costs.size()), MPI_DOUBLE, MPI_SUM, comm_);
    take_section(section_of(rank_, ranks_, costs));
  }

  void barrier() {
    MPI_Barrier(comm_);
    icetSetContext(context_);
  }

  void composite(const Drawn& drawn, Frame& f) {
    const PixelRect& r = drawn.reached;
    if (machine_)
      charge(o_.compress_seconds_per_pixel * o_.pixel_weight * double(r.width()) * double(r.height()));
    icetSetContext(context_);
    // IceT has the bottom row first, and whatever row comes first here does it no harm.
    const IceTInt valid[4] = {r.x0, r.y0, r.width(), r.height()};
    const IceTFloat background[4] = {0, 0, 0, 0};
    const IceTImage image =
        icetCompositeImage(picture_.rgba.data(), nullptr, valid, nullptr, nullptr, background);
    icetSetContext(context_);
    f.blending = icet_seconds(ICET_BLEND_TIME);
    f.compressing = icet_seconds(ICET_COMPRESS_TIME);
    if (rank_ == 0)
      std::memcpy(picture_.rgba.data(), icetImageGetColorcf(image), picture_.rgba.size() * sizeof(float));
  }

  Options o_;
  MPI_Comm comm_;
  int rank_ = 0, ranks_ = 1;
  std::optional<Machine> machine_;
  Traffic traffic_;
  std::unique_ptr<VolumeSource> source_;
  Traversal traversal_;                       ///< its axis: that of the sections
  double low_ = INFINITY, high_ = -INFINITY;  ///< of the volume's values
  std::unique_ptr<SectionPainter> painter_;
  IceTContext context_ = nullptr;
  Image picture_;
};

double reduced(double value, MPI_Op op, MPI_Comm comm) {
  double all = 0;
  MPI_Reduce(&value, &all, 1, MPI_DOUBLE, op, 0, comm);
  return all;
}

void run(int argc, char** argv, MPI_Comm comm) {
  const Options o = options_of(argc, argv);
  int rank = 0, ranks = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  flush_denormals();
  Race race(o, comm);
  std::string lines;
  for (int k = 0; k < o.frames; ++k) {
    const Frame f = race.frame();
    const auto most = [&](double value) { return reduced(value, MPI_MAX, comm); };
    const auto sum = [&](double value) { return reduced(value, MPI_SUM, comm); };
    const double seconds = most(f.seconds), painting = most(f.painting), mean = sum(f.painting) / ranks;
    const double compositing = most(f.compositing), blending = sum(f.blending),
                 compressing = sum(f.compressing);
    const double pixels = sum(f.pixels);
    const double items = sum(f.items), messages = sum(f.messages), bytes = sum(f.bytes),
                 most_bytes = most(f.bytes);
    // A simulation is one process.
    const double memory = simulated() ? 0 : double(peak_memory_bytes());
    const double memory_most = most(memory), memory_sum = sum(memory), slices = sum(race.slice_memory());
    if (rank == 0)
      lines += fmt::format(
          "{{\"ranks\": {}, \"strategy\": \"{}\", \"even\": {}, \"seconds\": {:.9g}, \"painting_most\": "
          "{:.9g}, "
          "\"painting_mean\": {:.9g}, \"compositing\": {:.9g}, \"blending\": {:.9g}, \"compressing\": "
          "{:.9g}, "
          "\"items\": {:.0f}, \"pixels\": {:.0f}, \"messages\": {:.0f}, \"bytes\": {:.0f}, \"bytes_most\": "
          "{:.0f}, "
          "\"memory_most\": {:.0f}, \"memory_sum\": {:.0f}, \"slice_memory\": {:.0f}, \"picture\": "
          "\"{:016x}\"}}\n",
          ranks, o.strategy, o.even, seconds, painting, mean, compositing, blending, compressing, items,
          pixels, messages, bytes, most_bytes, memory_most, memory_sum, slices, hash_of(race.picture()));
  }
  if (rank == 0) fmt::print("{}", lines);
  if (rank == 0 && !o.output.empty()) write_image(race.picture(), o.output, std::nullopt, {});
}

}  // namespace
}  // namespace ringsplat::sort_last

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int code = 0;
  try {
    ringsplat::sort_last::run(argc, argv, MPI_COMM_WORLD);
  } catch (const std::exception& e) {
    fmt::print(stderr, "sort_last: error: {}\n", e.what());
    code = 2;
  }
  // After the handler: MPI must not be called within one under SimGrid.
  if (code != 0) MPI_Abort(MPI_COMM_WORLD, code);
  MPI_Finalize();
  return code;
}
