// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_VOXELS_ON_WAY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_VOXELS_ON_WAY_INL
#undef RINGSPLAT_VOXELS_ON_WAY_INL
#else
#define RINGSPLAT_VOXELS_ON_WAY_INL
#endif

#include "sheet_engine/rays-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// The voxels nearest to lanes on their way from a sheet to another within half a slice, so that they meet
/// at most two along u and two along v. Beyond the outer voxels' centres those are the nearest.
class VoxelsOnWay {
 public:
  static constexpr int most = 3;

  HWY_INLINE VoxelsOnWay(const Position& from, const Position& to, std::int32_t most_u, std::int32_t most_v) {
    const Steps u(from.u, to.u, most_u), v(from.v, to.v, most_v);
    const M u_first = greater(v.crossing, u.crossing);
    at_[0] = {u.first, v.first};
    at_[1] = {choose(u_first, u.last, u.first), choose(u_first, v.first, v.last)};
    at_[2] = {u.last, v.last};
    end_[0] = min(u.crossing, v.crossing);
    end_[1] = max(u.crossing, v.crossing);
    end_[2] = set(1.0F);
  }

  /// What the lane with most voxels has.
  HWY_INLINE int count() const {
    return any(greater(end_[2], end_[1])) ? 3 : any(greater(end_[2], end_[0])) ? 2 : 1;
  }
  HWY_INLINE const Position& at(int k) const { return at_[k]; }
  /// Shares of the way; voxels that a lane does not have end where they begin.
  HWY_INLINE F begin(int k) const { return k == 0 ? set(0.0F) : end_[k - 1]; }
  HWY_INLINE F end(int k) const { return end_[k]; }

  /// Takes voxels of equal numbers for one; `numbers` has those of count() voxels.
  HWY_INLINE void join(const F* numbers) {
    const int n = count();
    if (n == 3) end_[1] = choose(equal(numbers[1], numbers[2]), end_[2], end_[1]);
    if (n > 1) end_[0] = choose(equal(numbers[0], numbers[1]), end_[1], end_[0]);
  }

 private:
  /// Along one axis: the voxels at both ends, and the share of the way to the face between them.
  struct Steps {
    I first, last;
    F crossing;

    HWY_INLINE Steps(I from, I to, std::int32_t most) {
      // Positions are rounded down, and of two voxels that are equally near the greater is the nearest.
      constexpr std::int32_t rounding = 1;
      const auto voxel = [&](I position) HWY_ATTR {
        const I within = min(max(position, set_int(0)), set_int(most));
        return down_signed<position_bits>(add(within, set_int(one_voxel / 2 + rounding)));
      };
      const I a = voxel(from), b = voxel(to);
      const I face =
          sub(up<position_bits>(max(a, min(b, add(a, set_int(1))))), set_int(one_voxel / 2 + rounding));
      const M crosses = either(greater(a, b), greater(b, a));
      const F way = choose(crosses, to_float(sub(to, from)), set(1.0F));
      crossing =
          choose(crosses, min(max(div(to_float(sub(face, from)), way), set(0.0F)), set(1.0F)), set(1.0F));
      first = up<position_bits>(a);
      last = up<position_bits>(b);
    }
  };

  Position at_[most];
  F end_[most];
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
