#include "truth/field.hpp"

#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <glm/geometric.hpp>

#include "ringsplat/base/error.hpp"
#include "truth/cubic.hpp"
#include "truth/quadrature.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

class FieldIntegrator : Tracer {
 public:
  FieldIntegrator(const Scene& scene, double tolerance)
      : Tracer(scene), tolerance_(tolerance), gradients_(scene) {}

  Rgba operator()(Pixel pixel) const {
    const LatticeRay ray = rays_.through(pixel);
    if (!(ray.enter < ray.leave)) return Rgba(0.0);
    if (shown_.mode == Mode::surface) return first_surface(ray);
    if (shown_.mode != Mode::composite) {
      const bool attenuated = shown_.mode == Mode::attenuated;
      const double value = attenuated ? dimmed(ray) : projected(ray);
      if (std::isnan(value)) return Rgba(0.0);
      if (shown_.values) return Rgba(glm::dvec3(value), 1);
      const auto sample = curve_.at(value);
      const double opacity = attenuated ? 1 : sample.opacity;
      glm::dvec3 colour = sample.colour;
      if (scene_.is_slice()) colour = tints_.on(colour, ray.at(0.5 * (ray.enter + ray.leave)));
      return Rgba(colour * opacity, opacity);
    }
    Piece seen;
    for (const Crossing& crossing : crossings(ray)) {
      if (seen.transmittance < 0.1 * tolerance_) break;
      if (const auto deep = integrate_crossing(ray, crossing, seen)) return depth(ray, *deep);
    }
    return shown_.values ? Rgba(0.0) : Rgba(seen.colour, 1 - seen.transmittance);
  }

 private:
  /// How far a place is behind the plane through the volume's middle.
  Rgba depth(const LatticeRay& ray, double s) const {
    return Rgba(glm::dvec3(rays_.view().project(ray.at(s)).z / rays_.view().pixels_per_unit), 1);
  }

  /// The cells along a ray, front to back.
  std::vector<Crossing> crossings(const LatticeRay& ray) const {
    const std::vector<Cut> cuts = cuts_along(scene_, ray);
    std::vector<Crossing> crossings;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
      if (cuts[i].at < cuts[i + 1].at)
        crossings.push_back(crossing_between(scene_, ray, cuts[i].at, cuts[i + 1].at));
    return crossings;
  }

  /// The values along a crossing, where all voxels are numbers.
  std::optional<Cubic> cubic_in(const LatticeRay& ray, const Crossing& crossing) const {
    const auto values = cell_values(scene_, curve_, crossing.cell);
    if (!values) return std::nullopt;
    return cubic_along(crossing.enter, crossing.leave,
                       [&](double s) { return values->at(ray.at(s) - glm::dvec3(crossing.corner)); });
  }

  /// A ray's extremum, mean or integral; not-a-number for the extremum of nothing else.
  double projected(const LatticeRay& ray) const {
    const TransferFunction& tf = shown_.transfer_function;
    const auto further = [&](double a, double b) {
      return shown_.mode == Mode::mip ? std::max(a, b) : std::min(a, b);
    };
    double extremum = shown_.mode == Mode::mip
                          ? std::min(tf.colours.front().value, tf.opacities.front().value)
                          : std::max(tf.colours.back().value, tf.opacities.back().value),
           integral = 0;
    bool met = false;
    for (const Crossing& crossing : crossings(ray)) {
      const auto cubic = cubic_in(ray, crossing);
      if (!cubic) continue;
      met = true;
      for (const double s : monotone_pieces(*cubic)) extremum = further(extremum, cubic->at(s));
      integral += (crossing.leave - crossing.enter) * (cubic->at(0) + 4 * cubic->at(0.5) + cubic->at(1)) / 6;
    }
    if (shown_.mode == Mode::sum) return integral * scene_.grid.unit_length();
    if (shown_.mode == Mode::mean) return integral / (ray.leave - ray.enter);
    return met ? extremum : std::numeric_limits<double>::quiet_NaN();
  }

  /// The most of what is left of values in the colours' window behind others.
  double dimmed(const LatticeRay& ray) const {
    const TransferFunction& tf = shown_.transfer_function;
    const double low = tf.colours.front().value, high = tf.colours.back().value;
    if (!(low < high)) return low;
    double densest = 0, depth = 0, most = 0;
    for (const auto& point : tf.opacities) densest = std::max(densest, point.opacity);
    const double dimming = extinction(std::min(densest, 0.999));
    for (const Crossing& crossing : crossings(ray)) {
      const auto cubic = cubic_in(ray, crossing);
      if (!cubic) continue;
      const auto share = [&](double s) { return std::clamp((cubic->at(s) - low) / (high - low), 0.0, 1.0); };
      // Between these the share is a cubic that falls, or rises, or stays.
      const std::vector<double> cuts = cuts_at_knots(*cubic, {low, high});
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const double a = cuts[i], b = cuts[i + 1];
        const auto depth_at = [&](double s) {
          const double way = (s - a) * (crossing.leave - crossing.enter);
          return depth + dimming * way * (share(a) + 4 * share(0.5 * (a + s)) + share(s)) / 6;
        };
        const auto left = [&](double s) { return share(s) * std::exp(-depth_at(s)); };
        most = std::max({most, left(a), left(b)});
        if (share(a) < share(b) && share(b) * std::exp(-depth) > most)
          most = std::max(most, highest(left, a, b));
        depth = depth_at(b);
      }
    }
    return std::lerp(low, high, most);
  }

  /// Between a and b, where it turns a few times at most.
  template <class Function>
  static double highest(const Function& f, double a, double b) {
    constexpr int parts = 4;
    constexpr int digits = 26;  // of the place, in bits: the value is flat there
    double most = f(a);
    for (int k = 0; k < parts; ++k)
      most = std::max(most, -boost::math::tools::brent_find_minima(
                                 [&](double s) { return -f(s); }, std::lerp(a, b, double(k) / parts),
                                 std::lerp(a, b, double(k + 1) / parts), digits)
                                 .second);
    return most;
  }

  /// Where the field is first on the other side of the surface's value than before; opaque.
  Rgba first_surface(const LatticeRay& ray) const {
    for (const Crossing& crossing : crossings(ray)) {
      const auto cubic = cubic_in(ray, crossing);
      if (!cubic) continue;
      const std::vector<double> monotone = monotone_pieces(*cubic);
      for (std::size_t i = 0; i + 1 < monotone.size(); ++i) {
        const double a = monotone[i], b = monotone[i + 1], value = shown_.isovalue;
        if ((cubic->at(a) >= value) == (cubic->at(b) >= value)) continue;
        const double s = std::lerp(crossing.enter, crossing.leave, crossing_of(*cubic, value, a, b));
        if (shown_.values) return depth(ray, s);
        glm::dvec3 colour = curve_.at(value).colour;
        if (scene_.shaded())
          colour = phong_.shade(
              colour,
              trilinear(cell_normals(gradients_, crossing.cell), ray.at(s) - glm::dvec3(crossing.corner)),
              ray.to_viewer);
        return Rgba(colour, 1.0);
      }
    }
    return Rgba(0.0);
  }

  /// Returns where the depth is, if it is wanted and here.
  std::optional<double> integrate_crossing(const LatticeRay& ray, const Crossing& crossing,
                                           Piece& seen) const {
    const auto values = cell_values(scene_, curve_, crossing.shown);
    if (!values || !curve_.visible(values->low, values->high)) return std::nullopt;
    Corners<glm::dvec3> normals{};
    if (scene_.needs_gradients()) normals = cell_normals(gradients_, crossing.cell);

    const auto place = [&](double s) { return ray.at(s) - glm::dvec3(crossing.corner); };
    const auto value_at = [&](double s) { return values->at(place(s)); };
    const auto medium_at = [&](double s) {
      const auto sample = curve_.at(value_at(s));
      Medium medium{extinction(sample.opacity), tints_.on(sample.colour, ray.at(s))};
      if (!scene_.needs_gradients() || !(sample.opacity > 0)) return medium;
      const glm::dvec3 normal = trilinear(normals, place(s));
      medium.extinction = gradients_.left_at_edge(medium.extinction, normal);
      if (scene_.shaded()) medium.colour = phong_.shade(medium.colour, normal, ray.to_viewer);
      return medium;
    };
    const auto cuts = smooth_pieces(crossing, place, value_at, normals, ray.to_viewer);
    for (std::size_t i = 0; i + 1 < cuts.size() && seen.transmittance >= 0.1 * tolerance_; ++i) {
      const double a = cuts[i], b = cuts[i + 1];
      if (!(a < b)) continue;
      const double share = tolerance_ * (b - a) / (ray.leave - ray.enter);
      const auto up_to = [&](double s) {
        return behind(seen, integrate(medium_at, a, s, share / seen.transmittance));
      };
      const Piece next = up_to(b);
      if (const double left = 1 - shown_.depth.value_or(0.5); shown_.values && next.transmittance <= left) {
        double front = a, back = b;
        for (double s = 0.5 * (a + b); front < s && s < back; s = 0.5 * (front + back))
          (up_to(s).transmittance <= left ? back : front) = s;
        return back;
      }
      seen = next;
    }
    return std::nullopt;
  }

  /// Ends of a crossing's smooth pieces: inside each, the value crosses no knot, and light and viewer stay on
  /// one side of the surface.
  template <class Place, class ValueAt>
  std::vector<double> smooth_pieces(const Crossing& crossing, const Place& place, const ValueAt& value_at,
                                    const Corners<glm::dvec3>& normals, const glm::dvec3& to_viewer) const {
    std::vector<double> cuts =
        cuts_at_knots(cubic_along(crossing.enter, crossing.leave, value_at), curve_.knots());
    if (scene_.shaded()) {
      for (const glm::dvec3& direction : {phong_.to_light(), to_viewer}) {
        const auto facing = [&](double s) { return glm::dot(trilinear(normals, place(s)), direction); };
        const auto more = cuts_at_knots(cubic_along(crossing.enter, crossing.leave, facing), {0.0});
        cuts.insert(cuts.end(), more.begin(), more.end());
      }
      std::sort(cuts.begin(), cuts.end());
    }
    for (double& cut : cuts) cut = std::lerp(crossing.enter, crossing.leave, cut);
    return cuts;
  }

  double tolerance_;
  Gradients gradients_;
};

}  // namespace

std::vector<Rgba> field_truth(const Scene& scene, std::span<const Pixel> pixels, double tolerance) {
  if (scene.frame.shown.clip) return field_truth(cropped(scene), pixels, tolerance);
  return along_rays(scene, pixels, FieldIntegrator(scene, tolerance));
}

ScreenBounds field_bounds(const Scene& scene) { return Rays(scene).bounds(); }

std::vector<Rgba> analytic_truth(const Scene& scene, Field field, double scale, std::span<const Pixel> pixels,
                                 double tolerance) {
  const Shown& shown = scene.frame.shown;
  if (shown.edges || !shown.tints.empty() || shown.values)
    throw InputError("a formula's truth knows neither --tf2d nor --mask-as nor --depth", "leave it out");
  if (shown.clip) check(*shown.clip, scene.grid);
  const Tracer tracer(scene);
  const glm::dvec3 dims(scene.grid.dims);
  const glm::dmat3 to_world = against_gradient(scene.grid.direction, scene.grid.spacing * dims);
  const auto normal = [&](const glm::dvec3& p) {
    constexpr double h = 1e-5;
    return to_world * glm::dvec3(field(p.x + h, p.y, p.z) - field(p.x - h, p.y, p.z),
                                 field(p.x, p.y + h, p.z) - field(p.x, p.y - h, p.z),
                                 field(p.x, p.y, p.z + h) - field(p.x, p.y, p.z - h));
  };
  return along_rays(scene, pixels, [&](Pixel pixel) {
    const LatticeRay ray = tracer.rays_.through(pixel);
    if (!(ray.enter < ray.leave)) return Rgba(0.0);
    const glm::dvec3 origin = (ray.origin + 0.5) / dims, step = ray.step / dims;
    const auto medium_at = [&](double s) {
      const glm::dvec3 p = origin + s * step;
      const auto sample = tracer.curve_.at(scale * field(p.x, p.y, p.z));
      Medium medium{extinction(sample.opacity), sample.colour};
      if (scene.shaded() && sample.opacity > 0)
        medium.colour = tracer.phong_.shade(medium.colour, normal(p), ray.to_viewer);
      return medium;
    };
    constexpr int pieces = 512;
    Piece seen;
    const double length = (ray.leave - ray.enter) / pieces;
    for (int i = 0; i < pieces && seen.transmittance >= 0.1 * tolerance; ++i) {
      const double a = ray.enter + i * length;
      seen = behind(seen, integrate(medium_at, a, a + length, tolerance / pieces / seen.transmittance));
    }
    return Rgba(seen.colour, 1 - seen.transmittance);
  });
}

double synth_scale(ScalarType type) {
  return visit_type(type, [](auto zero) {
    using T = decltype(zero);
    return std::is_integral_v<T> ? static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
  });
}

}  // namespace ringsplat::truth
