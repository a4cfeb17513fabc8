#pragma once
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "session/render_frames.hpp"

namespace ringsplat {

/// What ranks that draw want of a simulation on others, or it gives them; by weight.
enum class Want : std::uint8_t {
  nothing,
  news,  ///< how far it is
  step,  ///< its blocks, as they are after a step
  hold,  ///< the same, and then it waits
  end    ///< no more
};

/// Rank 0, which draws, asks the simulation's first rank, which answers at the end of a step.
struct Letter {
  Want want = Want::nothing;
  std::vector<double> values = {};  ///< of what is offered, as pages want them, or as they are
  bool lets_go = false;             ///< of a simulation that waits, which does this after the next step
  // Of the answer.
  std::int64_t step = 0;
  double time = 0;
  int steps = 0;  ///< since the last answer
};

/// Sends letters, for which nobody waits.
class Post {
 public:
  /// Between all of a session's ranks.
  explicit Post(Session& session) : transport_(*SessionParts::all(session).transport()) {}
  void send(int rank, const Letter& letter);
  std::optional<Letter> receive();
  Letter wait_for_letter();

 private:
  Transport& transport_;
};

/// Sets what is offered to what rank 0 says. The session's next collective call throws when that has others.
void take_values(Session& session, std::span<const double> values, std::span<double* const> offered);

/// What pictures may hold a simulation up for: a part of the time that it takes itself.
class TimeShare {
 public:
  explicit TimeShare(double part) : part_(part) {}
  void step_ends() { debt_ = std::max(0.0, debt_ - part_ * (now_seconds() - begun_)); }
  void spend(double seconds) { debt_ += seconds; }
  void step_begins() { begun_ = now_seconds(); }
  double debt() const { return debt_; }  ///< seconds spent beyond the share

 private:
  double part_, debt_ = 0, begun_ = now_seconds();
};

/// A simulation's rank where others are set aside to draw: it hands its blocks over after those steps that
/// they ask for. While they ask for nothing a step costs one broadcast of a few bytes.
class HandOver {
 public:
  /// `share`: of the simulation's own time that this may take.
  HandOver(Session& session, double share);
  /// Tells those that draw that there are no more steps, and waits until they know.
  ~HandOver();
  HandOver(const HandOver&) = delete;

  /// After a step. Collective among the simulation's ranks. Sets what is `offered` to what pages want.
  void show(std::int64_t step, double time, std::span<double* const> offered);

 private:
  Letter next_question();

  Session& session_;
  Collectives& ranks_;  ///< the simulation's
  Post post_;
  const bool answers_;  ///< the first rank
  TimeShare share_;
  Letter question_;  ///< not yet answered
  int steps_ = 0;    ///< since the last answer
};

}  // namespace ringsplat
