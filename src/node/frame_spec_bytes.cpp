#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "ringsplat/node/frame_spec.hpp"

namespace ringsplat {
namespace {

class Writer {
 public:
  template <class T>
  bool operator()(const T& value) {
    append(bytes_, value);
    return true;
  }
  bool operator()(const std::string& text) { return elements(text); }
  template <class T>
  bool operator()(const std::vector<T>& values) {
    return elements(values);
  }
  template <class T>
  bool operator()(const std::optional<T>& value) {
    return (*this)(value.has_value()) && (!value || (*this)(*value));
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class Container>
  bool elements(const Container& values) {
    (*this)(std::uint32_t(values.size()));
    for (const auto& value : values) (*this)(value);
    return true;
  }

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
  bool operator()(std::string& text) { return elements(text); }
  template <class T>
  bool operator()(std::vector<T>& values) {
    return elements(values);
  }
  template <class T>
  bool operator()(std::optional<T>& value) {
    bool has_value = false;
    return (*this)(has_value) && (!has_value || (*this)(value.emplace()));
  }
  bool ended() const { return at_ == bytes_.size(); }

 private:
  template <class Container>
  bool elements(Container& values) {
    std::uint32_t count = 0;
    if (!(*this)(count) || count > bytes_.size() - at_) return false;
    values.resize(count);
    for (auto& value : values)
      if (!(*this)(value)) return false;
    return true;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

/// All that a FrameSpec (const or not) holds, one by one: structs have padding.
template <class Wire, class Spec>
bool pass(Wire& wire, Spec& s) {
  const auto all = [&wire](auto&... parts) { return (wire(parts) && ...); };
  auto& [azimuth, elevation, roll, zoom, matrix] = s.camera;
  auto& [method, phases, qee_bits, normalisation] = s.kernel;
  auto& [name, colours, opacities, nan_srgb] = s.transfer_function;
  auto& [factor, prefilter] = s.reduction;
  return all(s.frame, azimuth, elevation, roll, zoom, matrix, s.width, s.height, s.image_plane,
             s.plane_samples, s.region_size, s.dealt_to) &&
         all(name, colours, opacities, nan_srgb, s.shading, s.material, s.light, s.kernel_radius, method,
             phases, qee_bits, normalisation) &&
         all(s.opacity_correction, s.opaque_threshold, factor, prefilter, s.payload, s.precision);
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
  if (!pass(reader, spec) || !reader.ended())
    throw RunError("a frame announcement cannot be read", "all ranks must run the same build");
  return spec;
}

}  // namespace ringsplat
