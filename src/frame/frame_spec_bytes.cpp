#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/counted_values.hpp"
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

/// Everything returns false when the bytes end too early.
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

/// All that a FrameSpec (const or not) holds, one by one: structs have padding. A member that is added does
/// not fit the names here.
template <class Wire, class Spec>
bool pass(Wire& wire, Spec& spec) {
  const auto all = [&wire](auto&... parts) { return (wire(parts) && ...); };
  auto& [frame, camera, width, height, image_plane, plane_samples, region_size, dealt_to, transfer_function,
         shading, material, light, kernel_radius, kernel, opacity_correction, opaque_threshold, reduction,
         payload, precision] = spec;
  auto& [azimuth, elevation, roll, zoom, matrix] = camera;
  auto& [name, colours, opacities, nan_srgb] = transfer_function;
  auto& [method, phases, qee_bits, normalisation] = kernel;
  auto& [factor, prefilter] = reduction;
  return all(frame, azimuth, elevation, roll, zoom, matrix, width, height, image_plane, plane_samples) &&
         all(region_size, dealt_to, name, colours, opacities, nan_srgb, shading, material, light) &&
         all(kernel_radius, method, phases, qee_bits, normalisation, opacity_correction, opaque_threshold) &&
         all(factor, prefilter, payload, precision);
}

template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && value <= last;
}

/// Every enumeration has one of its values.
bool has_names(const FrameSpec& spec) {
  return is_one_of(spec.image_plane, ImagePlane::slices) && is_one_of(spec.shading, Shading::phong) &&
         is_one_of(spec.kernel.method, KernelMethod::texture) &&
         is_one_of(spec.kernel.normalisation, Normalisation::exact) &&
         is_one_of(spec.payload, PayloadForm::runs) && is_one_of(spec.precision, Precision::u8);
}

}  // namespace

Bytes encode(const FrameSpec& spec) {
  Writer writer;
  pass(writer, spec);
  return writer.take();
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  FrameSpec spec;
  Reader reader(bytes);
  if (!pass(reader, spec) || !reader.ended() || !has_names(spec))
    throw RunError("a frame announcement cannot be read", "all ranks must run the same build");
  return spec;
}

}  // namespace ringsplat
