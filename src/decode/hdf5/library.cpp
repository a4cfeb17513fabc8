#include "decode/hdf5/library.hpp"

#include <fmt/format.h>

#include <mutex>

#include "base/printable.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

std::mutex one_at_a_time;
/// Of this thread's lives. No recursive mutex, because those are lost by the child of a fork.
thread_local int lives = 0;

herr_t keep_first(unsigned, const H5E_error2_t* error, void* reason) {
  if (error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 1;  // ends the walk
}

}  // namespace

Quiet::Quiet() {
  if (lives++ == 0) one_at_a_time.lock();
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
  if (--lives == 0) one_at_a_time.unlock();
}

std::string innermost_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  constexpr std::size_t longest = 200;
  return excerpt(reason, longest);
}

void fail(const std::string& problem, const std::string& hint) {
  const std::string reason = innermost_reason();
  throw InputError(reason.empty() ? problem : fmt::format("{} (HDF5: {})", problem, reason), hint);
}

}  // namespace ringsplat::detail::hdf5
