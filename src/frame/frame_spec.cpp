#include "ringsplat/frame/frame_spec.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "base/archive.hpp"
#include "frame/frame_fields.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "frame/slices.hpp"
#include "ringsplat/base/error.hpp"
#include "screen/regions.hpp"

namespace ringsplat {
namespace {

using nlohmann::json;

json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json to_json(const Camera& c) {
  json j{{"azimuth", c.azimuth}, {"elevation", c.elevation}, {"roll", c.roll}, {"zoom", c.zoom}};
  if (c.matrix) j["matrix"] = *c.matrix;
  if (c.fov != 0) j["fov"] = c.fov;
  if (c.distance != 0) j["distance"] = c.distance;
  if (c.pan != std::array<double, 2>{}) j["pan"] = c.pan;
  if (c.eye) j.update({{"eye", to_json(*c.eye)}, {"up", to_json(c.up)}});
  if (c.target) j["target"] = to_json(*c.target);
  if (c.fit == Fit::box) j["fit"] = "box";
  return j;
}

/// An object of all fields.
struct ToJson {
  json& object;
  template <class T>
  void operator()(const char* key, const T& value) const {
    if constexpr (HasFields<const T>)
      fields(value, ToJson{object[key]});
    else if constexpr (std::is_enum_v<T>)
      object[key] = name(value);
    else
      object[key] = value;
  }
};

/// One flat object: readers of images and statistics rely on it.
json to_json(const Shown& s) {
  const auto& [ambient, diffuse, specular, exponent] = s.material;
  json j{{"camera", to_json(s.camera)},
         {"size", {s.width, s.height}},
         {"transfer_function", to_json(s.transfer_function)},
         {"shading", s.shading == Shading::phong ? "phong" : "none"},
         {"material",
          {{"ambient", ambient}, {"diffuse", diffuse}, {"specular", specular}, {"exponent", exponent}}},
         {"light", to_json(s.light)},
         {"opacity_correction", s.opacity_correction},
         {"opaque_threshold", s.opaque_threshold},
         {"undersample", s.reduction.factor},
         {"prefilter", s.reduction.prefilter}};
  if (s.interpolation != Interpolation::linear) j["interpolation"] = name(s.interpolation);
  if (s.mode != Mode::composite) j["mode"] = name(s.mode);
  if (s.mode == Mode::surface) j["isovalue"] = s.isovalue;
  if (s.mixed) j["mixed"] = true;
  if (s.values) j["values"] = true;
  if (s.depth) j["depth"] = *s.depth;
  for (int k = 0; k < 3 && s.clip; ++k) j["clip"].push_back({s.clip->first[k], s.clip->end[k]});
  for (const ClipPlane& plane : s.clip_planes)
    j["clip_planes"].push_back({plane.normal.x, plane.normal.y, plane.normal.z, plane.distance});
  if (s.edges) j["edges"] = {s.edges->from, s.edges->to};
  for (const auto& [label, colour, share] : s.tints)
    j["tints"].push_back({label, colour.r, colour.g, colour.b, share});
  return j;
}

void check(const Shown& shown) {
  check(shown.transfer_function, "the transfer function");
  const double light = glm::length(shown.light);
  if (!(std::isfinite(light) && light > 0))
    throw InputError("--light needs a direction of finite length above zero",
                     "for instance --light -0.4 0.6 0.7");
  if (!(shown.opaque_threshold >= 0 && shown.opaque_threshold < 1))
    throw InputError(
        fmt::format("--opaque-threshold {} is not a transmittance below 1", shown.opaque_threshold),
        "give 0 to composite every slice, or a small number such as 0.002");
  if (shown.reduction.factor != 1 && shown.reduction.factor != 2 && shown.reduction.factor != 4)
    throw InputError(fmt::format("--undersample cannot be {}", shown.reduction.factor), "use 1, 2 or 4");
  const auto& m = shown.material;
  for (const double v : {m.ambient, m.diffuse, m.specular, m.exponent})
    if (!(std::isfinite(v) && v >= 0))
      throw InputError("a Phong coefficient is negative or not a number",
                       "ambient, diffuse, specular and exponent are at least 0");
}

void check(const Splats& splats) {
  if (splats.plane_samples != 1 && splats.plane_samples != 2 && splats.plane_samples != 4)
    throw InputError(fmt::format("--samples cannot be {}", splats.plane_samples),
                     "use 1, 2 or 4 pixels a voxel");
}

void check(const Sheets& sheets) {
  const double samples = sheets.plane_samples;
  if (samples != 1 && samples != 1.5 && samples != 2 && samples != 4)
    throw InputError(fmt::format("--samples cannot be {}", samples), "use 1, 1.5, 2 or 4 pixels a voxel");
  if (sheets.slabs < 1 || sheets.slabs > Sheets::most_slabs)
    throw InputError(fmt::format("--slabs cannot be {}", sheets.slabs),
                     fmt::format("use 1 to {} slabs a slice", Sheets::most_slabs));
  if (sheets.light_points != 1 && sheets.light_points != 2)
    throw InputError(fmt::format("--light-points cannot be {}", sheets.light_points), "use 1 or 2");
  if (sheets.layers != 0 && sheets.layers < Sheets::least_layer)
    throw InputError(fmt::format("--layers cannot be {}", sheets.layers),
                     fmt::format("a layer has {} slices or more, 16 do well", Sheets::least_layer));
}

void check_mode(const Shown& shown, const Method& method) {
  const bool composites = shown.mode == Mode::composite, numbers = shown.values || shown.depth;
  if (shown.depth && !(*shown.depth > 0 && *shown.depth < 1))
    throw InputError(fmt::format("--depth {} is no opacity that every ray could reach", *shown.depth),
                     "give a number between 0 and 1, such as 0.5");
  if (shown.depth && !composites && shown.mode != Mode::surface)
    throw InputError(fmt::format("--mode {} shows nothing that lies at one depth", name(shown.mode)),
                     "leave out --depth, or use --mode composite or surface");
  if (composites && numbers && std::holds_alternative<Splats>(method))
    throw InputError("splats have no depth", "use --engine sheets, or leave --depth out");
  if (composites && !shown.values) return;
  if (std::holds_alternative<Splats>(method))
    throw InputError(fmt::format("splats cannot be drawn by --mode {}", name(shown.mode)),
                     "use --engine sheets, or leave --mode out");
  if (!composites && shown.interpolation == Interpolation::nearest)
    throw InputError(fmt::format("--mode {} needs values between voxels", name(shown.mode)),
                     "leave out --interpolation nearest");
  if (!std::isfinite(shown.isovalue))
    throw InputError("--isovalue is not a finite number", "give a value of the volume");
  if (const auto* const sheets = std::get_if<Sheets>(&method); sheets != nullptr && sheets->layers > 0)
    throw InputError(fmt::format("numbers, and --mode {}, have no layers to composite", name(shown.mode)),
                     "leave out --layers");
}

void check_mixed(const Shown& shown, const Method& method) {
  if (!shown.mixed || shown.mode != Mode::composite) return;
  const auto* const sheets = std::get_if<Sheets>(&method);
  if (sheets == nullptr || sheets->layers > 0)
    throw InputError("only sheets without layers draw channels as materials",
                     "use --engine sheets without --layers, or leave out --materials");
  if (shown.values || shown.depth || !shown.tints.empty())
    throw InputError("materials have neither depths nor a segmentation's colours", "leave out --materials");
}

void check_clip_planes(const Shown& shown, const Method& method) {
  const std::size_t most = shown.cut ? most_clip_planes_of_cut : Shown::most_clip_planes;
  if (shown.clip_planes.size() > most)
    throw InputError(fmt::format("{} clip planes are too many", shown.clip_planes.size()),
                     fmt::format("give {} at most{}", most, shown.cut ? " with --cut" : ""));
  std::vector<ClipPlane> planes = shown.clip_planes;
  if (shown.cut) planes.push_back(*shown.cut);
  for (const ClipPlane& plane : planes) {
    const double length = glm::length(plane.normal);
    if (!(std::isfinite(length) && length > 0 && std::isfinite(plane.distance)))
      throw InputError("a plane needs a direction of finite length above zero and a finite distance",
                       "for instance 0,1,0,0");
  }
  if (!planes.empty() && std::holds_alternative<Splats>(method))
    throw InputError("splats cannot be cut by a plane", "use --engine sheets, or leave the plane out");
  if (shown.cut && (shown.values || shown.depth || shown.mode == Mode::sum))
    throw InputError("a cut shows values in colours, no depths or sums", "leave out --cut");
}

void check_edges(const Shown& shown, const Method& method) {
  if (!shown.edges) return;
  const auto [from, to] = *shown.edges;
  if (!(from >= 0 && from < to && std::isfinite(to)))
    throw InputError(fmt::format("--tf2d {}:{} is no window of magnitudes", from, to),
                     "give two ascending numbers of at least 0");
  if (std::holds_alternative<Splats>(method))
    throw InputError("splats' opacities do not go by gradients", "use --engine sheets, or leave --tf2d out");
}

void check_tints(const Shown& shown, const Method& method) {
  if (!shown.tints.empty() && std::holds_alternative<Splats>(method))
    throw InputError("splats cannot be tinted by a segmentation", "use --engine sheets, or --mask-as hide");
  const auto is_share = [](float part) { return part >= 0 && part <= 1; };
  for (const auto& [label, colour, share] : shown.tints)
    if (label < 1 || label > most_tints || !is_share(colour.r) || !is_share(colour.g) ||
        !is_share(colour.b) || !is_share(share))
      throw InputError(
          fmt::format("label {} cannot have that colour", label),
          fmt::format("labels lie between 1 and {}, colours and shares of them between 0 and 1", most_tints));
}

/// The first byte has the method's index among Method's alternatives, and above it the volume's number.
/// One of the frames that an announcement has.
struct AnnouncedFrame {
  std::uint64_t volume = 0;
  Bytes spec;
};
void fields(AnnouncedFrame& frame, auto& archive) { archive(frame.volume, frame.spec); }

[[noreturn]] void refuse_bytes() { throw OtherBuild("a frame announcement cannot be read"); }

}  // namespace

const char* name(Interpolation interpolation) {
  return interpolation == Interpolation::linear ? "linear" : "nearest";
}

std::string name(ImagePlane plane) { return plane == ImagePlane::screen ? "screen" : "slices"; }

const char* name(const Method& method) {
  return std::visit([](const auto& how) { return how.name; }, method);
}

void check_projection(const Camera& camera, const Method& method) {
  if (camera.fov != 0 && std::holds_alternative<Splats>(method))
    throw InputError(
        "splats cannot be drawn in perspective, where each voxel has another footprint: one serves all of an "
        "orthographic view",
        "use --engine sheets, or leave --fov out");
}

void check(const FrameSpec& spec) {
  const int region_size = spec.division.region_size;
  static_cast<void>(Regions(spec.shown.width, spec.shown.height, region_size == 0 ? 128 : region_size));
  check(spec.shown);
  std::visit([](const auto& how) { check(how); }, spec.how);
  check_projection(spec.shown.camera, spec.how);
  check_mode(spec.shown, spec.how);
  check_mixed(spec.shown, spec.how);
  check_clip_planes(spec.shown, spec.how);
  check_edges(spec.shown, spec.how);
  check_tints(spec.shown, spec.how);
}

Bytes encode(const FrameSpec& spec) { return to_bytes(std::uint8_t(spec.how.index()), spec); }

Bytes encode(const std::vector<FrameOfVolume>& frames) {
  std::vector<AnnouncedFrame> all;
  for (const auto& [volume, spec] : frames) all.push_back({volume, encode(spec)});
  return to_bytes(std::uint8_t(frames.front().spec.how.index()), all);
}

std::vector<FrameOfVolume> decode_frames(std::span<const std::byte> bytes) {
  if (bytes.empty()) refuse_bytes();
  const auto all = from_bytes<std::vector<AnnouncedFrame>>(bytes.subspan(1));
  if (!all || all->empty()) refuse_bytes();
  std::vector<FrameOfVolume> frames;
  for (const auto& [volume, spec] : *all) frames.push_back({std::size_t(volume), decode_frame_spec(spec)});
  return frames;
}

Method method_of(std::span<const std::byte> bytes) {
  static const Method methods[] = {Splats(), Sheets()};
  static_assert(std::size(methods) == std::variant_size_v<Method>);
  if (bytes.empty()) refuse_bytes();
  const auto index = std::size_t(bytes.front());
  if (index >= std::size(methods)) refuse_bytes();
  return methods[index];
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  FrameSpec spec;
  spec.how = method_of(bytes);
  FromBytes archive(bytes.subspan(1));
  archive(spec);
  if (!archive.ok() || !archive.at_end()) refuse_bytes();
  return spec;
}

nlohmann::json to_json(const TransferFunction& tf) {
  json colours = json::array(), opacities = json::array();
  for (const auto& p : tf.colours) colours.push_back({p.value, p.srgb.x, p.srgb.y, p.srgb.z});
  for (const auto& p : tf.opacities) opacities.push_back({p.value, p.opacity});
  return {{"name", tf.name}, {"colours", colours}, {"opacities", opacities}, {"nan", to_json(tf.nan_srgb)}};
}

nlohmann::json to_json(const FrameSpec& s) {
  json all = to_json(s.shown);
  all["frame"] = s.frame;
  all["engine"] = name(s.how);
  all["region"] = s.division.region_size;
  std::visit([&all](const auto& how) { fields(how, ToJson{all}); }, s.how);
  return all;
}

}  // namespace ringsplat
