#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace ringsplat {

/// The network of a described machine.
enum class PlatformKind {
  backbone,  ///< a link for each host, and one that all traffic shares: a ring, a bus, a switch with a limit
  mesh,      ///< the GPs' mesh with Renderers at its rows' ends; messages go along a column, then along a row
  torus,     ///< two dimensions, as square as the number of hosts allows
  fat_tree   ///< two levels of switches without a bottleneck between them
};
const char* name(PlatformKind kind);

/// A machine to simulate: what the nodes' work costs, in seconds of one core, and how its hosts are linked.
/// Read from mpi_configs/machines/*.toml; docs/simulation.md lists the fields.
struct Machine {
  std::string name;

  struct {
    double visible_voxel = 0;      ///< classify, shade, transform, encode, sort by region
    double transparent_voxel = 0;  ///< look at it and go on
    double slice = 0;              ///< besides its voxels
    double frame = 0;              ///< once a frame: tables, setup
    double token = 0;              ///< take a token and pass it on, besides the message
  } gp;
  struct {
    double splat = 0;
    double pass = 0;       ///< (region, pass) pair that is not empty
    double slice = 0;      ///< payload, besides its splats and pixels
    double composite = 0;  ///< pixel of a slice that is composited
    double pixel = 0;      ///< of a delivered tile
    double frame = 0;
  } renderer;
  /// What sheets cost; a block has 8 x 8 voxels.
  struct {
    double look = 0;    ///< on either side, for each block of a slice, whatever is in it
    double copy = 0;    ///< a GP, to copy a block into a payload
    double place = 0;   ///< a Renderer, to put it into a plane
    double slice = 0;   ///< a Renderer, for a payload
    double sample = 0;  ///< to paint a pixel of what lies between two slices
    double table = 0;   ///< a Renderer's tables, once a frame
  } sheets;
  struct {
    double send = 0, receive = 0;    ///< software on either side, for each message
    double wake = 0;                 ///< until a rank that waits has its core again, where ranks share cores
    double packet = 0;               ///< software of the sender, for each packet begun
    std::uint64_t packet_bytes = 0;  ///< 0: a message is one packet
  } message;
  /// A node that computes looks for messages this often.
  double poll_interval = 0;
  struct {
    int rank = -1;  ///< whose computing takes so many times as long; -1: nobody's
    double factor = 2;
  } slow;
  /// Factor on a frame whose ranks share cores. Simulated ranks share them evenly, systems do not.
  double sharing = 1;

  struct {
    PlatformKind kind = PlatformKind::backbone;
    double bandwidth = 0, latency = 0;  ///< of each link, in each direction; bytes per second and seconds
    double backbone_bandwidth = 0;      ///< 0: the backbone is no limit
    double local_bandwidth = 0, local_latency = 0;  ///< between ranks of one host; 0: no limit
    int cores = 1;                                  ///< of a host; as many ranks are put on it
    int hosts = 0;                                  ///< 0: as many as the ranks need. Fewer share the cores.
    int leaf = 16;                                  ///< hosts on a fat tree's lowest switch
  } platform;
};

/// Throws InputError naming `where` (a file) and the field: not TOML, unknown or missing fields, values that
/// make no sense.
Machine parse_machine(const std::string& toml, const std::string& where);
/// The same from a file; throws InputError when it cannot be read.
Machine read_machine(const std::string& path);

/// Seconds a GP computes on slices of `voxels` together, of which `visible` are not transparent.
inline double encoding_seconds(const Machine& m, double voxels, double visible, double slices = 1) {
  return slices * m.gp.slice + visible * m.gp.visible_voxel + (voxels - visible) * m.gp.transparent_voxel;
}
/// Seconds a Renderer draws and composites a payload of slices that have `pixels` pixels together.
inline double drawing_seconds(const Machine& m, double splats, double passes, double pixels,
                              double slices = 1) {
  return slices * m.renderer.slice + splats * m.renderer.splat + passes * m.renderer.pass +
         pixels * m.renderer.composite;
}
/// Seconds a GP spends on slices of `blocks` blocks, of which it sends `sent`; one sent twice counts twice.
inline double selecting_seconds(const Machine& m, double blocks, double sent, double slices = 1) {
  return slices * m.gp.slice + blocks * m.sheets.look + sent * m.sheets.copy;
}
/// Seconds a Renderer spends on a payload of such slices, before it paints.
inline double placing_seconds(const Machine& m, double blocks, double placed, double slices = 1) {
  return slices * m.sheets.slice + blocks * m.sheets.look + placed * m.sheets.place;
}
/// Seconds it paints pixels of what lies between two slices.
inline double painting_seconds(const Machine& m, double samples) { return samples * m.sheets.sample; }
/// Seconds that a Renderer of sheets paints before it takes messages: a group of pixels through a dozen
/// slabs.
inline double painting_piece(const Machine& m) {
  constexpr double group = 16 * 16, slabs = 12;
  const double seconds = painting_seconds(m, group * slabs);
  return seconds > 0 ? std::min(seconds, m.poll_interval) : m.poll_interval;
}
/// Whether so many ranks are more than the machine has cores.
inline bool shares_cores(const Machine& m, int ranks) {
  return m.platform.hosts > 0 && ranks > std::int64_t{m.platform.hosts} * m.platform.cores;
}
/// Seconds of software a sender spends on a message of so many bytes, header included.
inline double sending_seconds(const Machine& m, double bytes) {
  const double packets =
      m.message.packet_bytes == 0 ? 1 : std::ceil(bytes / static_cast<double>(m.message.packet_bytes));
  return m.message.send + packets * m.message.packet;
}

}  // namespace ringsplat
