#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/synth.hpp"

namespace ringsplat {
namespace {

constexpr double pi = std::numbers::pi;

double radius(double x, double y, double z) { return std::hypot(x - 0.5, y - 0.5, z - 0.5); }

bool within(double v, double low, double high) { return low <= v && v < high; }

double constant(double, double, double) { return 1; }

double slab(double, double, double z) { return within(z, 0.25, 0.75) ? 1 : 0; }

double ball(double x, double y, double z) { return std::max(0.0, 1 - 2 * radius(x, y, z)); }

double box(double x, double y, double z) {
  return within(x, 0.25, 0.75) && within(y, 0.25, 0.75) && within(z, 0.25, 0.75) ? 1 : 0;
}

double shell(double x, double y, double z) {
  const double t = (radius(x, y, z) - 0.35) / 0.03;
  return std::exp(-t * t);
}

double gaussians(double x, double y, double z) {
  struct Blob {
    double x, y, z, sigma, weight;
  };
  constexpr std::array<Blob, 5> blobs{{{0.50, 0.50, 0.50, 0.10, 0.9},
                                       {0.30, 0.35, 0.65, 0.07, 0.7},
                                       {0.70, 0.40, 0.30, 0.08, 0.6},
                                       {0.40, 0.70, 0.30, 0.06, 0.8},
                                       {0.65, 0.65, 0.75, 0.05, 0.5}}};
  double sum = 0;
  for (const auto& b : blobs) {
    const double dx = x - b.x, dy = y - b.y, dz = z - b.z;
    sum += b.weight * std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * b.sigma * b.sigma));
  }
  return std::min(sum, 1.0);
}

/// Marschner and Lobb 1994, section 5, with their f_M = 6 and alpha = 0.25 on [-1, 1]^3.
double marschner_lobb(double x, double y, double z) {
  constexpr double frequency = 6, alpha = 0.25;
  const double r = std::hypot(2 * x - 1, 2 * y - 1), height = 2 * z - 1;
  const double ring = std::cos(2 * pi * frequency * std::cos(pi * r / 2));
  return (1 - std::sin(pi * height / 2) + alpha * (1 + ring)) / (2 * (1 + alpha));
}

double ramp(double x, double, double) { return x; }

/// Arms of length 0.4, 0.28 and 0.18 along +x, +y and +z from the centre, a ball where they meet, and an F
/// that reads correctly when seen along +y with z up.
double jack(double x, double y, double z) {
  constexpr double thickness = 0.045;
  const double dx = x - 0.5, dy = y - 0.5, dz = z - 0.5;
  const auto arm = [](double along, double across, double other, double length) {
    return within(along, 0, length) && std::hypot(across, other) < thickness;
  };
  if (arm(dx, dy, dz, 0.40) || arm(dy, dx, dz, 0.28) || arm(dz, dx, dy, 0.18)) return 1;
  if (radius(x, y, z) < 0.08) return 1;
  if (!within(y, 0.10, 0.18)) return 0;
  const bool stem = within(x, 0.12, 0.18) && within(z, 0.12, 0.44);
  const bool top = within(x, 0.12, 0.36) && within(z, 0.38, 0.44);
  const bool middle = within(x, 0.12, 0.29) && within(z, 0.25, 0.31);
  return stem || top || middle ? 1 : 0;
}

constexpr SynthName entries[] = {
    {"constant", "1 everywhere", constant},
    {"slab", "1 in the middle half along z, 0 elsewhere", slab},
    {"ball", "1 at the centre, falling linearly to 0 at radius 1/2", ball},
    {"box", "1 in the middle half of every axis, 0 elsewhere", box},
    {"shell", "thin soft sphere of radius 0.35", shell},
    {"gaussians", "five Gaussian blobs of different size and weight", gaussians},
    {"marschner-lobb", "Marschner and Lobb's test signal, f_M = 6, alpha = 0.25", marschner_lobb},
    {"ramp", "0 to 1 along x", ramp},
    {"jack", "unequal arms along +x, +y, +z and a letter F: shows handedness", jack},
    {"point", "1 at the one voxel dims / 2, 0 elsewhere", nullptr},
};

template <class T>
T scaled(double value) {
  return T(std::is_floating_point_v<T> ? value : std::round(value * double(std::numeric_limits<T>::max())));
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

/// Of those that are wanted the one of that name; else throws InputError: `what` lists them.
const SynthName& entry_of(const std::string& name, const char* what, bool with_point) {
  std::vector<std::string> names;
  for (const SynthName& e : entries) {
    if (e.field == nullptr && !with_point) continue;
    if (name == e.name) return e;
    names.emplace_back(e.name);
  }
  throw InputError(fmt::format("'{}' is not a {}", name, what), "use one of " + detail::joined(names));
}

}  // namespace

std::span<const SynthName> synth_names() { return entries; }

Field synth_field(const std::string& name) { return entry_of(name, "field", false).field; }

std::unique_ptr<VolumeSource> synth_source(const std::string& name, const Grid& grid) {
  check(grid, fmt::format("synthetic volume '{}'", name));
  return std::make_unique<SynthSource>(name, grid, entry_of(name, "synthetic volume", true).field);
}

}  // namespace ringsplat
