#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"

/// Structs as bytes, between processes of one machine. A struct names its fields once for both ways, in a
/// template `fields(archive, value)` that calls archive(field...).
namespace ringsplat::detail {

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
    if constexpr (std::is_trivially_copyable_v<T>)
      append(bytes, value);
    else
      fields(*this, const_cast<T&>(value));  // which only reads it
  }
  void put(const std::string& text) { put_all(text); }
  void put(const std::filesystem::path& path) { put(path.string()); }
  template <class T>
  void put(const std::vector<T>& list) {
    put_all(list);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class List>
  void put_all(const List& list) {
    put(std::uint64_t(list.size()));
    for (const auto& value : list) put(value);
  }
};

/// What does not fit leaves ok() false and values as they are.
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
    if constexpr (std::is_trivially_copyable_v<T>)
      ok_ = ok_ && take(bytes_, at_, value);
    else
      fields(*this, value);
  }
  void get(std::string& text) { get_all(text); }
  void get(std::filesystem::path& path) {
    std::string text;
    get(text);
    path = text;
  }
  template <class T>
  void get(std::vector<T>& list) {
    get_all(list);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    if (ok_ && there) get(value.emplace());
  }
  template <class List>
  void get_all(List& list) {
    std::uint64_t count = 0;
    get(count);
    ok_ = ok_ && count <= bytes_.size() - at_;  // each takes a byte at least
    if (ok_) list.resize(std::size_t(count));
    for (std::size_t i = 0; ok_ && i < list.size(); ++i) get(list[i]);
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

template <class T>
Bytes to_bytes(const T& value) {
  ToBytes archive;
  archive(value);
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

}  // namespace ringsplat::detail
