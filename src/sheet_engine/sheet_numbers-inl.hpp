// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_SHEET_NUMBERS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_SHEET_NUMBERS_INL
#undef RINGSPLAT_SHEET_NUMBERS_INL
#else
#define RINGSPLAT_SHEET_NUMBERS_INL
#endif

#include <algorithm>
#include <array>

#include "sheet_engine/lanes-inl.hpp"
#include "sheet_engine/paint_group.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

HWY_INLINE M known(F number) { return equal(number, number); }

/// Lanes' values, in planes' numbers, at the sheets from slice to slice. A slab counts as linear between two
/// ends. The field is not: along a ray it bends, and what it is on average above the line between two sheets
/// is added to both ends, as if it lay on a parabola through them and the next.
struct SheetNumbers {
  std::array<F, Traversal::most_slabs + 1> at;
  F low, high;

  HWY_INLINE F& operator[](int sheet) { return at[std::size_t(sheet)]; }
  HWY_INLINE const F& operator[](int sheet) const { return at[std::size_t(sheet)]; }

  /// What is not a number counts as less than all numbers.
  HWY_INLINE void find_range(int pieces, bool floats) {
    for (int i = 0; i <= pieces; ++i) {
      F number = (*this)[i];
      if (floats) number = choose(known(number), number, set(no_number));
      low = i == 0 ? number : min(low, number);
      high = i == 0 ? number : max(high, number);
    }
  }

  struct Ends {
    F front, back;
  };
  /// Of piece i, but never beyond the sheets' values, and as they are where one of these is not a number.
  HWY_INLINE Ends ends(int i, int pieces, bool floats) const {
    const F front = (*this)[i], back = (*this)[i + 1];
    if (pieces == 1) return {front, back};
    const int first = std::max(i, 1), last = std::min(i + 1, pieces - 1);
    F bulge = first == last ? mul(set(1.0F / 12), bend_at(first))
                            : mul(set(1.0F / 24), add(bend_at(first), bend_at(last)));
    if (floats) bulge = only(greater(low, set(no_number)), bulge);
    return {min(max(add(front, bulge), low), high), min(max(add(back, bulge), low), high)};
  }

  /// What all pieces are on average above the line between the slices.
  HWY_INLINE F whole_bulge(int pieces) const {
    const auto n = float(pieces);
    F sum = mul(set(-0.5F * (n - 1)), add((*this)[0], (*this)[pieces]));
    for (int i = 1; i < pieces; ++i) sum = add(sum, (*this)[i]);
    return mul(set(n / (n * n - 1)), sum);
  }

  /// How far they are at most beside that line, at a sheet.
  HWY_INLINE F bend(int pieces) const {
    if (pieces == 2) return mul(set(0.5F), abs(bend_at(1)));
    const F first = (*this)[0], step = mul(sub((*this)[pieces], first), set(1.0F / float(pieces)));
    F most = set(0.0F);
    for (int i = 1; i < pieces; ++i) most = max(most, abs(sub((*this)[i], fma(set(float(i)), step, first))));
    return most;
  }

 private:
  HWY_INLINE F bend_at(int sheet) const {
    const F here = (*this)[sheet];
    return sub(add(here, here), add((*this)[sheet - 1], (*this)[sheet + 1]));
  }
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
