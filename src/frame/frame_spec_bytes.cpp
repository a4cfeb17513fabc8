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
#include "frame/frame_fields.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {
namespace {

class Writer {
 public:
  template <class T>
  void operator()(const char*, const T& value) {
    put(value);
  }
  template <class T>
  void put(const T& value) {
    if constexpr (HasFields<const T>)
      fields(value, *this);
    else
      append(bytes_, value);
  }
  void put(const std::string& text) { append_all(bytes_, text); }
  template <class T>
  void put(const std::vector<T>& values) {
    append_all(bytes_, values);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Is not good() any more when the bytes end too early, or hold no value of their type.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  void operator()(const char*, T& value) {
    get(value);
  }
  template <class T>
  void get(T& value) {
    if constexpr (HasFields<T>) {
      fields(value, *this);
    } else {
      good_ = good_ && take(bytes_, at_, value);
      if constexpr (std::is_enum_v<T>) good_ = good_ && int(value) >= 0 && value <= last_of(value);
    }
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    good_ = good_ && byte <= 1;
    value = byte == 1;
  }
  void get(std::string& text) { good_ = good_ && take_all(bytes_, at_, text); }
  template <class T>
  void get(std::vector<T>& values) {
    good_ = good_ && take_all(bytes_, at_, values);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool has_value = false;
    get(has_value);
    if (has_value) get(value.emplace());
  }
  /// The method's index among Method's alternatives.
  void get_method(Method& how) {
    std::uint8_t index = 0;
    get(index);
    const auto take_it = [&]<std::size_t... I>(std::index_sequence<I...>) {
      return ((index == I && (how.emplace<I>(), true)) || ...);
    };
    good_ = good_ && take_it(std::make_index_sequence<std::variant_size_v<Method>>());
  }
  bool good() const { return good_; }
  bool ended() const { return at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

RunError unreadable() {
  return RunError("a frame announcement cannot be read", "all ranks must run the same build");
}

}  // namespace

Bytes encode(const FrameSpec& spec) {
  Writer writer;
  writer.put(std::uint8_t(spec.how.index()));
  writer.put(spec);
  return writer.take();
}

std::string method_of(std::span<const std::byte> bytes) {
  Method how;
  Reader reader(bytes);
  reader.get_method(how);
  if (!reader.good()) throw unreadable();
  return name(how);
}

FrameSpec decode_frame_spec(std::span<const std::byte> bytes) {
  FrameSpec spec;
  Reader reader(bytes);
  reader.get_method(spec.how);
  reader.get(spec);
  if (!reader.good() || !reader.ended()) throw unreadable();
  return spec;
}

}  // namespace ringsplat
