#include <ringsplat/ringsplat.h>

#include <exception>
#include <string>

#include "base/text.hpp"
#include "mpi/session.hpp"
#include "ringsplat/base/error.hpp"
#include "words/block_session.hpp"

using namespace ringsplat;

struct ringsplat_session {
  words::BlockSession blocks;
  std::string url = {};
};

namespace {

thread_local std::string message;

/// Runs `work`; what it throws becomes a code and this thread's message.
template <class Work>
int guarded(const Work& work) {
  try {
    work();
    return 0;
  } catch (const InputError& e) {
    message = e.what();
    return RINGSPLAT_INPUT_ERROR;
  } catch (const std::exception& e) {
    message = e.what();
    return RINGSPLAT_RUN_ERROR;
  }
}

/// The same for calls that a rank makes by itself: what it gets wrong is known to the next collective call,
/// in which the others would wait for a rank that has ended.
template <class Work>
int guarded_alone(ringsplat_session* session, const Work& work) {
  const int code = guarded(work);
  if (code != 0) SessionParts::note_problem(session->blocks.session(), message);
  return code;
}

glm::ivec3 whole(const std::int32_t* xyz) { return {xyz[0], xyz[1], xyz[2]}; }
glm::dvec3 numbers(const double* xyz, double otherwise) {
  return xyz == nullptr ? glm::dvec3(otherwise) : glm::dvec3(xyz[0], xyz[1], xyz[2]);
}
std::optional<Strides> strides_of(const std::int64_t* xyz) {
  return xyz == nullptr ? std::nullopt : std::optional(Strides{xyz[0], xyz[1], xyz[2]});
}

std::vector<std::string> words_of(const char* options) {
  return detail::words_of(options == nullptr ? "" : options);
}

}  // namespace

const char* ringsplat_message() { return message.c_str(); }

int ringsplat_open(int communicator, ringsplat_session** session) {
  return ringsplat_open_aside(communicator, 0, session);
}

int ringsplat_open_aside(int communicator, int visualisation_ranks, ringsplat_session** session) {
  return guarded([&] {
    Processes processes = communicator == RINGSPLAT_ALONE ? Processes() : connected_by_number(communicator);
    const SessionOptions options{.visualisation_ranks = visualisation_ranks};
    *session = new ringsplat_session{{std::move(processes), {}, options, {}}};
  });
}

void ringsplat_close(ringsplat_session* session) { delete session; }

int ringsplat_set_grid(ringsplat_session* session, const std::int32_t* dims, const char* type,
                       const double* spacing, const double* origin) {
  return guarded_alone(session, [&] {
    Grid grid;
    grid.dims = whole(dims);
    grid.type = scalar_type_from(type);
    grid.spacing = numbers(spacing, 1);
    grid.origin = numbers(origin, 0);
    session->blocks.set_grid(grid, {});
  });
}

int ringsplat_add_block(ringsplat_session* session, const std::int32_t* first, const std::int32_t* end,
                        const void* first_voxel, const std::int64_t* strides) {
  return guarded_alone(session, [&] {
    session->blocks.session().add_block({whole(first), whole(end)}, first_voxel, strides_of(strides));
  });
}

int ringsplat_update_block(ringsplat_session* session, int block, const void* first_voxel,
                           const std::int64_t* strides) {
  return guarded_alone(
      session, [&] { session->blocks.session().update_block(block, first_voxel, strides_of(strides)); });
}

int ringsplat_commit(ringsplat_session* session) {
  return guarded([&] { session->blocks.commit(); });
}

int ringsplat_render(ringsplat_session* session, const char* options, const char* file) {
  return guarded([&] { session->blocks.draw(words_of(options), file); });
}

int ringsplat_act(ringsplat_session* session, const char* file, std::int64_t step) {
  return guarded([&] { session->blocks.act(file, step); });
}

int ringsplat_serve(ringsplat_session* session, const char* options, int port, double share) {
  return guarded(
      [&] { session->url = session->blocks.serve(words_of(options), {.port = port, .share = share}); });
}

const char* ringsplat_url(ringsplat_session* session) { return session->url.c_str(); }

int ringsplat_offer(ringsplat_session* session, const char* name, double* value, double low, double high) {
  return guarded_alone(session, [&] { session->blocks.live().offer(name, *value, low, high); });
}

int ringsplat_show(ringsplat_session* session, std::int64_t step, double time) {
  return guarded([&] { session->blocks.live().show(step, time); });
}

int ringsplat_visualise(ringsplat_session* session) {
  return guarded([&] { session->blocks.live().visualise(); });
}
