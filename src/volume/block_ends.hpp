#pragma once
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include "ringsplat/volume/grid.hpp"
#include "volume/value_ends.hpp"

namespace ringsplat {

/// The smallest and the largest value of each block of a slice, kept in its scalar type.
class BlockEnds {
 public:
  struct Range {
    double low, high;  ///< low > high: the whole block is not-a-number
  };

  BlockEnds() = default;
  /// Row by row; T is the scalar type's.
  template <class T>
  BlockEnds(ScalarType type, const std::vector<ValueEnds<T>>& ends)
      : type_(type), ends_(ends.size() * sizeof(ValueEnds<T>)) {
    std::memcpy(ends_.data(), ends.data(), ends_.size());
  }
  /// From another one's bytes().
  BlockEnds(ScalarType type, std::span<const std::byte> bytes)
      : type_(type), ends_(bytes.begin(), bytes.end()) {}

  Range range(std::size_t block) const {
    return visit_type(type_, [&](auto zero) {
      ValueEnds<decltype(zero)> ends;
      std::memcpy(&ends, ends_.data() + block * sizeof ends, sizeof ends);
      return Range{static_cast<double>(ends.low), static_cast<double>(ends.high)};
    });
  }
  std::span<const std::byte> bytes() const { return ends_; }

 private:
  ScalarType type_ = ScalarType::uint8;
  std::vector<std::byte> ends_;
};

}  // namespace ringsplat
