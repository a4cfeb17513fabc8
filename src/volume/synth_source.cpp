#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/synth.hpp"

namespace ringsplat {
namespace {

template <class T>
T scaled(double value) {
  if constexpr (std::is_floating_point_v<T>)
    return T(value);
  else
    return T(std::llround(value * double(std::numeric_limits<T>::max())));
}

class SynthSource final : public VolumeSource {
 public:
  SynthSource(std::string name, const Grid& grid, Field field)
      : name_(std::move(name)), grid_(grid), field_(field) {}
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  Facts facts() const override { return {{"synthetic volume", name_}}; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    visit_type(grid_.type, [&](auto type) {
      using T = decltype(type);
      auto* voxel = reinterpret_cast<T*>(out.data());
      for (int z = first; z < first + count; ++z)
        for (int y = 0; y < grid_.dims.y; ++y)
          for (int x = 0; x < grid_.dims.x; ++x) *voxel++ = scaled<T>(value(x, y, z));
    });
  }

 private:
  double value(int x, int y, int z) const {
    const auto& n = grid_.dims;
    if (field_ == nullptr) return glm::ivec3(x, y, z) == n / 2 ? 1 : 0;
    return field_((x + 0.5) / n.x, (y + 0.5) / n.y, (z + 0.5) / n.z);
  }

  std::string name_;
  Grid grid_;
  Field field_;  ///< null: the one voxel of "point", which depends on the lattice
};

}  // namespace

std::unique_ptr<VolumeSource> synth_source(const std::string& name, const Grid& grid) {
  check(grid, fmt::format("synthetic volume '{}'", name));
  std::vector<std::string> names;
  for (const auto& known : synth_names()) {
    if (known.name == name)
      return std::make_unique<SynthSource>(name, grid, name == "point" ? nullptr : synth_field(name));
    names.push_back(known.name);
  }
  throw InputError(fmt::format("'{}' is not a synthetic volume", name),
                   "use one of " + detail::comma_list(names));
}

}  // namespace ringsplat
