#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
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
  /// What --series can choose from in a DICOM folder, a line each.
  std::vector<std::string> series = {};
};

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

  /// z slices that are decoded together: slabs [k * slab_depth(), (k + 1) * slab_depth()) are read fastest as
  /// a whole, each once.
  virtual int slab_depth() const { return 1; }

  virtual VolumeNotes notes() const { return {}; }

  /// Facts that must be the same, beside the grid, on all processes that read one volume: encoding, files,
  /// their sizes, hashes of their first and last bytes. None for a source without files. Throws InputError
  /// when a file cannot be read.
  virtual Facts facts() const { return {}; }
};

/// The command line's description of a raw file; missing fields come from its name
/// (`name_256x256x128_uint8.raw`).
struct RawDescription {
  std::optional<glm::ivec3> dims;
  std::optional<ScalarType> type;
  std::optional<bool> big_endian;
  std::optional<std::uint64_t> offset;  ///< bytes before the first voxel
  std::optional<glm::dvec3> spacing;
  bool empty() const { return !dims && !type && !big_endian && !offset && !spacing; }
};

/// Which of the volumes in a file or a folder to take.
struct VolumeChoice {
  std::optional<int> frame = std::nullopt;  ///< the time point, from 0; without it the first
  std::string channel = {};  ///< a number from 0, r, g, b or a, or a channel's name; empty: not chosen
  std::string series = {};   ///< of a DICOM folder; empty: not chosen
};

/// Opens NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 and -2 (.nii, .nii.gz, .img/.hdr), a DICOM
/// folder (or one file of a series, whatever its ending), TIFF (one multi-page file or a folder of pages),
/// VTK (.vtk, .vti), NumPy (.npy), HDF5 (.h5, .nc and others, or any ending) or a raw file.
/// "file.h5:/path/to/dataset" names one of an HDF5 file's datasets; netCDF-4, VTKHDF's ImageData and openPMD
/// are HDF5, and their coordinates are followed. For files that describe themselves only `raw.spacing` may be
/// given; it replaces theirs.
///
/// World coordinates are ITK's: patient left-posterior-superior if the file tells the orientation (DICOM;
/// NIfTI, converted from right-anterior-superior; NRRD with a `space`; MetaImage); a microscope's for TIFF:
/// columns along x, rows along -z, slices along y; the file's x, y and z for HDF5 (longitude, latitude and
/// height upwards) and VTK; else the lattice's own axes (plain spacings, raw, NumPy).
///
/// Whole slices are decoded one after another, without holding the volume, except for text encodings, volumes
/// in several NRRD files and multi-frame DICOM.
///
/// Checks that the file is as long as its header says before anything is allocated. Throws InputError: what
/// is wrong, in which file and field, what to do.
std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path, const RawDescription& raw = {},
                                          const VolumeChoice& choice = {});

/// A volume that lies in memory; `voxels` (grid.bytes() bytes, native order) must outlive the source.
std::unique_ptr<VolumeSource> memory_source(const Grid& grid, std::span<const std::byte> voxels);

}  // namespace ringsplat
