// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_RAYS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_RAYS_INL
#undef RINGSPLAT_RAYS_INL
#else
#define RINGSPLAT_RAYS_INL
#endif

#include <algorithm>
#include <tuple>

#include "sheet_engine/lanes-inl.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/slab_lanes-inl.hpp"

/// The rays of a tile's lanes through a slab's sheets. Rays have
///   Tile           what they keep of a tile's lanes,
///   same_lengths   whether a slab is as long for every ray as the table's,
///   begin()        a slab; what follows is asked of its sheets,
///   start()        a tile, whose first lane is pixel (x, y),
///   at()           the lanes' positions in a sheet,
///   ends()         bounds of these positions in all sheets, but for lanes that miss the volume,
///   some_miss()    whether a lane's ray meets no voxel,
///   length()       of the lanes' way through a slab, in lengths of the table's,
///   viewer()       the lanes' direction to the viewer.
HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

struct Position {
  I u, v;
};
struct Ends {
  std::int32_t low_u, high_u, low_v, high_v;
};

/// Rays of an orthographic view: one shift for all lanes leads from a sheet to another.
class ParallelRays {
 public:
  static constexpr bool same_lengths = true;
  struct Tile {
    Position place;  ///< in slice 0
    Ends ends;       ///< of it
  };

  explicit ParallelRays(const SheetPaint& paint) : p_(paint) {}

  void begin(const SheetSlab& slab) {
    slab_ = &slab;
    // Shifts grow or fall from sheet to sheet.
    const auto last = std::size_t(slab.pieces);
    std::tie(shifts_.low_u, shifts_.high_u) = std::minmax(slab.shift_u[0], slab.shift_u[last]);
    std::tie(shifts_.low_v, shifts_.high_v) = std::minmax(slab.shift_v[0], slab.shift_v[last]);
  }

  HWY_INLINE Tile start(int x, int y) const {
    const Line u = line(0, x, y), v = line(1, x, y);
    return {{u.at, v.at}, {u.low, u.high, v.low, v.high}};
  }

  HWY_INLINE Position at(const Tile& tile, int sheet) const {
    const auto i = std::size_t(sheet);
    return {sub(tile.place.u, set_int(slab_->shift_u[i])), sub(tile.place.v, set_int(slab_->shift_v[i]))};
  }

  Ends ends(const Tile& tile) const {
    return {tile.ends.low_u - shifts_.high_u, tile.ends.high_u - shifts_.low_u,
            tile.ends.low_v - shifts_.high_v, tile.ends.high_v - shifts_.low_v};
  }

  /// What lies beside the volume does so by its position.
  static bool some_miss(const Tile&) { return false; }

  HWY_INLINE F length(const Tile&) const { return set(1.0F); }

  HWY_INLINE Viewer viewer(const Tile&) const {
    const GradientLight& light = p_.light;
    return {set(light.viewer[0]), set(light.viewer[1]), set(light.viewer[2]), set(light.between)};
  }

 private:
  /// The lanes' positions along u or v, and their ends, which are at a tile's corners.
  struct Line {
    I at;
    std::int32_t low, high;
  };
  HWY_INLINE Line line(int axis, int x, int y) const {
    const RayGrid& r = p_.rays.grid;
    const std::int64_t right = r.step_x[axis], down = r.step_y[axis],
                       first = r.origin[axis] + x * right + y * down;
    const auto position = [](std::int64_t place) {
      constexpr std::int64_t limit = std::int64_t{1} << 30;
      return static_cast<std::int32_t>(std::clamp(place >> (40 - position_bits), -limit, limit));
    };
    HWY_ALIGN std::int32_t at[lanes];
    for (int l = 0; l < lanes; ++l) at[l] = position(first + l % tile_width * right + l / tile_width * down);
    const std::int64_t across = (tile_width - 1) * right, deep = (tile_height - 1) * down, none = 0;
    return {load(at), position(first + std::min(across, none) + std::min(deep, none)),
            position(first + std::max(across, none) + std::max(deep, none))};
  }

  const SheetPaint& p_;
  const SheetSlab* slab_ = nullptr;
  Ends shifts_{};
};

/// Rays of a perspective view: every lane has its own slope.
class EyeRays {
 public:
  static constexpr bool same_lengths = false;
  static constexpr std::int32_t far_beside = 1 << 30;
  /// Lower bounds of u, -u, v, -v: linear in the slices, in voxels.
  struct Lines {
    float middle[4], slope[4];
  };
  struct Tile {
    Position place;  ///< in the middle slice
    F slope_u, slope_v, length;
    Viewer viewer;
    Lines ends;
    bool some_miss;  ///< a lane's ray meets no voxel
  };

  explicit EyeRays(const SheetPaint& paint) : p_(paint), eye_(*paint.rays.eye) {}

  void begin(const SheetSlab& slab) { slab_ = &slab; }

  HWY_INLINE Tile start(int x, int y) const {
    HWY_ALIGN float right[lanes], down[lanes];
    for (int l = 0; l < lanes; ++l) {
      right[l] = float(x + l % tile_width) - eye_.central_x;
      down[l] = float(y + l / tile_width) - eye_.central_y;
    }
    const F x_from = load(right), y_from = load(down), one = set(1.0F);
    const F depth = fma(set(eye_.depth_x), x_from, fma(set(eye_.depth_y), y_from, one));
    M miss = greater(set(1e-6F), depth);
    const Pixels from{x_from, y_from, div(one, choose(miss, one, depth))};
    Tile tile;
    along(0, from, tile, tile.place.u, tile.slope_u, miss);
    along(1, from, tile, tile.place.v, tile.slope_v, miss);
    tile.some_miss = any(miss);
    F way[3], squares = set(0.0F);
    for (int i = 0; i < 3; ++i) {
      const float* axis = eye_.axes[i];
      way[i] = fma(set(axis[0]), tile.slope_u, fma(set(axis[1]), tile.slope_v, set(axis[2])));
      squares = fma(way[i], way[i], squares);
    }
    const F length = root(squares), over = div(set(-eye_.way), length);
    tile.length = eye_.table_length > 0 ? div(length, set(eye_.table_length)) : set(1.0F);
    const float* light = p_.light.light;
    tile.viewer = {mul(way[0], over), mul(way[1], over), mul(way[2], over), set(0.0F)};
    tile.viewer.light = fma(tile.viewer.u, set(light[0]),
                            fma(tile.viewer.v, set(light[1]), mul(tile.viewer.k, set(light[2]))));
    return tile;
  }

  HWY_INLINE Position at(const Tile& tile, int sheet) const {
    const F slices = set(slab_->slice[std::size_t(sheet)] * float(one_voxel));
    return {add(tile.place.u, to_int(mul(tile.slope_u, slices))),
            add(tile.place.v, to_int(mul(tile.slope_v, slices)))};
  }

  Ends ends(const Tile& tile) const {
    const float first = slab_->slice[0], last = slab_->slice[std::size_t(slab_->pieces)];
    std::int32_t low[4];
    for (int i = 0; i < 4; ++i) {
      const float slope = tile.ends.slope[i],
                  bound = tile.ends.middle[i] + std::min(slope * first, slope * last);
      constexpr auto most = float(far_beside);
      low[i] = static_cast<std::int32_t>(
          std::min(std::max((bound - EyeGrid::position_error) * float(one_voxel), -most), most));
    }
    return {low[0], -low[1], low[2], -low[3]};
  }

  static bool some_miss(const Tile& tile) { return tile.some_miss; }

  HWY_INLINE F length(const Tile& tile) const { return tile.length; }
  HWY_INLINE Viewer viewer(const Tile& tile) const { return tile.viewer; }

 private:
  /// Where lanes are seen from the central ray's pixel.
  struct Pixels {
    F right, down, over_depth;
  };

  /// Sets what lanes do along u or v, and adds those that miss the volume there. These go straight, far
  /// beside it.
  HWY_INLINE void along(int i, const Pixels& pixels, Tile& tile, I& place, F& slope, M& miss) const {
    const F across = mul(fma(set(eye_.slope_x[i]), pixels.right, mul(set(eye_.slope_y[i]), pixels.down)),
                         pixels.over_depth);
    const F middle = fma(set(eye_.to_middle), across, set(eye_.central_middle[i])),
            steep = add(across, set(eye_.central_slope[i]));
    miss =
        either(miss, either(greater(abs(steep), set(eye_.steepest[i])),
                            either(greater(set(eye_.low[i]), middle), greater(middle, set(eye_.high[i])))));
    const F beside = set(-float(far_beside) / one_voxel), limited = min(max(middle, beside), abs(beside));
    place = to_int(mul(choose(miss, beside, limited), set(float(one_voxel))));
    slope = choose(miss, set(0.0F), steep);
    // The least of linear functions lies above the line between its ends, the greatest below.
    const F half = mul(steep, set(eye_.half_slices)), near = sub(limited, half), far = add(limited, half);
    set_line(tile.ends, 2 * i, least(near), least(far));
    set_line(tile.ends, 2 * i + 1, -greatest(near), -greatest(far));
  }

  /// Through what is at the volume's two faces.
  void set_line(Lines& lines, int i, float near, float far) const {
    lines.middle[i] = 0.5F * (near + far);
    lines.slope[i] = 0.5F * (far - near) / eye_.half_slices;
  }

  const SheetPaint& p_;
  const EyeGrid& eye_;
  const SheetSlab* slab_ = nullptr;
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
