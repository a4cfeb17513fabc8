#pragma once
#include <cstddef>
#include <vector>

#include "ringsplat/net/layout.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::app {

class Hosts {
 public:
  Hosts(const Machine& machine, const Layout& layout);

  /// Whether more ranks work than there are cores.
  bool share_cores() const;
  /// The longest of all hosts' work over its cores. `seconds`: by rank.
  double shared_seconds(const std::vector<double>& seconds) const;
  /// Seconds of the busiest link, which at best is busy all the time, when GPs send Renderers so many bytes
  /// together, each of them as much.
  double link_seconds(double bytes) const;

 private:
  std::size_t host_of(int rank) const;

  const Machine& machine_;
  const Layout& layout_;
  int hosts_;
};

/// What each Renderer draws.
struct Shares {
  /// By layer and Renderer, of a slice: seconds for its payload besides what every payload costs, and seconds
  /// that may be spent later, between payloads.
  std::vector<std::vector<double>> of_layer, painted;
  std::vector<bool> has_tile;
  std::vector<double> pixels;  ///< that it delivers
};

/// Mean hops of messages between neighbours in the order of slices, and between a GP and a Renderer, there
/// and back.
struct MeanHops {
  double token = 1, payload = 1, accept = 1;
};
MeanHops mean_hops(const Layout& layout);

/// What every slice costs, in seconds.
struct TokenCosts {
  double slice = 0, message = 0;  ///< a Renderer, for a slice of a payload, and once for the payload
  double table = 0;               ///< a Renderer, with its first payload
  double hop = 0;                 ///< from sending a message without a payload to having it
  double wake = 0;                ///< until a rank that waited goes on
  double software = 0;            ///< a GP's for a token, its payload and accept
  double longest_piece = 0;       ///< computed before messages are taken
  double painting_piece = 0;      ///< the same, of work between payloads
  double pixel = 0;               ///< to deliver one
  MeanHops hops = {};             ///< of one hop each where messages are not handed on
};
/// What a machine's description says of them; a payload's slices are left out.
TokenCosts token_costs(const Machine& machine, const Layout& layout);

/// How one Renderer goes through the frame; times are seconds since its announcement.
struct Drawer {
  double token = 0;          ///< when its token has come from the slice before
  double drawn = 0;          ///< when all payloads that came are drawn
  std::vector<double> ends;  ///< of the last payloads, as many as there are slots
  std::size_t payloads = 0;
  int kept = 0;     ///< slices that are not painted
  double owed = 0;  ///< seconds of painting left for later
  double last = 0;  ///< seconds of the last payload
  double busy = 0;  ///< seconds in sum
};

/// When the tokens of one frame pass its slices: followed from slice to slice, Renderer by Renderer. Messages
/// that come to a rank that computes wait for half of its piece.
class TokenTimes {
 public:
  /// `shares` must outlive it.
  TokenTimes(const Machine& machine, const Layout& layout, int slots, const Shares& shares,
             const TokenCosts& costs);
  /// All tokens pass a bundle, whose GP needs so many seconds to encode it. `layers`: those of its slices.
  void pass(std::size_t gp, const std::vector<std::size_t>& layers, double encoding);
  /// After all slices: Renderers paint what is left and deliver their pixels.
  void deliver();

  double end() const;  ///< of the frame
  double busiest_gp() const;
  double busiest_renderer() const;
  std::vector<double> busy_ranks(const Layout& layout) const;

 private:
  struct Work {
    double now = 0, later = 0;
    int slices = 0;
  };
  double encode(std::size_t gp, double seconds);
  Work work_of(std::size_t renderer, const std::vector<std::size_t>& layers) const;
  double pass_on(std::size_t gp, std::size_t renderer, double here, const std::vector<std::size_t>& layers);
  double wait_at_gp(std::size_t gp, double now, bool awake);
  double wait_for_renderer(std::size_t renderer, double now, bool awake);
  double wake(std::size_t rank, double now);
  double wait_for_gp(std::size_t gp, double now) const;

  const Shares& shares_;
  TokenCosts costs_;
  bool colocated_;
  std::vector<Drawer> drawers_;
  std::vector<double> gp_free_, gp_busy_, encoding_;  ///< by GP; the last bundle's encoding
  std::vector<double> awake_;                         ///< by rank: when it goes on that was woken last
};

}  // namespace ringsplat::app
