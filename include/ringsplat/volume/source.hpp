#pragma once
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// What the world's axes are.
enum class World {
  lattice,    ///< the volume's own axes: z is up
  patient,    ///< left, posterior, superior, in millimetres
  microscope  ///< x: image columns; -z: image rows; y: slices, away from the default viewer
};

/// What a file says of one of its channels.
struct ChannelNotes {
  std::string name = {};                            ///< empty: it has none
  std::optional<glm::dvec3> colour = std::nullopt;  ///< display (sRGB) values, 0 to 1
  std::optional<glm::dvec2> window = std::nullopt;  ///< the values that are black and fully coloured
  bool hidden = false;                              ///< its programs do not show it
};

/// What a file says of its volume beside the lattice. Nothing of it changes a voxel.
struct VolumeNotes {
  World world = World::lattice;
  std::string unit = {};      ///< of the spacing, in ASCII: "mm", "um"; empty: unknown
  std::string quantity = {};  ///< what the values are, with their unit: "temperature (K)"; empty: unknown
  std::string modality = {};  ///< DICOM's, in capitals: "CT", "MR"; empty: unknown
  std::optional<double> fill = std::nullopt;  ///< the value of voxels without data
  bool labels = false;                        ///< the file says that its values are labels
  int frames = 1;                             ///< time points that --frame can choose from
  /// What --channel can choose from; one for a scalar volume.
  int channels = 1;
  std::vector<ChannelNotes> of_channels = {};  ///< in their order, where it says something of them
  /// Where a coarser level of a pyramid is read, the same part of the finest, in whose voxels people count.
  std::optional<Grid> finest = std::nullopt;
  /// What --series can choose from in a DICOM folder, a line each.
  std::vector<std::string> series = {};
};

/// As many labels of a segmentation are told apart over a volume.
inline constexpr int most_tints = 127;

/// A source of voxels, read by whole z slices.
class VolumeSource {
 public:
  virtual ~VolumeSource() = default;
  virtual const Grid& grid() const = 0;

  /// True when every process may read its own slices at once (raw encoding, analytic, in memory
  /// everywhere); false when one process has to decode the file in order.
  virtual bool concurrent() const = 0;

  /// Reads z slices [first, first + count) into `out` (count * grid().slice_bytes(Axis::z) bytes) in
  /// native byte order. A source that is not concurrent is cheapest when read in ascending order,
  /// each slice once. Throws InputError naming the file (truncated, unreadable).
  virtual void read_slices(int first, int count, std::span<std::byte> out) = 0;

  /// z slices that are decoded together: layers [k * layer_depth(), (k + 1) * layer_depth()) are read fastest
  /// as a whole, each once.
  virtual int layer_depth() const { return 1; }

  virtual VolumeNotes notes() const { return {}; }

  /// The labels that a segmentation gives to its voxels, of 8 bits on its grid; null: it has none. The source
  /// keeps it. They are 0, for none, to most_tints.
  virtual VolumeSource* labels() { return nullptr; }

  /// Facts that must be the same, beside the grid, on all processes that read one volume: encoding, files,
  /// their sizes, hashes of their first and last bytes. None for a source without files. Throws InputError
  /// when a file cannot be read.
  virtual Facts facts() const { return {}; }
};

}  // namespace ringsplat
