// Sessions with ranks set aside to draw.
#include <fmt/format.h>
#include <mpi.h>

#include "ringsplat/mpi/communicator.hpp"
#include "ringsplat/ringsplat.hpp"
#include "session/render_frames.hpp"
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
    session.set_grid(make_grid(dims, ScalarType::float32));
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

TEST_CASE("ranks that are set aside draw the bits of a step that the others hand over") {
  const Job job;
  for (const int aside : {1, 2, job.ranks - 1}) {
    Session session(MPI_COMM_WORLD, {}, {.visualisation_ranks = aside});
    const int solvers = job.ranks - aside;
    REQUIRE(session.visualises() == (job.rank >= solvers));
    const auto draws_as_alone = [&](int step) {
      for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
        const Image image = session.render(view(how));
        INFO(fmt::format("{} of {} ranks set aside, step {}, {}", aside, job.ranks, step, name(how)));
        if (job.rank == solvers)
          REQUIRE(image == alone(step, view(how)));
        else
          REQUIRE(image.rgba.empty());
      }
    };
    Slab slab(session.visualises() ? 0 : job.rank, solvers);
    slab.take_step(0);
    session.set_grid(make_grid(dims, ScalarType::float32));
    if (!session.visualises()) slab.add_to(session);
    session.commit();
    draws_as_alone(0);
    const ValueRange range = session.range();
    REQUIRE((range.low == 0 && range.high == 999));

    // Handed over as Live does it, without commit().
    SessionParts::divide(session, true);
    Transport& transport = SessionParts::transport(session);
    slab.take_step(1);
    if (session.visualises()) {
      for (int left = solvers; left > 0;) {
        if (const auto message = transport.receive()) {
          SessionParts::place(session, message->body());
          --left;
        } else {
          transport.wait_next();
        }
      }
      draws_as_alone(1);
    } else {
      auto packed = SessionParts::pack(session, sizeof(Header));
      for (std::size_t k = 0; k < packed.size(); ++k) {
        const Header header =
            make_header(Kind::payload, {Role::host, job.rank}, {Role::host, solvers + int(k)}, 0);
        transport.send(solvers + int(k), Message(header, std::move(packed[k])));
      }
      REQUIRE(message_of([&] { session.commit(); }).find("set aside") != std::string::npos);
      session.update_block(7, nullptr);
      REQUIRE(message_of([&] { SessionParts::pack(session, 0); }).find("no block 7") != std::string::npos);
      while (!transport.sends_done()) transport.wait_next();
    }
    SessionParts::divide(session, false);
    slab.take_step(2);
    session.commit();
    draws_as_alone(2);
  }
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
  const int own = job.rank == job.ranks - 1 ? 1 : 0;
  const std::string message = message_of([&] { Session(MPI_COMM_WORLD, {}, {.visualisation_ranks = own}); });
  INFO(message);
  REQUIRE(message.find(fmt::format("rank {} was given other roles", job.ranks - 1)) != std::string::npos);
}
