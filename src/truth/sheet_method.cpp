#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "truth/method.hpp"
#include "truth/ray.hpp"
#include "truth/slab_integral.hpp"

namespace ringsplat::truth {
namespace {

/// A sheet's place among the slices: slice + share, except for the box's faces, which show the outer slices.
struct SheetPlace {
  double z;
  int slice;
  double share;  ///< of the way to the next slice
};

std::vector<SheetPlace> sheet_places(int slices, int slabs, bool nearest) {
  if (nearest) slabs += slabs % 2;
  const int in_half = nearest ? slabs / 2 : Traversal::slabs_in_half(slabs);
  std::vector<SheetPlace> places;
  for (int j = 0; j < in_half; ++j) places.push_back({-0.5 + 0.5 * j / in_half, 0, 0.0});
  for (int i = 0; i < slices; ++i)
    for (int j = 0; j < (i + 1 < slices ? slabs : 1); ++j)
      places.push_back({i + double(j) / slabs, i, double(j) / slabs});
  for (int j = 1; j <= in_half; ++j) places.push_back({slices - 1 + 0.5 * j / in_half, slices - 1, 0.0});
  return places;
}

/// The share of the way from `a` to `b`, each along one axis, that lies in [low, high).
struct Share {
  double first = 0, last = 1;
  void clip(double a, double b, double low, double high) {
    constexpr double parallel = 1e-12;
    if (std::abs(b - a) < parallel) {
      if (a < low - in_face || a >= high - in_face) last = first;
      return;
    }
    const double at_low = (low - a) / (b - a), at_high = (high - a) / (b - a);
    first = std::max(first, std::min(at_low, at_high));
    last = std::min(last, std::max(at_low, at_high));
  }
  double size() const { return std::max(0.0, last - first); }
};

class SheetTracer : Tracer {
 public:
  explicit SheetTracer(const Scene& scene)
      : Tracer(scene),
        traversal_(choose_traversal(rays_.view(), lattice_of(scene.grid), SliceRule::most_crossed)),
        axis_(int(traversal_.axis)),
        slabs_(traversal_.slabs_for(scene.frame.as<Sheets>().slabs)),
        places_(sheet_places(scene.grid.dims[axis_], slabs_, scene.nearest())),
        gradients_(scene) {}

  Rgba operator()(Pixel pixel) const {
    const LatticeRay ray = rays_.through(pixel);
    if (!(ray.enter < ray.leave)) return Rgba(0.0);
    const int slabs = int(places_.size()) - 1;
    Rgba seen(0.0, 0.0, 0.0, 1.0);  // colour and transmittance so far
    std::optional<Sheet> front;
    for (int step = 0; step < slabs; ++step) {
      const int first = traversal_.ascending ? step : slabs - step,
                second = traversal_.ascending ? step + 1 : slabs - step - 1;
      const Share inside = share_inside(ray, first, second);
      if (!(inside.size() > 0)) {
        front.reset();
        continue;
      }
      if (!front) front = sheet(ray, first);
      Sheet back = sheet(ray, second);
      if (scene_.nearest())
        add_voxels(ray, *front, back, inside, seen);
      else
        add_slab(ray, *front, back, ends(ray, std::min(first, second), *front, back), inside.size(), seen);
      front = std::move(back);
    }
    seen.w = 1 - seen.w;
    return seen;
  }

 private:
  /// Where a ray meets a sheet, and what is there.
  struct Sheet {
    double z;
    Cell cell;
    glm::dvec3 place;  ///< in the cell
    std::optional<double> value;
    std::optional<glm::dvec3> normal = std::nullopt;  ///< against the gradient; computed when asked for
  };

  glm::dvec3 meets(const LatticeRay& ray, double z) const {
    return ray.at((z - ray.origin[axis_]) / ray.step[axis_]);
  }

  Share share_inside(const LatticeRay& ray, int first, int second) const {
    const glm::dvec3 a = meets(ray, places_[std::size_t(first)].z),
                     b = meets(ray, places_[std::size_t(second)].z);
    const auto [u, v] = in_plane(traversal_.axis);
    Share share;
    for (const int k : {u, v}) share.clip(a[k], b[k], -0.5, scene_.grid.dims[k] - 0.5);
    for (const CutPlane& plane : rays_.planes()) share.clip(plane.at(a), plane.at(b), 0, INFINITY);
    return share;
  }

  Sheet sheet(const LatticeRay& ray, int index) const {
    const SheetPlace& at = places_[std::size_t(index)];
    const glm::dvec3 last(scene_.grid.dims - 1);
    const glm::dvec3 p = glm::clamp(meets(ray, at.z), glm::dvec3(0.0), last);
    Sheet sheet{at.z, {glm::ivec3(glm::floor(p)), {}}, p - glm::floor(p), {}};
    sheet.cell.high = glm::min(sheet.cell.low + 1, scene_.grid.dims - 1);
    sheet.cell.low[axis_] = at.slice;
    sheet.cell.high[axis_] = at.slice + (at.share > 0 ? 1 : 0);
    sheet.place[axis_] = at.share;
    if (const auto values = cell_values(scene_, curve_, sheet.cell)) sheet.value = values->at(sheet.place);
    return sheet;
  }

  struct Ends {
    std::optional<double> front, back;
  };

  /// Of slab `index`: its sheets' values and what its values are on average above the line between them, by
  /// the parabolas through the sheets beside it, but within the values of all sheets from slice to slice.
  Ends ends(const LatticeRay& ray, int index, const Sheet& front, const Sheet& back) const {
    const SheetPlace& at = places_[std::size_t(index)];
    if (slabs_ == 1 || at.z < 0 || at.z >= scene_.grid.dims[axis_] - 1) return {front.value, back.value};
    const int slab = int(std::lround(at.share * slabs_));
    std::array<double, Traversal::most_slabs + 1> values{};
    for (int k = 0; k <= slabs_; ++k) {
      const auto value = sheet(ray, index - slab + k).value;
      if (!value) return {front.value, back.value};
      values[std::size_t(k)] = *value;
    }
    const auto bend = [&values](int k) {
      const double* v = &values[std::size_t(k)];
      return v[-1] - 2 * v[0] + v[1];
    };
    const double more = -(bend(std::max(slab, 1)) + bend(std::min(slab + 1, slabs_ - 1))) / 24;
    const auto [low, high] = std::minmax_element(values.begin(), values.begin() + slabs_ + 1);
    return {std::clamp(*front.value + more, *low, *high), std::clamp(*back.value + more, *low, *high)};
  }

  const glm::dvec3& normal(Sheet& sheet) const {
    if (!sheet.normal) sheet.normal = trilinear(cell_normals(gradients_, sheet.cell), sheet.place);
    return *sheet.normal;
  }

  /// The normals where a slab is lit.
  std::vector<glm::dvec3> normals(const SlabIntegral& slab, Sheet& front, Sheet& back) const {
    const glm::dvec3 n0 = normal(front), n1 = normal(back);
    const auto at = [&](double t) { return (1 - t) * n0 + t * n1; };
    if (scene_.frame.as<Sheets>().light_points == 1) return {at(slab.centroid)};
    return {at(std::max(slab.centroid - slab.spread, 0.0)), at(std::min(slab.centroid + slab.spread, 1.0))};
  }

  void add_slab(const LatticeRay& ray, Sheet& front, Sheet& back, const Ends& ends, double part,
                Rgba& seen) const {
    if (!ends.front || !ends.back) return;
    const auto [low, high] = std::minmax({*ends.front, *ends.back});
    if (!curve_.visible(low, high)) return;
    SlabIntegral slab = integrate_slab(curve_, *ends.front, *ends.back, length(ray, front, back));
    // Of slices that are equally near the front one counts.
    constexpr double middle = 0.5 - 1e-6;
    slab.colour = tints_.on(slab.colour, place_between(ray, front, back, middle));
    const double opacity =
        part < 1 && slab.opacity < 1 ? -std::expm1(part * std::log1p(-slab.opacity)) : slab.opacity;
    composite(ray, slab, opacity, front, back, seen);
  }

  /// Of nearest values, a slab's voxels one by one; neighbours of one value are one.
  void add_voxels(const LatticeRay& ray, Sheet& front, Sheet& back, const Share& inside, Rgba& seen) const {
    const std::vector<double> faces = faces_between(ray, front, back, inside);
    for (std::size_t i = 0, next; i + 1 < faces.size(); i = next) {
      const auto value = value_between(ray, front, back, faces[i], faces[i + 1]);
      for (next = i + 1; next + 1 < faces.size(); ++next)
        if (tints_.any() || value_between(ray, front, back, faces[next], faces[next + 1]) != value) break;
      const double from = faces[i], part = faces[next] - from;
      if (!value) continue;
      SlabIntegral slab = integrate_slab(curve_, *value, *value, part * length(ray, front, back));
      slab.centroid = from + part * slab.centroid;
      slab.spread *= part;
      slab.colour = tints_.on(slab.colour, place_between(ray, front, back, from + 0.5 * part));
      composite(ray, slab, slab.opacity, front, back, seen);
    }
  }

  /// Where the way between two sheets goes from voxel to voxel, and its ends.
  std::vector<double> faces_between(const LatticeRay& ray, const Sheet& front, const Sheet& back,
                                    const Share& inside) const {
    const glm::dvec3 a = meets(ray, front.z), b = meets(ray, back.z);
    std::vector<double> faces{inside.first, inside.last};
    const auto [u, v] = in_plane(traversal_.axis);
    for (const int k : {u, v})
      for (double face = std::ceil(std::min(a[k], b[k]) - 0.5) + 0.5; face < std::max(a[k], b[k]); ++face)
        faces.push_back(std::clamp((face - a[k]) / (b[k] - a[k]), inside.first, inside.last));
    std::ranges::sort(faces);
    return faces;
  }

  /// At a share of the way between two sheets.
  glm::dvec3 place_between(const LatticeRay& ray, const Sheet& front, const Sheet& back, double share) const {
    return glm::mix(meets(ray, front.z), meets(ray, back.z), share);
  }

  /// That of the voxel half-way between two shares of the way between two sheets.
  std::optional<double> value_between(const LatticeRay& ray, const Sheet& front, const Sheet& back,
                                      double from, double to) const {
    const glm::ivec3 voxel =
        nearest_voxel(place_between(ray, front, back, 0.5 * (from + to)), scene_.grid.dims);
    const auto values = cell_values(scene_, curve_, {voxel, voxel});
    return values ? std::optional(values->low) : std::nullopt;
  }

  double length(const LatticeRay& ray, const Sheet& front, const Sheet& back) const {
    return slice_length(ray, axis_) * std::abs(back.z - front.z);
  }

  void composite(const LatticeRay& ray, const SlabIntegral& slab, double opacity, Sheet& front, Sheet& back,
                 Rgba& seen) const {
    if (!(opacity > 0)) return;
    std::vector<glm::dvec3> lit_at;
    if (scene_.needs_gradients()) lit_at = normals(slab, front, back);
    Phong::Light mean{scene_.shaded() ? 0.0 : 1.0, 0};
    double share = 0;  // of the opacity that is left by how steep the field is there
    for (const glm::dvec3& normal : lit_at) {
      const Phong::Light one = scene_.shaded() ? phong_.light(normal, ray.to_viewer) : Phong::Light{0, 0};
      mean.scale += one.scale / double(lit_at.size());
      mean.highlight += one.highlight / double(lit_at.size());
      share += gradients_.left_at_edge(1, normal) / double(lit_at.size());
    }
    if (shown_.edges) opacity = opacity == 1 ? double(share > 0) : -std::expm1(share * std::log1p(-opacity));
    const glm::dvec3 colour = mean.on(slab.colour);
    for (int c = 0; c < 3; ++c) seen[c] += seen.w * opacity * colour[c];
    seen.w *= 1 - opacity;
  }

  Traversal traversal_;
  int axis_, slabs_;
  std::vector<SheetPlace> places_;
  Gradients gradients_;
};

}  // namespace

std::vector<Rgba> sheet_method_truth(const Scene& scene, std::span<const Pixel> pixels) {
  if (scene.frame.shown.clip) return sheet_method_truth(cropped(scene), pixels);
  return along_rays(scene, pixels, SheetTracer(scene));
}

}  // namespace ringsplat::truth
