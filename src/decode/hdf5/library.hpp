#pragma once
// The calls and structures of HDF5 1.10, whatever the library's version is.
#define H5_USE_110_API
#include <hdf5.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ringsplat/base/error.hpp"

/// What every use of HDF5 here needs: identifiers that close themselves, errors as InputError, and attributes
/// as conventions use them.
namespace ringsplat::detail::hdf5 {

/// Owns one of HDF5's identifiers: a file, group, dataset, type, space, property list or attribute.
class Id {
 public:
  Id() = default;
  explicit Id(hid_t id) : id_(id) {}
  ~Id() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  Id(Id&& other) noexcept { std::swap(id_, other.id_); }
  Id& operator=(Id&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

/// Why the last call failed, in HDF5's words, with what it met first; empty for no reason.
std::string innermost_reason();
/// Throws InputError with `problem` and HDF5's own innermost reason for the failed call.
[[noreturn]] void fail(const std::string& problem,
                       const std::string& hint = "the file is damaged or cut short: copy it again");

/// Owns what a call returned; throws InputError with `problem` when it failed.
inline Id made(hid_t id, const std::string& problem) {
  if (id < 0) fail(problem);
  return Id(id);
}

/// The file, for reading only and without locks, which read-only file systems do not have.
Id open_file(const std::filesystem::path& file);

// An attribute that is missing, of another kind, unreadable or unreasonably long gives nothing: attributes
// only describe, the voxels can be drawn without them.

/// All texts of a one-dimensional attribute.
std::vector<std::string> texts_of(hid_t object, const char* attribute);
/// A text, of fixed or variable length; the first of several.
inline std::optional<std::string> text_of(hid_t object, const char* attribute) {
  auto texts = texts_of(object, attribute);
  if (texts.empty()) return {};
  return std::move(texts.front());
}

/// All numbers, integers as double.
std::vector<double> numbers_of(hid_t object, const char* attribute);
/// The first of the numbers.
inline std::optional<double> number_of(hid_t object, const char* attribute) {
  const auto numbers = numbers_of(object, attribute);
  if (numbers.empty()) return {};
  return numbers.front();
}

/// All numbers of a dataset with at most 2²⁰ of them that lie in its own file.
std::vector<double> numbers_in(hid_t dataset);
/// The objects that a netCDF variable's DIMENSION_LIST names for its axes, each its first one; no identifier
/// where an axis has none. Empty without such an attribute.
std::vector<Id> scales_of(hid_t dataset, int axes);

}  // namespace ringsplat::detail::hdf5
