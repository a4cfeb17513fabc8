#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "ringsplat/model/machine.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/node/frame_spec.hpp"

namespace ringsplat {

/// A state machine that is given messages and time and never blocks. Several live on one rank.
class Node {
 public:
  virtual ~Node() = default;
  virtual NodeId id() const = 0;
  /// A frame was announced; frames come in ascending order.
  virtual void begin_frame(const FrameSpec& spec) = 0;
  /// Nobody wants the frame any more: it ends as soon as its tokens have come round, without pictures.
  virtual void drop_frame(std::int64_t frame) = 0;
  /// Takes a message for this node. Early messages wait inside; stale ones throw RunError.
  virtual void receive(Message message) = 0;
  /// Does a bounded piece of work; false when there is none to do now.
  virtual bool advance() = 0;
  /// True between two pieces of one slice's work.
  virtual bool amid_slice() const { return false; }
  /// What this node waits for, in words; empty when for nothing.
  virtual std::string waiting_for() const = 0;
};

/// How nodes send: the host finds the way.
using Post = std::function<void(Message)>;

class Trace;

/// What is different when a run is about time or counts, not about pictures (docs/simulation.md).
struct SimulationOptions {
  std::optional<Machine> machine;  ///< whose costs the nodes charge to the simulated clock
  bool count_only = false;  ///< payloads have their true size but carry only counts, and nothing is drawn
  double voxel_weight = 1;  ///< with count_only: so many voxels of a slice for which each voxel stands
  double step_seconds = 0;  ///< above 0: payloads and tokens move in step, one step in so many seconds
};

struct ProtocolOptions {
  int frames_in_flight = 2;   ///< frames announced and not yet complete
  int slots = 4;              ///< payloads of one frame a Renderer accepts before it has drawn them
  int link_slots = 4;         ///< messages of one buffer class that may be behind a mesh's link; 1 is enough
  int look_ahead = 1;         ///< slices a GP prepares before their tokens have passed; 1 is the paper
  int send_ahead = 0;         ///< payloads of one Renderer that its token leaves behind before it waits until
                              ///< one is accepted, as far as there are slots; 0 is the paper; rings only
  int threads_per_rank = 1;   ///< that share a node's work; they never call MPI
  double stall_timeout = 60;  ///< seconds without any progress before a run is given up
  Trace* trace = nullptr;     ///< records what the nodes of this process do; must outlive them
  SimulationOptions simulation = {};
};

/// Throws InputError naming the option when a number is below 1 (or the timeout not positive) or no machine
/// has so many cores.
void check(const ProtocolOptions& options);

}  // namespace ringsplat
