#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ringsplat {

/// Half-open range of a row's columns.
struct Columns {
  std::uint32_t first, end;
  bool empty() const { return first >= end; }
};

/// A row's positions along one axis of the image plane.
class RowAxis {
 public:
  /// `step`: distance from column to column.
  explicit RowAxis(double step) : inverse_(1 / step) {}
  void begin_row(double start) { start_ = start; }
  /// The columns among `columns` whose positions lie within [low, high].
  Columns within(double low, double high, Columns columns) const {
    if (!std::isfinite(inverse_)) return start_ >= low && start_ <= high ? columns : Columns{0, 0};
    const double a = (low - start_) * inverse_, b = (high - start_) * inverse_;
    const double first = std::max(std::min(a, b), double(columns.first)),
                 last = std::min(std::max(a, b), double(columns.end) - 1);
    if (!(first <= last)) return {0, 0};
    const auto truncated = static_cast<std::uint32_t>(static_cast<std::int64_t>(first));
    return {truncated + (double(truncated) < first),
            static_cast<std::uint32_t>(static_cast<std::int64_t>(last)) + 1};
  }

 private:
  double inverse_, start_ = 0;
};

}  // namespace ringsplat
