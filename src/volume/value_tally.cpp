#include <bit>
#include <type_traits>

#include "volume/scalars.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat {
namespace {

constexpr std::size_t chunk_values = 16384;

/// A wide type's nearest float32; those beyond its range become its largest.
template <class T>
float narrowed(T value) {
  constexpr double most = std::numeric_limits<float>::max();
  return float(std::clamp(double(value), -most, most));
}

/// The upper half of bits that have the order of the values. Adding 0 makes +0 of −0.
std::size_t key_of_float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);
  return ((bits >> 31) != 0 ? ~bits : bits | 0x80000000U) >> 16;
}

double float_of_key(std::size_t key) {
  if (key >= ValueTally::most_keys) return std::numeric_limits<double>::infinity();
  const auto ordered = std::uint32_t(key) << 16;
  const std::uint32_t bits = (ordered >> 31) != 0 ? ordered & 0x7fffffffU : ~ordered;
  const double value = double(std::bit_cast<float>(bits));
  return std::isnan(value) ? (ordered >> 31 ? 1 : -1) * std::numeric_limits<double>::infinity() : value;
}

template <class T>
std::size_t key_of_value(T value) {
  if constexpr (sizeof(T) <= 2)
    return std::size_t(int(value) - int(std::numeric_limits<T>::min()));
  else
    return key_of_float(narrowed(value));
}

template <class T>
std::uint64_t pass_on_without(T fill, std::span<const T> values,
                              const std::function<void(std::span<const std::byte>)>& f) {
  std::uint64_t filled = 0;
  std::vector<T> kept(std::min(values.size(), chunk_values));
  for (std::size_t first = 0; first < values.size(); first += chunk_values) {
    const auto part = values.subspan(first, std::min(chunk_values, values.size() - first));
    const auto end = std::remove_copy(part.begin(), part.end(), kept.begin(), fill);
    const std::span<const T> rest(kept.begin(), end);
    filled += part.size() - rest.size();
    f(std::as_bytes(rest));
  }
  return filled;
}

/// The fill value, if the type has it.
template <class T>
std::optional<T> fill_of(const ValueKind& kind) {
  using Limits = std::numeric_limits<T>;
  const double fill = kind.fill.value_or(std::numeric_limits<double>::quiet_NaN());
  const bool held = fill >= double(Limits::lowest()) && fill <= double(Limits::max()) &&
                    (!std::is_integral_v<T> || fill == std::floor(fill));
  return held ? std::optional(static_cast<T>(fill)) : std::nullopt;
}

}  // namespace

std::uint64_t for_each_unfilled(const ValueKind& kind, std::span<const std::byte> values,
                                const std::function<void(std::span<const std::byte>)>& f) {
  return visit_type(kind.type, [&](auto zero) -> std::uint64_t {
    using T = decltype(zero);
    if (const auto fill = fill_of<T>(kind)) return pass_on_without(*fill, typed<T>(values), f);
    f(values);
    return 0;
  });
}

ValueTally::ValueTally(const ValueKind& kind)
    : counts(size_of(kind.type) == 1 ? 256 : most_keys), kind_(kind) {}

ValueTally::Edges ValueTally::edges_of(ScalarType type, std::size_t key) {
  if (!is_exact(type)) return {float_of_key(key), float_of_key(key + 1)};
  const double value = visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if constexpr (std::is_integral_v<T>)
      return double(std::int64_t(key)) + double(std::numeric_limits<T>::min());
    return 0.0;
  });
  return {value, value};
}

void ValueTally::add(std::span<const std::byte> values) {
  fill += for_each_unfilled(kind_, values, [this](std::span<const std::byte> some) {
    range.add(kind_.type, some);
    const bool looks_for_labels = !is_exact(kind_.type) && !distinct.overflown();
    for_values(kind_.type, some, [&](auto typed_values) {
      for (const auto value : typed_values) {
        if (!is_finite(value)) continue;
        ++counts[key_of_value(value)];
        if (looks_for_labels) distinct.add(double(value));
      }
    });
  });
}

}  // namespace ringsplat
