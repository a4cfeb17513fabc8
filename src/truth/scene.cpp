#include "truth/scene.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "truth/ray.hpp"
#include "volume/scalars.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::truth {
namespace {

/// IEC 61966-2-1:1999, section 5.2.
double linear_light(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

/// The piecewise-linear curve through `results` at ascending `values`, constant beyond the ends. Equal ends
/// are handled first, since (1 − t) a + t a may differ from a.
template <class T>
T on_line(const std::vector<double>& values, const std::vector<T>& results, double value) {
  const auto after = std::size_t(std::upper_bound(values.begin(), values.end(), value) - values.begin());
  if (after == 0) return results.front();
  if (after == values.size() || results[after - 1] == results[after]) return results[after - 1];
  // Halved, because the difference may overflow a double.
  const double t = (0.5 * value - 0.5 * values[after - 1]) / (0.5 * values[after] - 0.5 * values[after - 1]);
  return (1 - t) * results[after - 1] + t * results[after];
}

}  // namespace

Scene cropped(const Scene& scene) {
  check(*scene.frame.shown.clip, scene.grid);
  const glm::ivec3 first = scene.frame.shown.clip->first, end = scene.frame.shown.clip->end,
                   dims = scene.grid.dims;
  Scene part = scene;
  part.frame.shown.clip.reset();
  part.cut_from = {{dims, scene.grid.spacing, scene.grid.origin, scene.grid.direction}, first};
  part.grid.dims = end - first;
  part.grid.origin = scene.grid.origin + scene.grid.direction * (scene.grid.spacing * glm::dvec3(first));
  const auto crop = [&](auto& all) {
    auto to = all.begin();
    for (int z = first.z; z < end.z && !all.empty(); ++z)
      for (int y = first.y; y < end.y; ++y) {
        const auto row = all.begin() + (std::ptrdiff_t(z) * dims.y + y) * dims.x;
        to = std::copy(row + first.x, row + end.x, to);
      }
    all.resize(std::size_t(to - all.begin()));
  };
  crop(part.values);
  crop(part.labels);
  return part;
}

std::vector<std::uint8_t> read_labels(VolumeSource& labels) {
  std::vector<std::uint8_t> all(std::size_t(labels.grid().voxels()));
  labels.read_slices(0, labels.grid().dims.z, std::as_writable_bytes(std::span(all)));
  return all;
}

std::vector<double> read_values(VolumeSource& source) {
  const Grid& grid = source.grid();
  std::vector<double> values;
  values.reserve(std::size_t(grid.voxels()));
  visit_slices(source, 0, grid.dims.z, [&](std::span<const std::byte> slice, int) {
    for_values(grid.type, slice, [&](auto some) { values.insert(values.end(), some.begin(), some.end()); });
  });
  return values;
}

std::vector<Pixel> all_pixels(int width, int height) {
  std::vector<Pixel> pixels;
  pixels.reserve(std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixels.push_back({x, y});
  return pixels;
}

Image to_image(int width, int height, std::span<const Rgba> colours) {
  Image image(width, height);
  for (std::size_t p = 0; p < colours.size(); ++p)
    for (int c = 0; c < 4; ++c) image.rgba[4 * p + std::size_t(c)] = static_cast<float>(colours[p][c]);
  return image;
}

TransferCurve::TransferCurve(const TransferFunction& tf) {
  for (const auto& p : tf.colours) {
    colour_values_.push_back(p.value);
    colours_.emplace_back(linear_light(p.srgb.x), linear_light(p.srgb.y), linear_light(p.srgb.z));
  }
  for (const auto& p : tf.opacities) {
    opacity_values_.push_back(p.value);
    opacities_.push_back(p.opacity);
  }
  knots_ = colour_values_;
  knots_.insert(knots_.end(), opacity_values_.begin(), opacity_values_.end());
  std::sort(knots_.begin(), knots_.end());
  knots_.erase(std::unique(knots_.begin(), knots_.end()), knots_.end());
}

TransferCurve::Sample TransferCurve::at(double value) const {
  if (std::isnan(value)) return {};
  return {on_line(colour_values_, colours_, value), on_line(opacity_values_, opacities_, value)};
}

bool TransferCurve::visible(double low, double high) const {
  if (!(low <= high)) return false;
  if (on_line(opacity_values_, opacities_, low) > 0 || on_line(opacity_values_, opacities_, high) > 0)
    return true;
  for (std::size_t i = 0; i < opacity_values_.size(); ++i)
    if (opacities_[i] > 0 && opacity_values_[i] >= low && opacity_values_[i] <= high) return true;
  return false;
}

double TransferCurve::bounded(double value) const {
  if (!std::isinf(value)) return value;
  const double margin = 1 + std::abs(value > 0 ? knots_.back() : knots_.front());
  return value > 0 ? knots_.back() + margin : knots_.front() - margin;
}

Tints::Tints(const Scene& scene) : scene_(scene), any_(!scene.labels.empty()) {
  for (const Tint& tint : scene.frame.shown.tints)
    of_label_[std::size_t(tint.label)] = {glm::dvec3(tint.colour), tint.share};
}

glm::dvec3 Tints::on(const glm::dvec3& colour, const glm::dvec3& point) const {
  if (!any_) return colour;
  const glm::dvec4& tint = of(nearest_voxel(point, scene_.grid.dims));
  return glm::mix(colour, glm::dvec3(tint), tint.w);
}

Phong::Phong(const Scene& scene, const ViewTransform& view)
    : material_(scene.frame.shown.material),
      to_light_(glm::normalize(view.right * scene.frame.shown.light.x + view.up * scene.frame.shown.light.y +
                               view.to_viewer * scene.frame.shown.light.z)) {}

Phong::Light Phong::light(const glm::dvec3& normal, const glm::dvec3& to_viewer) const {
  const double length = glm::length(normal);
  if (!(length > 0) || !std::isfinite(length)) return {};
  glm::dvec3 n = normal / length;
  if (glm::dot(n, to_viewer) < 0) n = -n;  // the side that is seen
  const double towards_light = glm::dot(n, to_light_);
  Light light{material_.ambient + material_.diffuse * std::abs(towards_light), 0};
  if (towards_light > 0) {
    const glm::dvec3 mirrored = 2 * towards_light * n - to_light_;
    const double toward_eye = glm::dot(mirrored, to_viewer);
    if (toward_eye > 0 && glm::dot(n, to_viewer) > 0)
      light.highlight = material_.specular * std::pow(toward_eye, material_.exponent);
  }
  return light;
}

glm::dmat3 against_gradient(const glm::dmat3& direction, const glm::dvec3& size) {
  const double smallest = std::min({size.x, size.y, size.z});
  const glm::dmat3 inverse = glm::inverse(direction);
  glm::dmat3 against{1.0};
  // The gradient is a covector, so it is mapped by the inverse transpose, whose columns are the inverse's
  // rows.
  for (int k = 0; k < 3; ++k)
    against[k] = -(smallest / size[k]) * glm::dvec3(inverse[0][k], inverse[1][k], inverse[2][k]);
  return against;
}

Gradients::Gradients(const Scene& scene)
    : scene_(scene), to_world_(against_gradient(scene.grid.direction, scene.grid.spacing)) {
  double largest = 0;
  for (const double v : scene.values)
    if (std::isfinite(v)) largest = std::max(largest, std::abs(v));
  if (largest > 0) scale_ = 1 / static_cast<long double>(largest);
}

double Gradients::unit() const { return double(scale_) * scene_.grid.unit_length(); }

double Gradients::left_at_edge(double extinction, const glm::dvec3& normal) const {
  if (!scene_.frame.shown.edges) return extinction;
  const auto [from, to] = *scene_.frame.shown.edges;
  const double share = std::clamp((glm::length(normal) / unit() - from) / (to - from), 0.0, 1.0);
  return share > 0 ? share * extinction : 0;
}

glm::dvec3 Gradients::at(const glm::ivec3& voxel) const {
  const auto& dims = scene_.grid.dims;
  const std::size_t stride[3] = {1, std::size_t(dims.x), std::size_t(dims.x) * std::size_t(dims.y)};
  const std::size_t here = scene_.index(voxel);
  const double centre = scene_.values[here];
  if (!std::isfinite(centre)) return glm::dvec3(0.0);
  glm::dvec3 difference{0.0};
  for (int k = 0; k < 3; ++k) {
    double before = centre, after = centre;
    int steps = 0;
    if (voxel[k] > 0 && std::isfinite(scene_.values[here - stride[k]]))
      before = scene_.values[here - stride[k]], ++steps;
    if (voxel[k] + 1 < dims[k] && std::isfinite(scene_.values[here + stride[k]]))
      after = scene_.values[here + stride[k]], ++steps;
    if (steps > 0)
      difference[k] = static_cast<double>(
          (static_cast<long double>(after) - static_cast<long double>(before)) * scale_ / steps);
  }
  return to_world_ * difference;
}

}  // namespace ringsplat::truth
