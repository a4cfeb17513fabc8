#include "ringsplat/node/frame_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

using nlohmann::json;

json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 vec_from(const json& j) {
  return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()};
}

json to_json(const Camera& c) {
  json j{{"azimuth", c.azimuth}, {"elevation", c.elevation}, {"roll", c.roll}, {"zoom", c.zoom}};
  if (c.matrix) j["matrix"] = *c.matrix;
  return j;
}

Camera camera_from(const json& j) {
  Camera c{j.at("azimuth"), j.at("elevation"), j.at("roll"), j.at("zoom"), {}};
  if (j.contains("matrix")) c.matrix = j.at("matrix").get<std::array<double, 12>>();
  return c;
}

json to_json(const TransferFunction& tf) {
  json colours = json::array(), opacities = json::array();
  for (const auto& p : tf.colours) colours.push_back({p.value, p.srgb.x, p.srgb.y, p.srgb.z});
  for (const auto& p : tf.opacities) opacities.push_back({p.value, p.opacity});
  return {{"name", tf.name}, {"colours", colours}, {"opacities", opacities}, {"nan", to_json(tf.nan_srgb)}};
}

TransferFunction transfer_function_from(const json& j) {
  TransferFunction tf;
  tf.name = j.at("name");
  for (const auto& p : j.at("colours")) tf.colours.push_back({p.at(0), {p.at(1), p.at(2), p.at(3)}});
  for (const auto& p : j.at("opacities")) tf.opacities.push_back({p.at(0), p.at(1)});
  tf.nan_srgb = vec_from(j.at("nan"));
  return tf;
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

/// The value of that name; throws when there is none.
template <class T>
T named(const std::string& word, std::initializer_list<T> values) {
  for (const T value : values)
    if (name(value) == word) return value;
  throw RunError(fmt::format("a frame announcement says '{}', which this build does not know", word),
                 "all ranks must run the same build");
}

KernelOptions kernel_from(const json& j) {
  return {named(j.at("method"), {KernelMethod::qee, KernelMethod::texture}), j.at("phases"), j.at("qee_bits"),
          named(j.at("normalisation"), {Normalisation::none, Normalisation::constant, Normalisation::exact})};
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

FrameSpec frame_spec_from(const json& j) {
  FrameSpec s;
  s.frame = j.at("frame");
  s.camera = camera_from(j.at("camera"));
  s.width = j.at("size").at(0);
  s.height = j.at("size").at(1);
  s.image_plane = named(j.at("image_plane"), {ImagePlane::screen, ImagePlane::slices});
  s.plane_samples = j.at("plane_samples");
  s.region_size = j.at("region");
  s.dealt_to = j.at("dealt_to");
  s.transfer_function = transfer_function_from(j.at("transfer_function"));
  s.shading = j.at("shading") == "phong" ? Shading::phong : Shading::none;
  const auto& m = j.at("material");
  s.material = {m.at("ambient"), m.at("diffuse"), m.at("specular"), m.at("exponent")};
  s.light = vec_from(j.at("light"));
  s.kernel_radius = j.at("radius");
  s.kernel = kernel_from(j.at("kernel"));
  s.opacity_correction = j.at("opacity_correction");
  s.opaque_threshold = j.at("opaque_threshold");
  s.reduction = {j.at("undersample"), j.at("prefilter")};
  s.payload = named(j.at("payload"), {PayloadForm::words, PayloadForm::runs});
  s.precision = named(j.at("precision"), {Precision::float32, Precision::half, Precision::u8});
  return s;
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

Bytes encode(const FrameSpec& spec) {
  json announced = to_json(spec);
  // No setting: pictures, which hold those, are the same files for any number of Renderers.
  announced["dealt_to"] = spec.dealt_to;
  std::vector<std::uint8_t> cbor;
  json::to_cbor(announced, cbor);
  Bytes wire(cbor.size());
  std::memcpy(wire.data(), cbor.data(), cbor.size());
  return wire;
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  try {
    const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
    return frame_spec_from(json::from_cbor(first, first + bytes.size()));
  } catch (const json::exception& e) {
    throw RunError(fmt::format("a frame announcement cannot be read: {}", e.what()),
                   "all ranks must run the same build");
  }
}

std::string to_json_text(const FrameSpec& spec) { return to_json(spec).dump(); }

LatticeFrame lattice_frame(const Grid& grid) {
  return {grid.dims, grid.spacing, grid.origin, grid.direction};
}

namespace {

/// The view of a reduced volume's lattice that shows it where the volume is.
ViewTransform reduced_view(ViewTransform view, const Reduction& reduction) {
  const double middle = reduction.prefilter ? 0.5 * (reduction.factor - 1) : 0.0;
  view.offset = view.project(glm::dvec3(middle));
  view.linear *= double(reduction.factor);
  return view;
}

int round_up(int value, int step) { return (value + step - 1) / step * step; }

/// The picture's bits do not depend on it. In the slices' plane a row of voxels is a row of pixels, so
/// regions are as wide as the image: a row goes to one of them and is not cut, unless Renderers are more than
/// strips. An image there is small; it should still give every Renderer strips from several of its parts.
Regions make_regions(const FrameSpec& spec, int width, int height) {
  if (spec.region_size > 0) return {width, height, spec.region_size};
  if (spec.image_plane == ImagePlane::screen) return {width, height, 128};
  constexpr int each = 3, least_rows = 16, most_rows = 64, least_columns = 64;
  const int renderers = std::clamp(spec.dealt_to, 1, 1 << 16);
  const int region_height =
      std::clamp(round_up(height / (each * renderers), least_rows), least_rows, most_rows);
  const int strips = Regions(width, height, width, region_height).rows(),
            columns = std::max(renderers / strips, 1);
  const int region_width =
      columns == 1 ? width : std::max(round_up(width / columns, least_columns), least_columns);
  return {width, height, region_width, region_height};
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
  for (int region = 0; region < regions.count(); ++region) has_region[std::size_t(all.of(region))] = true;
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
  g.regions = make_regions(spec, g.width, g.height);
  g.dealt_to = spec.dealt_to;
  g.slices = g.grid.slices(g.traversal.axis);
  return g;
}

}  // namespace ringsplat
