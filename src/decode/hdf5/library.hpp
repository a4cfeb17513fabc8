#pragma once
// The calls and structures of HDF5 1.10, whatever the library's version is.
#define H5_USE_110_API
#include <hdf5.h>

#include <string>
#include <utility>

#include "ringsplat/base/error.hpp"

/// What every use of HDF5 here needs: identifiers that close themselves, and errors as InputError.
namespace ringsplat::detail::hdf5 {

/// Owns one of HDF5's identifiers: a file, group, dataset, type, space, property list or attribute.
class Id {
 public:
  Id() = default;
  explicit Id(hid_t id) : id_(id) {}
  ~Id() { close(); }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Id& operator=(Id&& other) noexcept {
    if (this != &other) {
      close();
      id_ = std::exchange(other.id_, H5I_INVALID_HID);
    }
    return *this;
  }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  void close() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  hid_t id_ = H5I_INVALID_HID;
};

/// While one lives, its thread alone uses HDF5 (not every build of it allows more), and HDF5 prints nothing.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
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
inline void done(herr_t status, const std::string& problem) {
  if (status < 0) fail(problem);
}

}  // namespace ringsplat::detail::hdf5
