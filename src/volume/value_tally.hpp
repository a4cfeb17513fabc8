#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "ringsplat/volume/statistics.hpp"

namespace ringsplat {

/// What the values of a volume are, and how a caller holds them.
struct ValueKind {
  ScalarType type = ScalarType::uint8;
  std::optional<double> fill = std::nullopt;           ///< voxels of this value are not counted
  std::optional<ScalarType> stored_as = std::nullopt;  ///< float64 where the caller has widened them
};

/// Calls `f(values)` with spans of `kind.type` that hold all values but the fill value, in order; returns how
/// many voxels had the fill value.
std::uint64_t for_each_unfilled(const ValueKind& kind, std::span<const std::byte> values,
                                const std::function<void(std::span<const std::byte>)>& f);

/// Up to `most` different values; overflown when there were more.
class DistinctValues {
 public:
  static constexpr std::size_t most = 16384;
  void add(double value);
  void merge(std::span<const double> values);
  void overflow();
  bool overflown() const { return overflown_; }
  std::vector<double> sorted() const;

 private:
  static constexpr std::size_t slots = 4 * most;
  std::vector<double> table_;  ///< open addressing; NaN: empty
  std::size_t count_ = 0;
  double last_ = 0;
  bool any_ = false, overflown_ = false;
};

/// Counts of the finite values by 16-bit keys that have the values' order: every value of an 8- or 16-bit
/// type has its own; those of wider types share the sign, exponent and first 7 bits of the mantissa of their
/// float32. So a single value far outside cannot flatten them.
class ValueTally {
 public:
  static constexpr std::size_t most_keys = 65536;

  explicit ValueTally(const ValueKind& kind);
  void add(std::span<const std::byte> values);

  /// The key of a finite value.
  static std::size_t key_of(ScalarType type, double value);
  /// The first value of a key and of the next one; equal for 8- and 16-bit types.
  struct Edges {
    double low, high;
  };
  static Edges edges_of(ScalarType type, std::size_t key);
  /// Keys that the type has.
  static std::size_t keys_of(ScalarType type);
  /// True when every value of the type has its own key.
  static bool is_exact(ScalarType type) { return size_of(type) <= 2; }

  const ValueKind& kind() const { return kind_; }

  ValueRange range;
  std::uint64_t fill = 0;             ///< voxels with the fill value
  bool whole = true;                  ///< every finite value is a whole number
  std::vector<std::uint64_t> counts;  ///< by key
  DistinctValues distinct;            ///< of wide types, while all values are whole numbers

 private:
  void count(std::span<const std::byte> values);
  void look_for_labels(std::span<const std::byte> values);

  ValueKind kind_;
};

}  // namespace ringsplat
