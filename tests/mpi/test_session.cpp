// Sessions: volumes in blocks on the job's ranks, rendered by them.
#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/log.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/mpi/communicator.hpp"
#include "ringsplat/ringsplat.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/message_of.hpp"
#include "support/random_blocks.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// The first ranks of the job, as a communicator; null elsewhere.
class Part {
 public:
  explicit Part(int ranks) {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_split(MPI_COMM_WORLD, rank < ranks ? 0 : MPI_UNDEFINED, rank, &comm_);
  }
  ~Part() {
    if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  MPI_Comm comm() const { return comm_; }
  bool mine() const { return comm_ != MPI_COMM_NULL; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
};

int world_ranks() {
  int ranks = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

struct Volume {
  Grid grid;
  std::vector<std::byte> voxels;
  std::unique_ptr<VolumeSource> source() const { return memory_source(grid, voxels); }
};

Volume jack(glm::ivec3 dims, ScalarType type = ScalarType::uint8) {
  Volume volume{make_grid(dims, type), {}};
  volume.voxels.resize(volume.grid.bytes());
  synth_source("jack", volume.grid)->read_slices(0, dims.z, volume.voxels);
  return volume;
}

FrameSpec view_from(double azimuth, Method how, const Volume& volume) {
  FrameSpec spec = oblique_view(72, 60, 24);
  spec.shown.camera.azimuth = azimuth;
  spec.how = how;
  Session alone;
  alone.set_grid(volume.grid);
  alone.add_block(whole_box(volume.grid), volume.voxels.data());
  alone.commit();
  const ValueRange range = alone.range();
  spec.shown.transfer_function = ramp(range.low + 0.1 * (range.high - range.low), range.high, 0.3);
  return spec;
}

std::size_t resident_bytes() {
  std::size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * std::size_t(sysconf(_SC_PAGESIZE));
}

/// This rank's blocks; the arrays must live until commit() has returned.
std::vector<BlockArray> add_blocks(Session& session, const Volume& volume, const std::vector<VoxelBox>& boxes,
                                   Dice& dice) {
  std::vector<BlockArray> mine;
  session.set_grid(volume.grid);
  for (const VoxelBox& box : boxes)
    if (dice.below(session.ranks()) == session.rank())
      mine.push_back(block_array(volume.grid, volume.voxels, box, dice));
    else
      static_cast<void>(block_array(volume.grid, volume.voxels, box, dice));  // the same dice on all ranks
  for (const BlockArray& block : mine) session.add_block(block.extent, block.first_voxel(), block.strides);
  return mine;
}

void add_one_block_each(Session& session, const Volume& volume) {
  session.set_grid(volume.grid);
  VoxelBox box = whole_box(volume.grid);
  box.first.z = volume.grid.dims.z * session.rank() / session.ranks();
  box.end.z = volume.grid.dims.z * (session.rank() + 1) / session.ranks();
  if (box.first.z < box.end.z)
    session.add_block(box,
                      volume.voxels.data() + std::size_t(box.first.z) * volume.grid.slice_bytes(Axis::z));
}

const Method splats = Splats{}, sheets = Sheets{};

}  // namespace

TEST_CASE("blocks of any decomposition give the bits of the volume's picture, with both engines") {
  Dice dice(7);
  int compared = 0;
  for (const ScalarType type : {ScalarType::uint8, ScalarType::int16, ScalarType::float32})
    for (int ranks = 1; ranks <= world_ranks(); ++ranks) {
      const Volume volume = jack({23, 20, 26}, type);
      const auto blocks = ranks % 3 == 0
                              ? lattice_of_blocks(whole_box(volume.grid), {1 + dice.below(4), ranks, 1})
                              : cut_up(whole_box(volume.grid), 1 + dice.below(2 * ranks), dice);
      const double azimuth = 33 + 90 * dice.below(2);
      const Part part(ranks);
      Dice dealing(unsigned(100 * ranks + int(type)));
      if (!part.mine()) continue;
      Session session(part.comm());
      const auto kept = add_blocks(session, volume, blocks, dealing);
      session.commit();
      for (const Method& how : {splats, sheets}) {
        const FrameSpec spec = view_from(azimuth, how, volume);
        const Image image = session.render(spec);
        INFO(fmt::format("{} ranks, {} blocks, {}, {}, azimuth {}", ranks, blocks.size(), name(how),
                         to_string(type), azimuth));
        if (session.rank() == 0)
          REQUIRE(image == render_loopback(*volume.source(), spec, 1, 1).image);
        else
          REQUIRE(image.rgba.empty());
        ++compared;
      }
    }
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  CHECK((rank != 0 || compared == 6 * world_ranks()));
}

TEST_CASE("a session draws any views one after another: other axes, levels, clip boxes, lit and unlit") {
  const Volume volume = jack({22, 25, 18});
  Session session(MPI_COMM_WORLD);
  add_one_block_each(session, volume);
  session.commit();
  std::vector<FrameSpec> frames;
  for (const Method& how : {sheets, splats})
    for (const double azimuth : {10.0, 95.0})
      for (const int factor : {1, 2, 4})
        for (const bool clipped : {false, true}) {
          FrameSpec spec = view_from(azimuth, how, volume);
          spec.shown.camera.elevation = factor == 4 ? 80 : 20;
          spec.shown.reduction = {factor, factor > 1 && azimuth > 50};
          spec.shown.shading = factor == 2 && clipped ? Shading::none : Shading::phong;
          if (clipped) spec.shown.clip = VoxelBox{{2, 3, 4}, {19, 22, 15}};
          frames.push_back(spec);
        }
  for (const FrameSpec& spec : frames) {
    const Image image = session.render(spec);
    INFO(to_json(spec).dump());
    if (session.rank() == 0) REQUIRE(image == render_loopback(*volume.source(), spec, 1, 1).image);
  }
}

TEST_CASE("several frames drawn in one call are those drawn one by one") {
  const Volume volume = jack({22, 25, 18});
  const int ranks = world_ranks(), renderers = std::max(1, ranks / 2);
  const Layout both{.gps = 1, .renderers = 1, .placement = Placement::colocated};
  const Layout apart{.gps = ranks - renderers, .renderers = renderers, .placement = Placement::dedicated};
  Session session(MPI_COMM_WORLD, ranks == 1 ? both : apart);
  add_one_block_each(session, volume);
  session.commit();
  std::vector<FrameSpec> frames;
  for (const double azimuth : {0.0, 60.0, 120.0}) frames.push_back(view_from(azimuth, sheets, volume));
  std::vector<Image> together, alone;
  session.render(frames, [&](Image&& image) { together.push_back(std::move(image)); });
  for (const FrameSpec& spec : frames) {
    Image image = session.render(spec);
    if (session.rank() == 0) alone.push_back(std::move(image));
  }
  REQUIRE(together == alone);
  REQUIRE(together.size() == (session.rank() == 0 ? 3U : 0U));
}

TEST_CASE("what the taker of images throws leaves the call on its rank, and the session can be used on") {
  const Volume volume = jack({16, 14, 15});
  Session session(MPI_COMM_WORLD);
  add_one_block_each(session, volume);
  session.commit();
  const std::vector<FrameSpec> frames(3, view_from(30, sheets, volume));
  bool thrown = false;
  try {
    session.render(frames, [](Image&&) { throw std::runtime_error("the disk is full"); });
  } catch (const std::runtime_error& e) {
    thrown = std::string(e.what()) == "the disk is full";
  }
  REQUIRE(thrown == (session.rank() == 0));
  const Image image = session.render(frames.front());
  if (session.rank() == 0) REQUIRE(image == render_loopback(*volume.source(), frames.front(), 1, 1).image);
}

TEST_CASE("a thousand time steps take no more memory than the first ones") {
  Volume volume = jack({24, 20, 22});
  Session session(MPI_COMM_WORLD);
  add_one_block_each(session, volume);
  std::size_t early = 0;
  const int steps = world_ranks() <= 4 ? 1000 : 200;
  for (int step = 0; step < steps; ++step) {
    session.commit();
    FrameSpec frame = view_from(step % 3 * 45, step % 2 == 0 ? sheets : splats, volume);
    frame.division = {};
    static_cast<void>(session.render(frame));
    if (step == steps / 5) early = resident_bytes();
  }
  // A leaked picture a step would be 50 MiB; address sanitizers keep freed memory.
#ifndef __SANITIZE_ADDRESS__
  REQUIRE(resident_bytes() < early + (std::size_t{4} << 20));
#else
  REQUIRE(early > 0);
#endif
}

TEST_CASE("the next time step is drawn after a commit, from the same memory or from another") {
  Volume first = jack({20, 22, 18}), second = first;
  for (std::byte& voxel : second.voxels) voxel = std::byte(255 - std::to_integer<int>(voxel));
  Session session(MPI_COMM_WORLD);
  const FrameSpec spec = view_from(33, sheets, first);
  const auto expect = [&](const Volume& volume) {
    const Image image = session.render(spec);
    if (session.rank() == 0) REQUIRE(image == render_loopback(*volume.source(), spec, 1, 1).image);
  };
  add_one_block_each(session, first);
  session.commit();
  expect(first);
  const int z = first.grid.dims.z * session.rank() / session.ranks();
  const bool has_block = z < first.grid.dims.z * (session.rank() + 1) / session.ranks();
  if (has_block)
    session.update_block(0, second.voxels.data() + std::size_t(z) * first.grid.slice_bytes(Axis::z));
  expect(first);
  session.commit();
  expect(second);
  second.voxels = first.voxels;
  session.commit();
  expect(first);
  const Volume larger = jack({26, 24, 31}, ScalarType::float64);
  add_one_block_each(session, larger);
  session.commit();
  const FrameSpec of_larger = view_from(100, splats, larger);
  const Image image = session.render(of_larger);
  if (session.rank() == 0) REQUIRE(image == render_loopback(*larger.source(), of_larger, 1, 1).image);
}

TEST_CASE("what one rank gets wrong is the same error on all, and the session is used on") {
  const Volume volume = jack({20, 22, 18});
  Session session(MPI_COMM_WORLD);
  const int last = session.ranks() - 1;
  const bool culprit = session.rank() == last;
  const FrameSpec spec = view_from(33, sheets, volume);
  const auto refused = [&](const std::string& words, const std::function<void()>& f) {
    const std::string message = message_of(f);
    INFO(message);
    REQUIRE(says(message, words));
  };
  refused("no volume yet", [&] { session.render(spec); });
  refused("no grid", [&] { session.commit(); });
  const auto expect_picture = [&] {
    const Image image = session.render(spec);
    if (session.rank() == 0) REQUIRE(image == render_loopback(*volume.source(), spec, 1, 1).image);
  };
  add_one_block_each(session, volume);
  session.commit();
  expect_picture();

  if (culprit) session.clear_blocks();
  refused("no block covers voxels", [&] { session.commit(); });
  expect_picture();  // the volume before
  add_one_block_each(session, volume);
  if (culprit) session.add_block({{3, 3, 3}, {4, 4, 4}}, volume.voxels.data());
  refused("overlap", [&] { session.commit(); });
  add_one_block_each(session, volume);
  if (culprit) session.add_block({{3, 3, 3}, {4, 4, 4}}, nullptr);
  refused("has no voxels: its pointer is null", [&] { session.commit(); });
  if (culprit) session.update_block(7, volume.voxels.data());
  refused("no block 7", [&] { session.render(spec); });
  expect_picture();
  Volume other = volume;
  if (culprit) other.grid.spacing.y = std::numeric_limits<double>::quiet_NaN();
  add_one_block_each(session, other);
  refused("spacing", [&] { session.commit(); });
  other.grid = volume.grid;
  if (culprit) other.grid.spacing.x = 2;
  add_one_block_each(session, other);
  if (last > 0) refused("spacing", [&] { session.commit(); });
  FrameSpec bad = spec;
  bad.shown.camera.zoom = 0;
  refused("zoom", [&] { session.render(bad); });
  refused("no-such-preset", [&] { session.transfer_function("no-such-preset"); });
  if (last > 0) refused("called commit()", [&] { culprit ? session.commit() : void(session.render(spec)); });

  add_one_block_each(session, volume);
  session.commit();
  expect_picture();
}

TEST_CASE("a rank that is late is named, and waited for") {
  if (world_ranks() == 1) return;
  const Volume volume = jack({20, 22, 18});
  Session session(MPI_COMM_WORLD, std::nullopt, {.stall_timeout = 0.5});
  const int last = session.ranks() - 1;
  add_one_block_each(session, volume);
  std::vector<std::string> said;
  if (session.rank() == 0)
    set_log_sink([&](LogLevel, const std::string& text) {
      said.push_back(text);
      MPI_Send(nullptr, 0, MPI_BYTE, last, 0, MPI_COMM_WORLD);
    });
  if (session.rank() == last) MPI_Recv(nullptr, 0, MPI_BYTE, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  session.commit();
  set_log_sink({});
  if (session.rank() == 0) {
    REQUIRE(said.size() == 1);
    INFO(said.front());
    REQUIRE(says(said.front(), fmt::format("rank {} has been late for commit() for ", last)));
    REQUIRE(says(said.front(), "does not answer; the others wait"));
  }
  const FrameSpec spec = view_from(33, sheets, volume);
  const Image image = session.render(spec);
  if (session.rank() == 0) REQUIRE(image == render_loopback(*volume.source(), spec, 1, 1).image);
}

TEST_CASE("a layout for another number of ranks is refused on all ranks") {
  const Volume volume = jack({20, 22, 18});
  Session session(MPI_COMM_WORLD, Layout{world_ranks() + 1, 1, Placement::dedicated});
  add_one_block_each(session, volume);
  const std::string message = message_of([&] { session.commit(); });
  INFO(message);
  REQUIRE(says(message, "GP(s)"));
}

namespace {

int handler_calls = 0;
void count_error(MPI_Comm*, int*, ...) { ++handler_calls; }

std::vector<void (*)(int)> signal_handlers() {
  std::vector<void (*)(int)> handlers;
  for (int number = 1; number < 32; ++number) {
    struct sigaction action {};
    if (sigaction(number, nullptr, &action) == 0) handlers.push_back(action.sa_handler);
  }
  return handlers;
}

}  // namespace

TEST_CASE("calls leave the caller's communicator, error handler, signals and floating point as they were") {
  const Volume volume = jack({20, 22, 18}, ScalarType::float32);
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  MPI_Errhandler mine = MPI_ERRHANDLER_NULL, after = MPI_ERRHANDLER_NULL;
  MPI_Comm_create_errhandler(count_error, &mine);
  MPI_Comm_set_errhandler(comm, mine);
  int message = 0, came = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Irecv(&message, 1, MPI_INT, MPI_ANY_SOURCE, MPI_ANY_TAG, comm, &request);
  const auto handlers = signal_handlers();
  // As simulations set it: rounding upwards, traps for invalid operations, denormals on.
  std::fenv_t before;
  std::fesetenv(FE_DFL_ENV);  // frames drawn before may have left denormals off
  std::fegetenv(&before);
  std::fesetround(FE_UPWARD);
  feenableexcept(FE_INVALID | FE_DIVBYZERO);
  volatile float denormal = std::numeric_limits<float>::denorm_min();
  {
    Session session(comm);
    add_one_block_each(session, volume);
    session.commit();
    for (const Method& how : {splats, sheets}) {
      FrameSpec spec = view_from(33, how, volume);
      const Image image = session.render(spec);
      const int rounding = std::fegetround(), traps = fegetexcept();
      const bool denormals = denormal * 2.0F > 0.0F;
      REQUIRE(rounding == FE_UPWARD);
      REQUIRE(traps == (FE_INVALID | FE_DIVBYZERO));
      REQUIRE(denormals);
      std::fesetenv(&before);
      const bool same = session.rank() != 0 || image == render_loopback(*volume.source(), spec, 1, 1).image;
      std::fesetenv(&before);
      REQUIRE(same);
      std::fesetround(FE_UPWARD);
      feenableexcept(FE_INVALID | FE_DIVBYZERO);
    }
    session.clear_blocks();
    REQUIRE(says(message_of([&] { session.commit(); }), "no block"));
    REQUIRE(fegetexcept() == (FE_INVALID | FE_DIVBYZERO));
  }
  std::fesetenv(&before);
  REQUIRE(signal_handlers() == handlers);
  MPI_Comm_get_errhandler(comm, &after);
  REQUIRE(after == mine);
  MPI_Test(&request, &came, MPI_STATUS_IGNORE);
  REQUIRE(came == 0);
  MPI_Cancel(&request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  REQUIRE(handler_calls == 0);
  MPI_Errhandler_free(&mine);
  MPI_Errhandler_free(&after);
  MPI_Comm_free(&comm);
}
