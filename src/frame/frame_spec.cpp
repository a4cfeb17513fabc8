#include "ringsplat/frame/frame_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "frame/region_choice.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

using nlohmann::json;

json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json to_json(const Camera& c) {
  json j{{"azimuth", c.azimuth}, {"elevation", c.elevation}, {"roll", c.roll}, {"zoom", c.zoom}};
  if (c.matrix) j["matrix"] = *c.matrix;
  return j;
}

json to_json(const TransferFunction& tf) {
  json colours = json::array(), opacities = json::array();
  for (const auto& p : tf.colours) colours.push_back({p.value, p.srgb.x, p.srgb.y, p.srgb.z});
  for (const auto& p : tf.opacities) opacities.push_back({p.value, p.opacity});
  return {{"name", tf.name}, {"colours", colours}, {"opacities", opacities}, {"nan", to_json(tf.nan_srgb)}};
}

json to_json(const PhongMaterial& m) {
  return {{"ambient", m.ambient}, {"diffuse", m.diffuse}, {"specular", m.specular}, {"exponent", m.exponent}};
}

const char* name(PayloadForm form) { return form == PayloadForm::words ? "words" : "runs"; }

const char* name(Precision precision) {
  return precision == Precision::float32 ? "float" : precision == Precision::half ? "half" : "u8";
}

json to_json(const KernelOptions& k) {
  return {{"method", name(k.method)},
          {"phases", k.phases},
          {"qee_bits", k.qee_bits},
          {"normalisation", name(k.normalisation)}};
}

json to_json(const FrameSpec& s) {
  return {{"frame", s.frame},
          {"camera", to_json(s.camera)},
          {"size", {s.width, s.height}},
          {"image_plane", name(s.image_plane)},
          {"plane_samples", s.plane_samples},
          {"region", s.region_size},
          {"transfer_function", to_json(s.transfer_function)},
          {"shading", s.shading == Shading::phong ? "phong" : "none"},
          {"material", to_json(s.material)},
          {"light", to_json(s.light)},
          {"radius", s.kernel_radius},
          {"kernel", to_json(s.kernel)},
          {"opacity_correction", s.opacity_correction},
          {"opaque_threshold", s.opaque_threshold},
          {"undersample", s.reduction.factor},
          {"prefilter", s.reduction.prefilter},
          {"payload", name(s.payload)},
          {"precision", name(s.precision)}};
}

}  // namespace

std::string name(ImagePlane plane) { return plane == ImagePlane::screen ? "screen" : "slices"; }

void check(const FrameSpec& spec) {
  static_cast<void>(Regions(spec.width, spec.height, spec.region_size == 0 ? 128 : spec.region_size));
  check(spec.transfer_function, "the transfer function");
  check(spec.kernel, spec.kernel_radius);
  const double light = glm::length(spec.light);
  if (!(std::isfinite(light) && light > 0))
    throw InputError("--light needs a direction of finite length above zero",
                     "for instance --light -0.4 0.6 0.7");
  if (!(spec.opaque_threshold >= 0 && spec.opaque_threshold < 1))
    throw InputError(
        fmt::format("--opaque-threshold {} is not a transmittance below 1", spec.opaque_threshold),
        "give 0 to composite every slice, or a small number such as 0.002");
  if (spec.plane_samples != 1 && spec.plane_samples != 2 && spec.plane_samples != 4)
    throw InputError(fmt::format("--samples cannot be {}", spec.plane_samples),
                     "use 1, 2 or 4 pixels a voxel");
  if (spec.reduction.factor != 1 && spec.reduction.factor != 2 && spec.reduction.factor != 4)
    throw InputError(fmt::format("--undersample cannot be {}", spec.reduction.factor), "use 1, 2 or 4");
  if (spec.payload == PayloadForm::words && spec.precision != Precision::float32)
    throw InputError("--payload words always carries float precision",
                     "use --payload runs with --precision half or u8");
  const auto& m = spec.material;
  for (const double v : {m.ambient, m.diffuse, m.specular, m.exponent})
    if (!(std::isfinite(v) && v >= 0))
      throw InputError("a Phong coefficient is negative or not a number",
                       "ambient, diffuse, specular and exponent are at least 0");
}

std::string to_json_text(const FrameSpec& spec) {
  return to_json(spec).dump(-1, ' ', false, json::error_handler_t::replace);
}

LatticeFrame lattice_frame(const Grid& grid) {
  return {grid.dims, grid.spacing, grid.origin, grid.direction};
}

Axis traversed_axis(const Camera& camera, const Grid& grid, int width, int height) {
  const LatticeFrame lattice = lattice_frame(grid);
  return choose_traversal(make_view(camera, lattice, width, height), lattice).axis;
}

namespace {

/// The view of a reduced volume's lattice that shows it where the volume is.
ViewTransform reduced_view(ViewTransform view, const Reduction& reduction) {
  const double middle = reduction.prefilter ? 0.5 * (reduction.factor - 1) : 0.0;
  view.offset = view.project(glm::dvec3(middle));
  view.linear *= double(reduction.factor);
  return view;
}

void lay_into_slices(FrameGeometry& g, const FrameSpec& spec) {
  const SlicePlane plane = make_slice_plane(g.view, g.traversal.axis, g.grid.dims, spec.plane_samples,
                                            spec.kernel_radius, spec.width, spec.height);
  g.view = plane.view;
  g.warp = plane.warp;
  g.width = plane.width;
  g.height = plane.height;
}

}  // namespace

std::vector<bool> FrameGeometry::drawing(int renderers) const {
  const RegionOwners all = owners(renderers);
  std::vector<bool> has_region(std::size_t(renderers), false);
  for (int y = reached.y0; y < reached.y1; ++y)
    for (int x = reached.x0; x < reached.x1; ++x)
      has_region[std::size_t(all.of(y * regions.columns() + x))] = true;
  return has_region;
}

FrameGeometry make_geometry(const FrameSpec& spec, const Grid& grid) {
  const LatticeFrame lattice = lattice_frame(grid);
  FrameGeometry g;
  g.view = make_view(spec.camera, lattice, spec.width, spec.height);
  g.traversal = choose_traversal(g.view, lattice);
  g.grid = grid;
  if (spec.reduction.factor > 1) {
    g.grid = reduced_grid(grid, spec.reduction);
    g.view = reduced_view(g.view, spec.reduction);
    g.traversal.slice_distance *= spec.reduction.factor;
  }
  g.width = spec.width;
  g.height = spec.height;
  if (spec.image_plane == ImagePlane::slices) lay_into_slices(g, spec);
  g.footprint = make_footprint(g.view, g.traversal.axis, spec.kernel_radius);
  if (spec.kernel.normalisation == Normalisation::none) g.footprint.weight = 1;
  constexpr double widest = 1 << 20;
  if (!(std::max(g.footprint.half.x, g.footprint.half.y) < widest))
    throw InputError(fmt::format("a voxel's kernel would be {:.3g} pixels wide",
                                 2 * std::max(g.footprint.half.x, g.footprint.half.y)),
                     "use a smaller --zoom or --size");
  check(spec.kernel, g.footprint);
  lay_regions(g, spec);
  g.slices = g.grid.slices(g.traversal.axis);
  return g;
}

}  // namespace ringsplat
