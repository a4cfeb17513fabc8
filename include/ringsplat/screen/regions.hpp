#pragma once
#include <cstdint>
#include <vector>

namespace ringsplat {

/// Half-open rectangle of pixels.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool operator==(const PixelRect&) const = default;
};

/// Which Renderer owns a region: the one map from regions to Renderers, used by all.
///
/// The region in column x and row y is Renderer x + skew · y's, modulo their number, so that all have as many
/// regions or one fewer. Of the skews that keep that, the one with the longest way from a region to the
/// nearest one of the same Renderer is taken (the lattices of Korobov 1959): what lies together in the
/// picture is dealt to many. Dealing in turn is the skew of a row's length, which gives a Renderer whole
/// columns when their numbers have a common divisor. In Neumann 1992 (section 3) a Renderer has one region.
class RegionOwners {
 public:
  /// `columns`, `rows`: of regions. `dealt_to`: how many of the Renderers get any, at even distances among
  /// them all.
  RegionOwners(int columns, int rows, int renderers, int dealt_to);
  RegionOwners(int columns, int rows, int renderers) : RegionOwners(columns, rows, renderers, renderers) {}
  int of(int region) const {
    return static_cast<int>((region % columns_ + region / columns_ * skew_) % dealt_to_ * renderers_ /
                            dealt_to_);
  }

 private:
  std::int64_t columns_, renderers_, dealt_to_, skew_;
};

/// The screen cut into regions of one size, numbered row by row; those at the right and lower edge may be
/// smaller.
class Regions {
 public:
  Regions() = default;
  /// Squares. Throws InputError when a size is below 1 or the picture has more than 2^31 - 1 regions or
  /// pixels a side over 2^20.
  Regions(int width, int height, int region_size) : Regions(width, height, region_size, region_size) {}
  /// Rectangles; throws likewise.
  Regions(int width, int height, int region_width, int region_height);
  bool operator==(const Regions&) const = default;
  int count() const { return columns_ * rows_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  PixelRect rect(int region) const;

  RegionOwners owners(int renderers) const { return owners(renderers, renderers); }
  RegionOwners owners(int renderers, int dealt_to) const { return {columns_, rows_, renderers, dealt_to}; }
  std::vector<int> owned(int renderer, const RegionOwners& owners) const;

  /// The block of regions that pixels [x0, x1] × [y0, y1] (inclusive) touch, clipped to the screen, in
  /// columns and rows of regions; empty when off the screen.
  PixelRect touched(long long x0, long long y0, long long x1, long long y1) const;

 private:
  int width_ = 0, height_ = 0, region_width_ = 1, region_height_ = 1, columns_ = 0, rows_ = 0;
};

}  // namespace ringsplat
