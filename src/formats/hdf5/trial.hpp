#pragma once
#include <filesystem>
#include <functional>

namespace ringsplat::detail::hdf5 {

/// Runs `use` in a child process first, in which HDF5 may fail: damaged files make its versions up to 1.14
/// read beyond their memory or run for ever. Throws InputError when the child crashes, or takes more than ten
/// seconds of its processor's time; what `use` throws is left to be thrown again outside. Does nothing where
/// no process can be made.
void try_first(const std::filesystem::path& file, const std::function<void()>& use);

/// Keeps HDF5 from closing what is open when the process ends, which it cannot of damaged files and says at
/// length. For programs that are ours: another's files that it writes by HDF5 would not be finished. Call it
/// first.
void leave_open_at_exit();

}  // namespace ringsplat::detail::hdf5
