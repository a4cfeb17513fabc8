#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/byte_stream.hpp"
#include "ringsplat/base/fact.hpp"

/// Structs as bytes, between processes of one build. A struct names its fields once for both ways, in a
/// template `fields(value, archive)` that calls archive(field...), or archive("name", field).
namespace ringsplat {

class ToBytes {
 public:
  template <class... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }
  Bytes bytes;

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (requires(T & described, ToBytes & archive) { fields(described, archive); }) {
      fields(const_cast<T&>(value), *this);  // which only reads it
    } else if constexpr (requires(T & list) { list.resize(0); }) {
      put(std::uint64_t(value.size()));
      for (const auto& each : value) put(each);
    } else {
      append(bytes, value);
    }
  }
  void put(const char*) {}  // a field's name
  void put(const std::filesystem::path& path) { put(path.string()); }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
};

/// What does not fit, or is no value of its type, leaves ok() false.
class FromBytes {
 public:
  explicit FromBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }
  bool ok() const { return ok_; }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  template <class T>
  void get(T& value) {
    if constexpr (requires { fields(value, *this); }) {
      fields(value, *this);
    } else if constexpr (requires { value.resize(0); }) {
      std::uint64_t count = 0;
      get(count);
      ok_ = ok_ && count <= bytes_.size() - at_;  // each takes a byte at least
      if (ok_) value.resize(std::size_t(count));
      for (std::size_t i = 0; ok_ && i < value.size(); ++i) get(value[i]);
    } else {
      ok_ = ok_ && take(bytes_, at_, value);
      // An enumeration of which last_of() is known has no other values.
      if constexpr (requires { last_of(value); }) ok_ = ok_ && int(value) >= 0 && value <= last_of(value);
    }
  }
  void get(const char*) {}
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    ok_ = ok_ && byte <= 1;
    value = byte == 1;
  }
  void get(std::filesystem::path& path) {
    std::string text;
    get(text);
    path = text;
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    if (ok_ && there) get(value.emplace());
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

template <class... Values>
Bytes to_bytes(const Values&... values) {
  ToBytes archive;
  archive(values...);
  return std::move(archive.bytes);
}

/// Nothing when the bytes are no T.
template <class T>
std::optional<T> from_bytes(std::span<const std::byte> bytes) {
  FromBytes archive(bytes);
  T value;
  archive(value);
  if (!archive.ok() || !archive.at_end()) return {};
  return value;
}

void fields(Fact& fact, auto& archive) { archive(fact.field, fact.value); }

}  // namespace ringsplat
