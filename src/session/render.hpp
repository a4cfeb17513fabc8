#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "net/collectives.hpp"
#include "net/loopback.hpp"
#include "net/transport.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

class Engine;
struct EngineSetup;

/// How a run's ranks talk: over a transport between processes, or, when `transport` is null, all in this
/// process over a loopback network.
struct Wiring {
  Collectives& collectives;
  Transport* transport = nullptr;
  LoopbackOptions loopback = {};
};

/// How a node does its work. No option changes a picture.
struct EngineOptions {
  int threads_per_rank = 1;  ///< threads that share a node's work; they never call MPI
  /// MiB of sheets' planes that a Renderer keeps, so that their voxels need not be sent again; without it as
  /// usual_kept_bytes(). The same on every rank.
  std::optional<int> keep = {};
  /// Rank 0 makes files or messages of pictures meanwhile. The same on every rank.
  bool encodes_pictures = false;

  // What studies of machines put in place of a run's parts (simulate/simulation.hpp); empty: the usual ones.
  std::function<std::unique_ptr<Engine>(EngineSetup setup)> engine = {};
  std::function<std::unique_ptr<Transport>(Transport& network)> network = {};  ///< on which messages travel
};

/// Bytes of sheets' planes that a Renderer keeps unless somebody says how many: its share of 2 GiB, or of a
/// quarter of what all slices take in all three slice sets where that is more, and at least 256 MiB; no more
/// than all planes take.
std::uint64_t usual_kept_bytes(const Grid& grid, int gps);

/// Throws InputError that names the option when it asks for more threads than any machine has cores.
void check(const EngineOptions& options);

/// A hash of the headers that say how messages look (src/CMakeLists.txt), sixteen hexadecimal digits: builds
/// with different digits may misread each other's messages. It says nothing of what nodes do with a message;
/// the version stands for that.
std::string wire_format();

}  // namespace ringsplat
