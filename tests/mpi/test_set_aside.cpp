// Sessions with ranks set aside to draw.
#include <fmt/format.h>
#include <mpi.h>

#include "ringsplat/mpi/communicator.hpp"
#include "ringsplat/ringsplat.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr glm::ivec3 dims{23, 20, 26};

/// A slab of a volume that changes with the step.
struct Slab {
  Slab(int part, int parts) : first(dims.z * part / parts), end(dims.z * (part + 1) / parts) {}
  void take_step(int step) {
    values.resize(std::size_t(dims.x) * dims.y * std::size_t(end - first));
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t voxel = k + std::size_t(first) * dims.x * dims.y;
      values[k] = float((voxel * 7919 + std::size_t(step) * 101) % 1000);
    }
  }
  void add_to(Session& session) const {
    if (end > first) session.add_block({{0, 0, first}, {dims.x, dims.y, end}}, values.data());
  }
  int first, end;
  std::vector<float> values;
};

FrameSpec view(const Method& how) {
  FrameSpec spec = oblique_view(72, 60, 24);
  spec.how = how;
  spec.shown.transfer_function = ramp(100, 1000, 0.3);
  return spec;
}

/// What a session without MPI draws of a step.
Image alone(int step, const FrameSpec& spec) {
  Slab whole(0, 1);
  whole.take_step(step);
  Session session;
  session.set_grid(make_grid(dims, ScalarType::float32));
  whole.add_to(session);
  session.commit();
  return session.render(spec);
}

struct Job {
  Job() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  }
  int rank = 0, ranks = 1;
};

}  // namespace

TEST_CASE("ranks that are set aside draw the bits of what the others have") {
  const Job job;
  for (const int aside : {1, 2, job.ranks - 1}) {
    if (aside >= job.ranks) continue;
    Session session(MPI_COMM_WORLD, {}, {.visualisation_ranks = aside});
    REQUIRE(session.visualises() == (job.rank < aside));
    session.set_grid(make_grid(dims, ScalarType::float32));
    Slab slab(session.visualises() ? 0 : job.rank - aside, job.ranks - aside);
    slab.take_step(0);
    if (!session.visualises()) slab.add_to(session);
    for (int step = 0; step < 3; ++step) {
      slab.take_step(step);
      session.commit();
      for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
        INFO(fmt::format("{} of {} ranks set aside, step {}, {}", aside, job.ranks, step, name(how)));
        const Image image = session.render(view(how));
        const Image expected = job.rank == 0 ? alone(step, view(how)) : Image();
        const bool same = image == expected;
        REQUIRE(same);
      }
    }
    if (session.visualises())
      REQUIRE(session.range().high == 999);
    else
      REQUIRE(message_of([&] { session.range(); }).find("does not draw") != std::string::npos);
  }
}

TEST_CASE("what a rank without a picture gets wrong is thrown by commit() on all") {
  const Job job;
  if (job.ranks < 2) return;
  Session session(MPI_COMM_WORLD, {}, {.visualisation_ranks = 1});
  if (job.rank == job.ranks - 1) session.update_block(7, nullptr);
  session.set_grid(make_grid(dims, ScalarType::float32));
  REQUIRE(message_of([&] { session.commit(); }).find("there is no block 7") != std::string::npos);
  REQUIRE(message_of([&] { session.commit(); }).find("cover") != std::string::npos);
}

TEST_CASE("so many ranks as cannot be set aside are refused on all") {
  const Job job;
  for (const int aside : {-1, job.ranks, job.ranks + 3}) {
    const std::string message =
        message_of([&] { Session(MPI_COMM_WORLD, {}, {.visualisation_ranks = aside}); });
    INFO(message);
    REQUIRE(message.find(fmt::format("{} of {} ranks cannot be set aside", aside, job.ranks)) !=
            std::string::npos);
    REQUIRE(message.find("hint: ") != std::string::npos);
  }
  if (job.ranks < 2) return;
  const int own = job.rank == job.ranks - 1 ? 1 : 0;
  const std::string message = message_of([&] { Session(MPI_COMM_WORLD, {}, {.visualisation_ranks = own}); });
  INFO(message);
  REQUIRE(message.find(fmt::format("rank {} was given other roles", job.ranks - 1)) != std::string::npos);
}
