#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <numbers>

#include "ringsplat/base/error.hpp"
#include "truth/method.hpp"
#include "truth/parallel.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

/// Lattice steps by which a kernel's reach is widened, so that no voxel is missed. Q decides which count.
constexpr double slack = 1e-3;

/// The kernel on the screen: Q = 1 − |root · offset|².
struct Kernel {
  glm::dmat2 root{1.0};
  double weight = 1;
  glm::dmat2 to_lattice{1.0};     ///< pixels to steps along (u, v)
  glm::dvec2 lattice_reach{1.0};  ///< steps along u and v within which Q may be above zero
};

Kernel make_kernel(const glm::dvec2& step_u, const glm::dvec2& step_v, double radius) {
  const glm::dmat2 block(step_u, step_v);
  const double cell = std::abs(glm::determinant(block));
  Kernel kernel;
  kernel.to_lattice = glm::inverse(block);
  kernel.root = kernel.to_lattice / radius;
  // The ellipse's half axes: the roots of radius² (u uᵀ + v vᵀ), made diagonal by one Jacobi rotation.
  const double xx = radius * radius * (step_u.x * step_u.x + step_v.x * step_v.x);
  const double xy = radius * radius * (step_u.x * step_u.y + step_v.x * step_v.y);
  const double yy = radius * radius * (step_u.y * step_u.y + step_v.y * step_v.y);
  const double turn = 0.5 * std::atan2(2 * xy, xx - yy), c = std::cos(turn), s = std::sin(turn);
  const double along = c * c * xx + 2 * s * c * xy + s * s * yy,
               across = s * s * xx - 2 * s * c * xy + c * c * yy;
  constexpr double narrowest = 1;  // pixels from centre to edge
  double area = std::numbers::pi * radius * radius * cell;
  if (std::min(along, across) < narrowest * narrowest) {
    const double a = std::max(std::sqrt(std::max(along, 0.0)), narrowest),
                 b = std::max(std::sqrt(std::max(across, 0.0)), narrowest);
    kernel.root = {{c / a, -s / b}, {s / a, c / b}};
    area = std::numbers::pi * a * b;
  }
  // Q² integrates to a third of the ellipse's area, and each cell has one kernel.
  kernel.weight = 3 * cell / area;
  const glm::dmat2 reach = glm::inverse(kernel.root * block);
  kernel.lattice_reach = {std::hypot(reach[0][0], reach[1][0]), std::hypot(reach[0][1], reach[1][1])};
  return kernel;
}

/// The truth's data that are the same for every pixel.
class Method : Tracer {
 public:
  explicit Method(const Scene& scene)
      : Tracer(scene),
        view_(rays_.view()),
        traversal_(choose_traversal(view_, lattice_of(scene.grid))),
        axis_(int(traversal_.axis)),
        u_(in_plane(traversal_.axis).u),
        v_(in_plane(traversal_.axis).v),
        kernel_(make_kernel(glm::dvec2(view_.linear[u_]), glm::dvec2(view_.linear[v_]),
                            scene.frame.as<Splats>().kernel_radius)),
        distance_(slice_length(rays_.through({0, 0}), axis_)),
        gradients_(scene) {
    slice_.resize(std::size_t(scene.grid.dims[u_]) * std::size_t(scene.grid.dims[v_]));
  }

  std::vector<Rgba> evaluate(std::span<const Pixel> pixels) {
    std::vector<Rgba> behind(pixels.size(), Rgba(0, 0, 0, 1));  // colour and transmittance so far
    const int slices = scene_.grid.dims[axis_];
    for (int step = 0; step < slices; ++step) {
      const int slice = traversal_.ascending ? step : slices - 1 - step;
      if (!classify(slice)) continue;
      parallel_for(
          pixels.size(), 256,
          [&](std::size_t first, std::size_t end) {
            for (std::size_t p = first; p < end; ++p) composite(behind[p], sum_at(pixels[p], slice));
          },
          scene_.poll ? Poll([&](double done) { scene_.poll((step + done) / slices); }) : Poll());
    }
    for (auto& p : behind) p.w = 1 - p.w;
    return behind;
  }

 private:
  glm::dvec3 lattice_point(double u, double v, int slice) const {
    glm::dvec3 p{0.0};
    p[u_] = u;
    p[v_] = v;
    p[axis_] = slice;
    return p;
  }

  Rgba classify_voxel(const glm::ivec3& p) const {
    const auto sample = curve_.at(scene_.values[scene_.index(p)]);
    if (!(sample.opacity > 0)) return Rgba(0.0);
    glm::dvec3 colour = sample.colour;
    if (scene_.shaded())
      colour = phong_.shade(colour, scene_.normal ? scene_.normal(p) : gradients_.at(p), view_.to_viewer);
    const double opacity = sample.opacity >= 1 ? 1 : -std::expm1(distance_ * std::log1p(-sample.opacity));
    return Rgba(colour * opacity, opacity);
  }

  /// Fills slice_ with premultiplied colours; false when nothing is visible.
  bool classify(int slice) {
    const int width = scene_.grid.dims[u_], height = scene_.grid.dims[v_];
    std::atomic<bool> visible{false};
    parallel_for(std::size_t(height), 8, [&](std::size_t first, std::size_t end) {
      for (std::size_t v = first; v < end; ++v)
        for (int u = 0; u < width; ++u) {
          const Rgba colour = classify_voxel(glm::ivec3(lattice_point(u, int(v), slice)));
          slice_[v * std::size_t(width) + std::size_t(u)] = colour;
          if (colour.w > 0) visible = true;
        }
    });
    return visible;
  }

  Rgba sum_at(Pixel pixel, int slice) const {
    const glm::dvec2 centre{pixel.x + 0.5, pixel.y + 0.5};
    const glm::dvec2 middle =
        kernel_.to_lattice * (centre - glm::dvec2(view_.project(lattice_point(0, 0, slice))));
    const glm::dvec2 low = glm::ceil(middle - kernel_.lattice_reach - slack),
                     high = glm::floor(middle + kernel_.lattice_reach + slack);
    const auto weight_of = [&](double u, double v) {
      const glm::dvec2 r = kernel_.root * (centre - glm::dvec2(view_.project(lattice_point(u, v, slice))));
      const double q = 1 - glm::dot(r, r);
      return q > 0 ? q * q : 0;
    };
    const int width = scene_.grid.dims[u_];
    const double last_u = std::min(high.x, width - 1.0),
                 last_v = std::min(high.y, scene_.grid.dims[v_] - 1.0);
    Rgba sum(0.0);
    for (double v = std::max(low.y, 0.0); v <= last_v; ++v)
      for (double u = std::max(low.x, 0.0); u <= last_u; ++u) {
        const Rgba& colour = slice_[std::size_t(v) * std::size_t(width) + std::size_t(u)];
        if (colour.w > 0) sum += kernel_.weight * weight_of(u, v) * colour;
      }
    return sum;
  }

  static void composite(Rgba& behind, const Rgba& slice) {
    const double opacity = std::clamp(slice.w, 0.0, 1.0);
    for (int c = 0; c < 3; ++c) behind[c] += behind.w * std::clamp(slice[c], 0.0, opacity);
    behind.w *= 1 - opacity;
  }

  const ViewTransform& view_;
  Traversal traversal_;
  int axis_, u_, v_;
  Kernel kernel_;
  double distance_;  ///< unit lengths from slice to slice
  Gradients gradients_;
  std::vector<Rgba> slice_;
};

}  // namespace

std::vector<Rgba> splat_method_truth(const Scene& scene, std::span<const Pixel> pixels) {
  if (scene.frame.shown.camera.fov != 0)
    throw InputError("there is no truth of splats in perspective", "use an orthographic camera");
  if (scene.frame.shown.clip) return splat_method_truth(cropped(scene), pixels);
  return Method(scene).evaluate(pixels);
}

ScreenBounds splat_method_bounds(const Scene& scene) {
  const ViewTransform view = view_of(scene);
  const Axis axis = choose_traversal(view, lattice_of(scene.grid)).axis;
  const auto [u, v] = in_plane(axis);
  const Kernel kernel = make_kernel(glm::dvec2(view.linear[u]), glm::dvec2(view.linear[v]),
                                    scene.frame.as<Splats>().kernel_radius);
  glm::dvec3 reach(slack);
  reach[u] += kernel.lattice_reach.x;
  reach[v] += kernel.lattice_reach.y;
  const LatticeBox faces = voxel_faces(scene);
  return Rays(scene, {faces.low + 0.5 - reach, faces.high - 0.5 + reach}).bounds();
}

}  // namespace ringsplat::truth
