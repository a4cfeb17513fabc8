#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// Pixels are painted in groups of 16 x 16, which go through many slabs in turn, so that their state stays in
/// the processor's nearest cache. Tiles of 4 x 4 of them are left out where a slab shows nothing.
inline constexpr int group_side = 16, tile_side = 4;
/// What a tile may span in a slab for its 8 x 8 voxels to hold all that it reads: the voxel below its lowest
/// position, one before and two behind each lane's.
inline constexpr double patch_span = 4;
/// A bit for each tile of a group, row by row.
using TileMask = std::uint16_t;

/// Positions in the lattice are whole numbers of 2^-16 voxels.
inline constexpr int position_bits = 16;
inline constexpr std::int32_t one_voxel = 1 << position_bits;
/// No slice of a frame may be so many voxels wide or lie so many voxels beside another one.
inline constexpr double most_voxels = 16384;

/// Of sums of 16-bit numbers by the weights of four voxels.
inline constexpr float pair_unit = 1.0F / 16384;

/// The planes round a slab and its sheets. Planes are pointers to voxel (0, 0); beyond the volume's first and
/// last slice they are extrapolated.
struct SheetSlab {
  const void* before = nullptr;  ///< the slice before the slab
  const void* front = nullptr;   ///< at the slab's front
  const void* back = nullptr;    ///< at its back; at a face of the volume the same as `front`
  const void* after = nullptr;   ///< behind it
  /// Labels of `front` and `back`, in planes of bytes; null without tints.
  const std::uint8_t *front_labels = nullptr, *back_labels = nullptr;
  bool face = false;  ///< a half slice beyond the first or last one
  int step = 0;       ///< of its back
  int pieces = 1;     ///< slabs in it; its sheets are 0 ... pieces
  std::array<std::int32_t, Traversal::most_slabs + 1> shift_u{},
      shift_v{};                                         ///< of each sheet against slice 0
  std::array<float, Traversal::most_slabs + 1> slice{};  ///< of each sheet, from the middle one, for EyeGrid
};

/// The rays of an orthographic frame: a pixel's position in slice 0, as 2^-40 voxels.
struct RayGrid {
  std::int64_t origin[2] = {}, step_x[2] = {},
               step_y[2] = {};  ///< u and v of pixel (0, 0), and a pixel's step
};

/// The rays of a perspective frame. Vectors are in voxels along u, v and k, the traversed axis; slices count
/// from the middle one.
///
/// They are counted from the central ray, which goes through the middle of the volume, so that floats lose
/// nothing to a far eye: pixel (x, y) has the slope central_slope[i] + d[i], with
///   d[i] = (slope_x[i] (x - central_x) + slope_y[i] (y - central_y)) / depth,
///   depth = 1 + depth_x (x - central_x) + depth_y (y - central_y),
/// and meets the middle slice at central_middle[i] + to_middle d[i].
struct EyeGrid {
  float central_x = 0, central_y = 0;  ///< the pixel of the central ray; centres of pixels are whole numbers
  float central_slope[2] = {}, central_middle[2] = {};
  float slope_x[2] = {}, slope_y[2] = {}, depth_x = 0, depth_y = 0;
  float to_middle = 0;     ///< from the eye to the middle slice, along k
  float way = 1;           ///< the sign of k along the rays
  float half_slices = 0;   ///< from the middle to the volume's faces
  float steepest[2] = {};  ///< rays that move by more along u or v from slice to slice miss the volume
  float low[2] = {}, high[2] = {};  ///< rays that meet the middle slice outside miss the volume
  float axes[3][3] = {};            ///< from (u, v, k) to GradientLight's coordinates, of world lengths
  float table_length = 0;  ///< the way from slice to slice that slabs are made for; 0: each ray's own

  /// What positions and bounds of them may be wrong by, in voxels.
  static constexpr float position_error = 1.0F / 256;

  /// Depth and slopes at a pixel, in double precision.
  double depth(double x, double y) const;
  double slope(int i, double x, double y) const;

  /// Whether tiles of `tile` x `tile` pixels, within `side` x `side` pixels from (x, y) on, span less than
  /// `voxels` in every slab.
  bool spans_less(int x, int y, int side, int tile, double voxels) const;
};

/// The rays of a frame's pixels in its slices.
struct SheetRays {
  int voxels[2] = {};          ///< along u and v
  RayGrid grid;                ///< of an orthographic view
  double shear[2] = {};        ///< voxels along u and v that slice 0 lies beside slice 1, seen along its rays
  bool patches = false;        ///< its tiles see at most 8 x 8 voxels of a slice
  std::optional<EyeGrid> eye;  ///< of a perspective view, instead
};

/// Before all places of an axis: that of values that are not a number.
inline constexpr float no_place = -1e9F;
/// Before all numbers of planes.
inline constexpr float no_number = -std::numeric_limits<float>::max();

/// A table's axis, what is transparent of it, and how planes' numbers become places.
struct PlaceMap {
  struct Ramp {
    float from, width, rise;
  };
  std::array<Ramp, 8> ramps{};
  int count = 1;
  float scale = 0, offset = 0;              ///< of an even axis: place = number · scale + offset
  bool even = false;                        ///< scale and offset are all
  float visible_low = 0, visible_high = 0;  ///< places outside are transparent
  struct Gap {
    float low, high;
  };
  std::array<Gap, 4> gaps{};  ///< transparent places between
  int gap_count = 0;
  /// Planes' whole numbers that interpolation makes nothing visible of: all up to `low`, all from `high` on,
  /// or all within one of the gaps.
  struct Numbers {
    std::int16_t low, high;
  };
  Numbers transparent{INT16_MIN, INT16_MAX};
  std::array<Numbers, 4> number_gaps{};
};

/// The place of a plane's number, by the very operations that lanes do.
float place_of_number(const PlaceMap& map, float number);

/// Phong's reflection in the coordinates of gradients (u, v, along the rays' slices).
struct GradientLight {
  /// Upper triangular: gradients times this have world lengths and angles.
  float uu = 1, uv = 0, uk = 0, vv = 1, vk = 0, kk = 1;
  bool oblique = false;                 ///< uv, uk or vk is not 0
  float light[3] = {}, viewer[3] = {};  ///< unit vectors in those coordinates
  float between = 0;                    ///< light · viewer
  float ambient = 0, diffuse = 0, specular = 0, exponent = 0;
  bool edges = false;  ///< opacity goes by gradients' lengths: nothing of it is left at `edge_from`,
  float edge_from = 0, over_edge = 0;  ///< all of it 1 / `over_edge` beyond
};

/// A clip plane: what is left is at least 0 voxels before it, along · (u, v, k) + offset. u and v count from
/// voxel 0, k from the middle slice.
struct SheetPlane {
  float along[3], offset;
};

/// What a frame's rays project when they composite nothing, or depths only, in planes' numbers.
struct Projection {
  Mode mode = Mode::composite;
  bool values = false;   ///< pixels get no colours
  float opacity = 0;     ///< of Mode::composite's values: the depth's, reached before rays end
  float sign = 1;        ///< of an extremum: 1 of the largest, -1 of the least
  float least = 0;       ///< numbers up to this, or down to it, are no extremum that could be seen
  float most = 0;        ///< so far beyond it nothing more changes the picture
  float isovalue = 0;    ///< of the surface
  float colour[3] = {};  ///< of the surface, linear
  float zero = 0;        ///< the value 0
  /// A number's value times the way from slice to slice, in world lengths; of Mode::attenuated by how many
  /// powers of two a number's excess over `least` dims on that way.
  float unit = 1;
};

/// By label: colour, and the share of it. All of no label, and of those that have no tint, are 0.
using TintTable = std::array<float, 4 * 256>;

/// What all groups of a frame share.
struct SheetPaint {
  SheetRays rays;
  PlaceMap places;
  GradientLight light;
  const std::uint64_t* table =
      nullptr;                    ///< of SlabTable, or of ValueTable where values are the nearest voxels'
  float last_entry = 255;         ///< of an axis
  const float* tints = nullptr;   ///< TintTable, where labels tint slabs
  const float* depths = nullptr;  ///< SlabTable::depths(), where opacities follow from these
  float slab_length = 1;          ///< of the table's slabs, in unit lengths
  std::ptrdiff_t pitch = 0;       ///< numbers from a plane's row to the next
  bool floats = false;            ///< planes are floats, not 16-bit numbers
  bool nearest = false;           ///< values are the nearest voxels', not interpolated
  bool lit = false, adaptive = false;
  int light_points = 1;
  float opaque_threshold = 0;
  float face_pieces = 1;  ///< slabs of the table in half a slice
  Projection projection;
  std::array<SheetPlane, Shown::most_clip_planes> clip_planes{};
  int clip_plane_count = 0;
};

/// One group: its pixels in the image plane, of which `width` x `height` are wanted.
struct PixelGroup {
  int x = 0, y = 0, width = group_side, height = group_side;
  float* rgba = nullptr;  ///< premultiplied, of its first pixel
  std::ptrdiff_t row_floats = 0;
  float* more = nullptr;  ///< four further floats of its first pixel, in rows as long
};

/// Slabs, front to back; masks[k * stride] has the tiles of a group that may show something of slab k.
struct MaskedSlabs {
  std::span<const SheetSlab> slabs;
  const TileMask* masks;
  std::ptrdiff_t stride;
};

/// Composites slabs behind a group's pixels, or takes what they project. A pixel's bits do not depend on the
/// group's place, on how slabs are divided into calls, or on tiles that show nothing.
void paint_group(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs);

/// One of several volumes on one grid that are painted together.
struct PaintedChannel {
  const SheetPaint* paint;
  MaskedSlabs slabs;  ///< the same ones of all, in its planes
  int place;          ///< where its value is among a pixel's: red, green, blue, and the four more
};
inline constexpr int most_channels = 7;

/// Takes extrema or integrals of `channels`, in planes of one type of numbers and of one mode, into their
/// places. Opacity becomes 1 where nothing changes any of `all` channels. Bits as of each by itself.
void paint_channels(std::span<const PaintedChannel> channels, std::size_t all, const PixelGroup& group);

/// Composites the slabs of `channels` behind a group's pixels as those of one material that has what all
/// have.
void mix_group(std::span<const PaintedChannel> channels, const PixelGroup& group);

}  // namespace ringsplat
