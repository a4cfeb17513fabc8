#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "net/collectives.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"
#include "volume/slice_store.hpp"
#include "volume/value_statistics.hpp"
#include "volume/volume_sketch.hpp"

namespace ringsplat {

inline SliceDealing dealing_of(const Layout& layout) { return {layout.gps, layout.bundle}; }

std::string text_of(const VoxelBox& box);  ///< "x0:x1,y0:y1,z0:z1"

/// The processes that share a volume, and who gets which of its slices.
struct Sharing {
  SliceDealing dealing;
  std::vector<int> process_of_gp;
  Collectives& collectives;

  bool hosts(int gp) const { return process_of_gp[std::size_t(gp)] == collectives.process(); }
  int process_of_slice(int slice) const { return process_of_gp[std::size_t(dealing.owner_of(slice))]; }
};

struct LoadOptions {
  std::array<bool, 3> kept_axes{true, true, true};
  bool with_normals = true;
  std::vector<int> factors{1};    ///< reduction factors of the levels to keep; 1 is the volume itself
  bool prefilter = false;         ///< for reduced levels (volume/reduced.hpp)
  bool with_cell_ranges = false;  ///< what sheets need to leave out what cannot be seen
  /// The part of the volume that is shown. Slices are kept whole, normals are made within it: those of lit
  /// splats are right in frames with this clip box only.
  std::optional<VoxelBox> clip = std::nullopt;
  /// The grid of a volume of which half the voxels along each axis are dealt: the levels are that one's, and
  /// the statistics of what there is.
  std::optional<Grid> half_of = std::nullopt;
  /// Told now and then which part of the loading's time has passed, 0 ... 1. `in_step`: all processes are
  /// told at once, between collective calls.
  std::function<void(double part, bool in_step)> told = {};
};

struct OpenedVolume {
  Grid grid;
  bool concurrent = false;
  std::unique_ptr<VolumeSource> source;
  Facts facts = {};         ///< on process 0: identifies the volume when it is opened again
  VolumeNotes notes = {};   ///< on process 0; elsewhere the fill value at least
  int layer_depth = 1;      ///< the source's, on every process
  bool has_labels = false;  ///< VolumeSource::labels(), on every process
  std::string name = {};
};

/// Opens the volume on process 0, and on all processes when it can be read concurrently; then all must see
/// the same volume: grid, encoding, sizes and first and last bytes. Every process gets the grid; a process
/// that need not read gets no source. All throw the same InputError, with the volume's `name`, when one fails
/// or sees another volume than process 0.
OpenedVolume open_everywhere(Collectives& collectives,
                             const std::function<std::unique_ptr<VolumeSource>()>& open,
                             const std::string& name = "the volume");

/// Deals the volume to the GPs, which get their slices of each kept axis, with quantised normals. A
/// process holds at most its GPs' share of the volume and one batch of slices, or one of the source's layers.
///
/// z slices are read whole. A concurrent source's are read by their owners, or layer by layer, where it
/// decodes several together, by all processes in turn, which hand them to their owners; another source's are
/// read by process 0 in ascending order. The other two axes come by exchange. Returns this process's stores
/// by GP. All processes throw the same InputError when one cannot read.
std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options,
                                      const Sharing& sharing);

/// Tells every store the value range of every slice of the kept axes.
void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives);

/// The sketch's points in one of its slices, row by row.
std::vector<float> points_of(const VolumeSketch& sketch, const SliceView& slice);

/// Gives every process the same sketch of the volume, taken from the slices of an axis, which all stores
/// keep.
std::shared_ptr<const VolumeSketch> share_sketch(const std::map<int, SliceStore>& stores, const Grid& grid,
                                                 Axis axis, Collectives& collectives);

/// Tells every store the ranges of the cells of its slices of the kept axes and of their neighbours, two to
/// either side.
void share_cell_ranges(std::map<int, SliceStore>& stores, const Sharing& sharing);

/// Range, histogram and more of the values of all GPs' slices; the same on every process.
ValueStatistics share_values(const std::map<int, SliceStore>& stores, const Grid& grid,
                             const VolumeNotes& notes, Collectives& collectives);

/// A volume dealt to the GPs, ready to be rendered: this process's slices and what all processes know.
struct Scene {
  Grid grid;
  std::map<int, SliceStore> stores;  ///< by GP, those of this process
  ValueStatistics values;
  std::shared_ptr<const VolumeSketch> sketch;  ///< of the whole volume
  std::vector<Scene> others;        ///< further volumes on the same grid that frames may show, as channels
  std::vector<double> labels = {};  ///< of its segmentation but 0, ascending; none: it has none
};

/// Deals all requested levels of an opened volume to GPs and gathers its values' statistics. All processes
/// call it, with the same grid and options.
Scene deal_scene(OpenedVolume& volume, const LoadOptions& options, const Sharing& sharing);

/// The scene of a volume whose z slices are dealt already; their values are shared, not copied. The other
/// axes' slices, normals and levels come by exchange. `values` are left to the caller.
Scene deal_scene_again(const Grid& grid, const std::map<int, SliceStore>& stores, const LoadOptions& options,
                       const Sharing& sharing);

}  // namespace ringsplat
