#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/session/session.hpp"

namespace ringsplat {

struct LiveOptions {
  std::string name = "simulation";    ///< of what is shown, for people
  std::string unit = {};              ///< of the grid's spacing; empty: unknown
  std::string address = "127.0.0.1";  ///< to listen at; others than this machine's reach another one
  int port = 0;                       ///< 0: any that is free
  /// As the options of `ringsplat serve`.
  std::vector<std::string> allowed_hosts = {}, allowed_origins = {}, allowed_frames = {};
  /// How long pictures may hold the simulation up, as a part of the time that it takes itself.
  double share = 0.05;
  double target_seconds = 0.04;  ///< for a picture of a view that moves
  /// What is seen first, but for the method. Without it: a function for the values there are, from the front
  /// at the right and above.
  std::optional<FrameSpec> frame = std::nullopt;
  glm::dvec3 background{0.0};  ///< linear
};

/// Shows the volume of a simulation in browsers while it runs. The simulation's own ranks draw it, between
/// steps:
///
///     ringsplat::Session session(comm);
///     ...                                   // set_grid(), add_block(), commit()
///     ringsplat::Live live(session);
///     live.offer("viscosity", viscosity, 0, 1);
///     if (session.rank() == 0) std::puts(live.url().c_str());
///     for (int step = 0; step < steps; ++step) {
///       solve(viscosity);
///       live.show(step, time);
///     }
///
/// Pages turn the volume as those of `ringsplat serve`, whose threads on rank 0 never call MPI. The page that
/// drives may hold the simulation, let it take single steps and change what it offers. While nobody looks a
/// call of show() costs one broadcast of a few bytes.
///
/// Where the session has ranks set aside (SessionOptions::visualisation_ranks) these draw, all the time, and
/// the simulation's ranks only give them blocks that they ask for:
///
///     if (session.visualises())
///       live.visualise();
///     else
///       for (...) ...                       // as above
class Live {
 public:
  /// `session`: with a committed volume; it must outlive this. Collective. Throws InputError on all ranks
  /// when the volume has no finite value, the first view cannot be drawn or the port cannot be had.
  explicit Live(Session& session, const LiveOptions& options = {});
  /// Tells pages that the simulation has ended. Collective only where ranks are set aside.
  ~Live();

  /// On rank 0 the page's address, with the token that lets in; elsewhere empty.
  const std::string& url() const;

  /// Lets pages change a number between `low` and `high`, from the next show() on; `value` must outlive this.
  /// All ranks offer the same in the same order.
  void offer(const std::string& name, double& value, double low, double high);
  /// Lets pages choose one of several, such as the field that update_block() is to show; `value` is its
  /// number, from 0.
  void offer(const std::string& name, double& value, const std::vector<std::string>& choices);

  /// Shows the session's blocks as they are now: after a step, whose number and time the page tells. Returns
  /// at once while nobody looks or pictures have had their share; else commits the blocks and draws one
  /// picture. While a page holds the simulation it draws as many as are wanted, and returns when the page
  /// lets it go on, or all pages are gone. Collective; throws as Session::commit() and Session::render().
  void show(std::int64_t step, double time = 0);

  /// On ranks that are set aside: draws what pages want until the others have no more steps, and let go of
  /// their Live. Throws as Session::commit(), and InputError on other ranks.
  void visualise();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ringsplat
