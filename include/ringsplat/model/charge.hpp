#pragma once

namespace ringsplat {

/// True when this program runs under SimGrid's simulated MPI, whose clock charge() moves.
bool simulated();

/// Lets this rank compute for so many simulated seconds; does nothing outside of a simulation.
void charge(double seconds);

/// Work that was done at once but takes simulated time, which passes in pieces, so that a rank can look after
/// messages in between.
class Debt {
 public:
  /// `piece`: seconds charged at once, above 0.
  explicit Debt(double piece) : piece_(piece) {}
  void owe(double seconds) { owed_ += seconds; }
  /// Charges one piece; false when nothing is owed.
  bool pay();

 private:
  double piece_, owed_ = 0;
};

}  // namespace ringsplat
