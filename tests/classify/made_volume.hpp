#pragma once
#include <cmath>
#include <vector>

#include "classify/auto_preset.hpp"
#include "classify/type_of.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

/// Volumes made by a function of places, and what "auto" chooses for them.
namespace ringsplat {

inline constexpr int side = 32;

/// A cube of `side` voxels a side, by a function of places from -1 to 1.
template <class T>
struct Volume {
  std::vector<T> voxels;
  VolumeNotes notes = {};

  template <class F>
  explicit Volume(F&& f) {
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
          const auto place = [](int k) { return (2.0 * k + 1) / side - 1; };
          voxels.push_back(static_cast<T>(f(place(x), place(y), place(z))));
        }
  }
  ValueStatistics statistics() const {
    const Pass pass = [&](const RowVisitor& visit) { visit(std::as_bytes(std::span(voxels)), side); };
    return describe_values({.dims = glm::ivec3(side), .type = type_of<T>()}, notes, pass);
  }
  AutoChoice choice() const {
    auto made = choose_function(statistics());
    INFO(made.why);
    CHECK(message_of([&] { check(made.function, "auto"); }).empty());
    return made;
  }
  /// The share of voxels with more than a thousandth of opacity.
  double coverage(const TransferFunction& tf) const {
    double seen = 0;
    for (const T v : voxels) seen += tf.evaluate(double(v)).opacity > 1e-3;
    return seen / double(voxels.size());
  }
};

inline double radius(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

}  // namespace ringsplat
