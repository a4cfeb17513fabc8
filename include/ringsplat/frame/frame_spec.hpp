#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "ringsplat/classify/material.hpp"
#include "ringsplat/classify/mode.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/view/view.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

enum class Shading { none, phong };

/// The values between voxels, where sheets and the field's truth ask for them: trilinear, or the nearest
/// voxel's, as between labels there are no others. Splats classify voxels and ask for none.
enum class Interpolation { linear, nearest };
const char* name(Interpolation interpolation);

/// Where Renderers' regions lie: on the screen, as in the paper; or in the plane of the traversed slices,
/// sheared along the rays; the frame buffer then warps that image once into the picture (Lacroute and Levoy
/// 1994).
enum class ImagePlane { screen, slices };
std::string name(ImagePlane plane);

/// What lies behind a plane is cut off: the plane is `distance` world lengths from the whole volume's middle
/// along `normal`, a world direction of any length, which points to what is left.
struct ClipPlane {
  glm::dvec3 normal{0.0, 1.0, 0.0};
  double distance = 0;
  bool operator==(const ClipPlane&) const = default;
};

/// How much of its opacity the field keeps by its gradient's magnitude, in values over world lengths: nothing
/// up to `from`, all beyond `to`, on a line between (after Levoy 1988, section 3.1).
struct EdgeOpacity {
  double from = 0, to = 1;
  bool operator==(const EdgeOpacity&) const = default;
};

/// The colour, in linear light, that a segmentation's label gives to what it covers: in place of so large a
/// share of the transfer function's. Opacities stay as they are.
struct Tint {
  int label = 1;  ///< 1 to most_tints
  glm::vec3 colour{1.0F};
  float share = 1;
  bool operator==(const Tint&) const = default;
};

/// What a picture shows, whatever draws it.
struct Shown {
  Camera camera;
  int width = 512, height = 512;  ///< pixels
  TransferFunction transfer_function;
  Interpolation interpolation = Interpolation::linear;
  Mode mode = Mode::composite;
  double isovalue = 0;  ///< of Mode::surface
  /// Volumes of one picture (VolumeFrame) dim each other as materials do, in place of adding their light: the
  /// extinction is that of all, and each has its part of the light. By sheets, in Mode::composite.
  bool mixed = false;
  /// Pixels hold in red, green and blue what their ray has, in alpha 1 where it has something. Extrema, as
  /// far as the transfer function's points reach; means; integrals over world lengths; of Mode::surface and
  /// Mode::composite depths: world lengths along the view, behind the plane through the volume's middle.
  bool values = false;
  bool holes = true;  ///< some voxels may be not-a-number: rays that meet no others have no extremum
  /// The picture gets depths, too (Image::depth): of a surface, or with Mode::composite of where a ray's
  /// opacity reaches this, above 0 and below 1; with `values` and none half. By sheets, and a second frame.
  std::optional<double> depth = std::nullopt;
  Shading shading = Shading::phong;
  PhongMaterial material;
  glm::dvec3 light{-0.4, 0.6, 0.7};  ///< towards the light, in the picture's axes: right, up, to the viewer
  bool opacity_correction = true;
  /// Pixels with less transmittance are final. 0: all slices are composited.
  double opaque_threshold = 1.0 / 512;
  Reduction reduction;  ///< reduces the volume; opacities are corrected for the larger voxels
  /// The part of the volume that is shown, as if the rest were cut off; the camera fits the whole.
  std::optional<VoxelBox> clip = std::nullopt;
  std::vector<ClipPlane> clip_planes = {};  ///< at most four, which only sheets can show
  static constexpr std::size_t most_clip_planes = 4;
  /// The volume is cut open: what lies before this plane, whichever its sides are, is cut off, and the plane
  /// shows the values there, opaque, in the transfer function's colours. By sheets, and a second frame; with
  /// two clip planes at most.
  std::optional<ClipPlane> cut = std::nullopt;
  std::optional<EdgeOpacity> edges = std::nullopt;  ///< for sheets' light, Mode::composite
  /// Of a volume that was loaded with a segmentation, in sheets' Mode::composite and single slices: a slab,
  /// or a slice's place, has the label of the voxel nearest to its middle.
  std::vector<Tint> tints = {};
  bool operator==(const Shown&) const = default;
};

/// The paper's method: voxels are classified, then splatted (Neumann 1992).
struct Splats {
  static constexpr const char* name = "splats";
  ImagePlane image_plane = ImagePlane::screen;
  int plane_samples = 1;       ///< in the slices' plane: most pixels a voxel along either axis
  double kernel_radius = 1.6;  ///< in lattice distances
  bool operator==(const Splats&) const = default;
};

/// Sheets: each slice's scalars are interpolated along the pixels' rays, and what lies between two slices is
/// classified through a table of pre-integrated slabs (Engel, Kraus and Ertl 2001).
struct Sheets {
  static constexpr const char* name = "sheets";
  static constexpr int most_slabs = 4;
  /// Wherever the slices' plane would have more pixels than the screen, or rays are not parallel: the screen.
  ImagePlane image_plane = ImagePlane::screen;
  double plane_samples = 1;  ///< in the slices' plane: most pixels a voxel along either axis, at least 1
  /// Pre-integrated slabs from slice to slice, as by Traversal::slabs_for; with nearest values an even
  /// number.
  int slabs = 3;
  int light_points = 2;  ///< where a slab is lit: at its opacity's centroid, or at centroid ± spread
  /// Take one slab or one light point where two would hardly differ (docs/sheets.md).
  bool adaptive = true;
  /// Slices of a layer that is drawn for itself; the layers' pixels are then composited. 0: all slices are
  /// drawn together. Only Mode::composite has layers.
  int layers = 0;
  static constexpr int least_layer = 4;
  bool operator==(const Sheets&) const = default;
};

/// How voxels become pixels: the method, with its own options.
using Method = std::variant<Splats, Sheets>;
const char* name(const Method& method);

/// How Renderers share the image plane; never changes a bit of the picture.
struct Division {
  /// A region's side, in pixels of the image plane. 0 chooses: on the screen 128, or less, down to 16, where
  /// that shares the work more evenly; in the slices' plane strips.
  int region_size = 0;
  int dealt_to = 0;  ///< how many Renderers get regions; 0: rank 0 fills in their number
  /// For each of these, how much longer than the others it took for what was foreseen to be the same; empty:
  /// about as long. Rank 0 fills it in as frames are done.
  std::vector<float> pace = {};
  bool operator==(const Division&) const = default;
};

/// A frame, as rank 0 announces it to all ranks.
struct FrameSpec {
  std::int64_t frame = 0;
  Shown shown = {};
  Method how = Sheets{};
  Division division = {};
  bool operator==(const FrameSpec&) const = default;

  /// The options of method How; throws std::bad_variant_access when the frame uses another.
  template <class How>
  How& as() {
    return std::get<How>(how);
  }
  template <class How>
  const How& as() const {
    return std::get<How>(how);
  }
};

/// Throws InputError that names the bad option: sizes, radius, camera, transfer function, light of length
/// zero, a threshold outside [0, 1), a projection, a mode, clip planes, a cut, edges or tints that the method
/// has not.
void check(const FrameSpec& spec);
/// Throws InputError when the method cannot draw the camera's kind of view.
void check_projection(const Camera& camera, const Method& method);

}  // namespace ringsplat
