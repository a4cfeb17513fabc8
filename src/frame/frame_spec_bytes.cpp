#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/counted_values.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {
namespace {

class Writer {
 public:
  template <class T>
  bool operator()(const T& value) {
    append(bytes_, value);
    return true;
  }
  bool operator()(const std::string& text) {
    append_all(bytes_, text);
    return true;
  }
  template <class T>
  bool operator()(const std::vector<T>& values) {
    append_all(bytes_, values);
    return true;
  }
  template <class T>
  bool operator()(const std::optional<T>& value) {
    return (*this)(value.has_value()) && (!value || (*this)(*value));
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// All functions return false when the bytes end too early.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  bool operator()(T& value) {
    return take(bytes_, at_, value);
  }
  bool operator()(bool& value) {
    std::uint8_t byte = 0;
    if (!(*this)(byte) || byte > 1) return false;
    value = byte == 1;
    return true;
  }
  bool operator()(std::string& text) { return take_all(bytes_, at_, text); }
  template <class T>
  bool operator()(std::vector<T>& values) {
    return take_all(bytes_, at_, values);
  }
  template <class T>
  bool operator()(std::optional<T>& value) {
    bool has_value = false;
    return (*this)(has_value) && (!has_value || (*this)(value.emplace()));
  }
  bool ended() const { return at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

// References to all members of a FrameSpec (const or not), one by one since structs have padding. The
// bindings fail to compile when a member is added.

template <class Wire, class... Parts>
bool pass_all(Wire& wire, Parts&... parts) {
  return (wire(parts) && ...);
}

template <class Wire, class S>
requires std::same_as<std::remove_const_t<S>, Shown>
bool pass(Wire& wire, S& shown) {
  auto& [camera, width, height, transfer_function, shading, material, light, opacity_correction,
         opaque_threshold, reduction, clip] = shown;
  auto& [azimuth, elevation, roll, zoom, matrix, fov, distance, pan, eye, target, up, fit] = camera;
  auto& [name, colours, opacities, nan_srgb] = transfer_function;
  auto& [factor, prefilter] = reduction;
  return pass_all(wire, azimuth, elevation, roll, zoom, matrix, fov, distance, pan, eye, target, up, fit,
                  width, height, name, colours, opacities, nan_srgb, shading, material, light,
                  opacity_correction, opaque_threshold, factor, prefilter, clip);
}

template <class Wire, class S>
requires std::same_as<std::remove_const_t<S>, Splats>
bool pass(Wire& wire, S& splats) {
  auto& [image_plane, plane_samples, kernel_radius, kernel, payload, precision] = splats;
  auto& [method, phases, qee_bits, normalisation] = kernel;
  return pass_all(wire, image_plane, plane_samples, kernel_radius, method, phases, qee_bits, normalisation,
                  payload, precision);
}

template <class Wire, class S>
requires std::same_as<std::remove_const_t<S>, Sheets>
bool pass(Wire& wire, S& sheets) {
  auto& [image_plane, plane_samples, slabs, light_points, adaptive] = sheets;
  return pass_all(wire, image_plane, plane_samples, slabs, light_points, adaptive);
}

template <class Wire, class Spec>
bool pass(Wire& wire, Spec& spec) {
  auto& [frame, shown, how, division] = spec;
  auto& [region_size, dealt_to] = division;
  return pass_all(wire, frame, region_size, dealt_to) && pass(wire, shown) &&
         std::visit([&wire](auto& method) { return pass(wire, method); }, how);
}

/// Reads the method: its index among Method's alternatives.
bool take_method(Reader& reader, Method& how) {
  std::uint8_t index = 0;
  if (!reader(index)) return false;
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return ((index == I && (how.emplace<I>(), true)) || ...);
  }
  (std::make_index_sequence<std::variant_size_v<Method>>());
}

template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && value <= last;
}

// True when every enumeration holds one of its values.

bool has_names(const Splats& splats) {
  return is_one_of(splats.image_plane, ImagePlane::slices) &&
         is_one_of(splats.kernel.method, KernelMethod::texture) &&
         is_one_of(splats.kernel.normalisation, Normalisation::exact) &&
         is_one_of(splats.payload, PayloadForm::runs) && is_one_of(splats.precision, Precision::u8);
}

bool has_names(const Sheets& sheets) { return is_one_of(sheets.image_plane, ImagePlane::slices); }

bool has_names(const FrameSpec& spec) {
  return is_one_of(spec.shown.shading, Shading::phong) && is_one_of(spec.shown.camera.fit, Fit::box) &&
         std::visit([](const auto& how) { return has_names(how); }, spec.how);
}

RunError unreadable() {
  return RunError("a frame announcement cannot be read", "all ranks must run the same build");
}

}  // namespace

Bytes encode(const FrameSpec& spec) {
  Writer writer;
  writer(std::uint8_t(spec.how.index()));
  pass(writer, spec);
  return writer.take();
}

std::string method_of(std::span<const std::byte> bytes) {
  Method how;
  Reader reader(bytes);
  if (!take_method(reader, how)) throw unreadable();
  return name(how);
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  FrameSpec spec;
  Reader reader(bytes);
  if (!take_method(reader, spec.how) || !pass(reader, spec) || !reader.ended() || !has_names(spec))
    throw unreadable();
  return spec;
}

}  // namespace ringsplat
