#pragma once
#include <concepts>
#include <type_traits>

#include "ringsplat/frame/frame_spec.hpp"

/// The members of a frame's description, each with its name, in the order of their bytes. Bytes, JSON, sample
/// frames and tables of studies go by these, so that a new member is named once. The bindings fail to compile
/// when a member is added.
namespace ringsplat {

template <class S, class Described>
concept Describes = std::same_as<std::remove_const_t<S>, Described>;

void fields(Describes<Camera> auto& camera, auto&& visit) {
  auto& [azimuth, elevation, roll, zoom, matrix, fov, distance, pan, eye, target, up, fit] = camera;
  visit("azimuth", azimuth), visit("elevation", elevation), visit("roll", roll), visit("zoom", zoom);
  visit("matrix", matrix), visit("fov", fov), visit("distance", distance), visit("pan", pan);
  visit("eye", eye), visit("target", target), visit("up", up), visit("fit", fit);
}

void fields(Describes<TransferFunction> auto& function, auto&& visit) {
  auto& [name, colours, opacities, nan_srgb] = function;
  visit("name", name), visit("colours", colours), visit("opacities", opacities), visit("nan", nan_srgb);
}

void fields(Describes<Reduction> auto& reduction, auto&& visit) {
  auto& [factor, prefilter] = reduction;
  visit("undersample", factor), visit("prefilter", prefilter);
}

void fields(Describes<Shown> auto& shown, auto&& visit) {
  auto& [camera, width, height, transfer_function, interpolation, mode, isovalue, mixed, values, holes, depth,
         shading, material, light, opacity_correction, opaque_threshold, reduction, clip, clip_planes, cut,
         edges, tints] = shown;
  visit("camera", camera), visit("width", width), visit("height", height);
  visit("transfer_function", transfer_function), visit("interpolation", interpolation);
  visit("mode", mode), visit("isovalue", isovalue), visit("mixed", mixed);
  visit("values", values), visit("holes", holes), visit("depth", depth);
  visit("shading", shading), visit("material", material);
  visit("light", light), visit("opacity_correction", opacity_correction);
  visit("opaque_threshold", opaque_threshold), visit("reduction", reduction), visit("clip", clip);
  visit("clip_planes", clip_planes), visit("cut", cut), visit("edges", edges), visit("tints", tints);
}

void fields(Describes<Splats> auto& splats, auto&& visit) {
  auto& [image_plane, plane_samples, kernel_radius] = splats;
  visit("image_plane", image_plane), visit("plane_samples", plane_samples), visit("radius", kernel_radius);
}

void fields(Describes<Sheets> auto& sheets, auto&& visit) {
  auto& [image_plane, plane_samples, slabs, light_points, adaptive, layers] = sheets;
  visit("image_plane", image_plane), visit("plane_samples", plane_samples), visit("slabs", slabs);
  visit("light_points", light_points), visit("adaptive", adaptive), visit("layers", layers);
}

void fields(Describes<Division> auto& division, auto&& visit) {
  auto& [region_size, dealt_to, pace] = division;
  visit("region", region_size), visit("dealt_to", dealt_to), visit("pace", pace);
}

void fields(Describes<FrameSpec> auto& spec, auto&& visit) {
  auto& [frame, shown, how, division] = spec;
  visit("frame", frame), visit("division", division), visit("shown", shown);
  std::visit([&visit](auto& method) { visit(method.name, method); }, how);
}

template <class T>
concept HasFields = requires(T& described) {
  fields(described, [](const char*, auto&) {});
};

// The last value of each enumeration.
constexpr ImagePlane last_of(ImagePlane) { return ImagePlane::slices; }
constexpr Interpolation last_of(Interpolation) { return Interpolation::nearest; }
constexpr Mode last_of(Mode) { return Mode::attenuated; }
constexpr Shading last_of(Shading) { return Shading::phong; }
constexpr Fit last_of(Fit) { return Fit::box; }

}  // namespace ringsplat
