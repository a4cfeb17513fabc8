#pragma once
// Volumes in memory, and one picture from the renderer and from each truth.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <random>
#include <set>
#include <vector>

#include "classify/normals.hpp"
#include "ringsplat/formats/open.hpp"
#include "study/error_budget.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "truth/closed_forms.hpp"
#include "truth/field.hpp"
#include "truth/method.hpp"
#include "truth/sampling.hpp"

namespace ringsplat::test {

/// A volume in memory, voxels in its scalar type.
struct Volume {
  Grid grid;
  std::vector<std::byte> bytes;
};

/// Voxel (x, y, z) is `value(x, y, z)`, converted to the type.
inline Volume make_volume(glm::ivec3 dims, ScalarType type, const std::function<double(int, int, int)>& value,
                          glm::dvec3 spacing = glm::dvec3(1.0)) {
  Volume volume{make_grid(dims, type, spacing), {}};
  volume.bytes.resize(volume.grid.bytes());
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    std::size_t at = 0;
    for (int z = 0; z < dims.z; ++z)
      for (int y = 0; y < dims.y; ++y)
        for (int x = 0; x < dims.x; ++x, ++at) {
          const T v = static_cast<T>(value(x, y, z));
          std::memcpy(volume.bytes.data() + at * sizeof(T), &v, sizeof(T));
        }
  });
  return volume;
}

/// A field of the unit cube at the voxel centres of an n³ lattice.
inline Volume sample_field(int n, const std::function<double(double, double, double)>& field,
                           ScalarType type = ScalarType::float64) {
  return make_volume(glm::ivec3(n), type,
                     [&](int x, int y, int z) { return field((x + 0.5) / n, (y + 0.5) / n, (z + 0.5) / n); });
}

/// 32 values of 0..1 in no order: noise that is the same at every call.
inline double pattern(int x, int y, int z) { return double((x * 7 + y * 13 + z * 29) % 32) / 31; }

/// Over the unit cube: detail of a few voxels; nothing at the faces.
inline double lumps_in_ball(double x, double y, double z) {
  const double r = glm::length(glm::dvec3(x, y, z) - 0.5);
  return r < 0.5
             ? std::pow(std::cos(M_PI * r), 2) * (0.8 + 0.2 * std::sin(21 * x) * std::cos(17 * y + 11 * z))
             : 0.0;
}

/// A lump with noise on it, of voxels that are no cubes.
inline constexpr glm::ivec3 lump_dims{17, 15, 19};
inline constexpr glm::dvec3 lump_spacing{1, 1.25, 0.75};
inline double noisy_lump(int x, int y, int z) {
  const double r = glm::length((glm::dvec3(x, y, z) - glm::dvec3(8, 7, 9)) / glm::dvec3(9, 8, 10));
  return 240 * std::max(0.0, 1 - r) + double((x * 7 + y * 13 + z * 29) % 32) / 4;
}
inline Volume lump_volume(ScalarType type = ScalarType::float32) {
  return make_volume(lump_dims, type, noisy_lump, lump_spacing);
}

inline Volume volume_of(VolumeSource& source) {
  Volume volume{source.grid(), {}};
  volume.bytes.resize(volume.grid.bytes());
  source.read_slices(0, volume.grid.dims.z, volume.bytes);
  return volume;
}

/// tests/data/head.nrrd, and what its presets are made for.
inline Volume head() { return volume_of(*open_volume(RINGSPLAT_TEST_DATA "/head.nrrd")); }
inline TransferFunction head_preset(const std::string& name) { return preset(name, Histogram(0, 248, 1024)); }

inline truth::Scene scene_of(const Volume& volume, const FrameSpec& spec) {
  return {volume.grid, truth::read_values(*memory_source(volume.grid, volume.bytes)), spec};
}

/// The renderer's picture, every slice composited to the end as in the truths.
inline Image rendered(const Volume& volume, const FrameSpec& frame) {
  FrameSpec spec = frame;
  spec.shown.opaque_threshold = 0;
  const auto source = memory_source(volume.grid, volume.bytes);
  return render_loopback(*source, spec, 1, 1).image;
}

/// `count` pixels of the picture, fewer than it has, ascending row by row: the same for the same seed.
inline std::vector<truth::Pixel> random_pixels(int width, int height, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::set<std::uint64_t> places;
  const std::uint64_t total = std::uint64_t(width) * std::uint64_t(height);
  for (std::uint64_t j = total - count; j < total; ++j)
    if (!places.insert(random() % (j + 1)).second) places.insert(j);
  std::vector<truth::Pixel> pixels;
  for (const std::uint64_t p : places)
    pixels.push_back({int(p % std::uint64_t(width)), int(p / std::uint64_t(width))});
  return pixels;
}

inline std::size_t pixels_of(const truth::ScreenBounds& bounds) {
  std::size_t sum = 0;
  for (const auto& row : bounds.rows) sum += std::size_t(std::max(0, row.end - row.first));
  return sum;
}

/// Where the surface normals of the splats' truth come from.
enum class Normals {
  exact,     ///< central differences, normalised
  quantised  ///< the same, rounded to the renderer's 16-bit codes: leaves only numerical error
};

/// The scene of the shown part alone, with the renderer's normals.
inline truth::Scene with_quantised_normals(const truth::Scene& whole) {
  truth::Scene scene = whole.frame.shown.clip ? truth::cropped(whole) : whole;
  Grid grid = scene.grid;
  grid.type = ScalarType::float64;
  const std::size_t slice = grid.slice_voxels(Axis::z);
  const auto values = [&](int z) {
    return z < 0 || z >= grid.dims.z
               ? nullptr
               : reinterpret_cast<const std::byte*>(scene.values.data() + std::size_t(z) * slice);
  };
  std::vector<NormalCode> codes(scene.values.size());
  for (int z = 0; z < grid.dims.z; ++z)
    slice_normals(grid, values(z - 1), values(z), values(z + 1),
                  std::span(codes).subspan(std::size_t(z) * slice, slice));
  scene.normal = [codes, dims = grid.dims](const glm::ivec3& p) {
    return decode_normal(codes[std::size_t((p.z * dims.y + p.y) * dims.x + p.x)]);
  };
  return scene;
}

inline truth::Rgba field_at(const truth::Scene& scene, truth::Pixel pixel, double tolerance = 1e-9) {
  return truth::field_truth(scene, std::vector{pixel}, tolerance).front();
}
inline truth::Rgba method_at(const truth::Scene& scene, truth::Pixel pixel) {
  return truth::method_truth(scene, std::vector{pixel}).front();
}

/// The method's own truth for the whole picture. `normals`: of splats.
inline Image method_image(const Volume& volume, const FrameSpec& spec, Normals normals = Normals::quantised) {
  const truth::Scene scene = scene_of(volume, spec);
  const bool quantised = !scene.of_sheets() && scene.shaded() && normals == Normals::quantised;
  return truth::to_image(spec.shown.width, spec.shown.height,
                         truth::method_truth(quantised ? with_quantised_normals(scene) : scene,
                                             truth::all_pixels(spec.shown.width, spec.shown.height)));
}

inline Image field_image(const Volume& volume, const FrameSpec& spec) {
  return truth::to_image(
      spec.shown.width, spec.shown.height,
      truth::field_truth(scene_of(volume, spec), truth::all_pixels(spec.shown.width, spec.shown.height)));
}

/// Largest difference between the renderer's picture and the method's own truth, of values in 0..1.
inline double numerical_error(const Volume& volume, const FrameSpec& spec) {
  return largest_difference(rendered(volume, spec), method_image(volume, spec));
}

/// Root of the mean squared difference from the truth, in 1/255.
inline double method_error(const Volume& volume, const FrameSpec& spec) {
  return truth::compare(rendered(volume, spec), method_image(volume, spec)).total.rmse;
}
inline double field_error(const Volume& volume, const FrameSpec& spec) {
  return truth::compare(rendered(volume, spec), field_image(volume, spec)).total.rmse;
}

inline double largest_difference(const std::vector<truth::Rgba>& a, const std::vector<truth::Rgba>& b) {
  double largest = 0;
  for (std::size_t p = 0; p < a.size(); ++p)
    for (int c = 0; c < 4; ++c) largest = std::max(largest, std::abs(a[p][c] - b[p][c]));
  return largest;
}

/// Every value is in 0..1, up to rounding.
inline bool all_finite(const Image& image) {
  return std::all_of(image.rgba.begin(), image.rgba.end(),
                     [](float v) { return std::isfinite(v) && v >= 0 && v <= 1.000001F; });
}

/// A picture of `size` pixels a side without shading.
inline FrameSpec plain_spec(const TransferFunction& tf, int size, const Camera& camera = {}) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.transfer_function = tf;
  spec.shown.width = spec.shown.height = size;
  spec.shown.camera = camera;
  spec.shown.shading = Shading::none;
  return spec;
}

/// A transfer function of one colour with extinction κ v: opacity 1 − exp(−κ v) for v in [0, high].
inline TransferFunction linear_extinction(double kappa, double high, int points = 2048) {
  TransferFunction tf;
  tf.colours = {{0.0, {1, 0.7, 0.4}}, {high, {1, 0.7, 0.4}}};
  for (int i = 0; i <= points; ++i) {
    const double v = high * i / points;
    tf.opacities.push_back({v, -std::expm1(-kappa * v)});
  }
  return tf;
}

}  // namespace ringsplat::test
