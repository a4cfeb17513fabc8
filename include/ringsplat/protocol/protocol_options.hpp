#pragma once

namespace ringsplat {

class Trace;

/// How far frames, slices and payloads may run ahead; none of it changes a picture.
struct ProtocolOptions {
  int frames_in_flight = 2;   ///< frames announced and not yet complete
  int slots = 4;              ///< payloads of one frame a Renderer accepts before it has drawn them
  int link_slots = 4;         ///< messages of one buffer class that may be behind a mesh's link; 1 is enough
  int look_ahead = 1;         ///< slices a GP prepares before their tokens have passed; 1 is the paper
  int send_ahead = 0;         ///< payloads of one Renderer that its token leaves behind before it waits until
                              ///< one is accepted, as far as there are slots; 0 is the paper; rings only
  double stall_timeout = 60;  ///< seconds without any progress before a run is given up
  Trace* trace = nullptr;     ///< records what the nodes of this process do; must outlive them
};

/// Throws InputError naming the option when a number is below 1 (or the timeout not positive).
void check(const ProtocolOptions& options);

}  // namespace ringsplat
