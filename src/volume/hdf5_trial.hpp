#pragma once
#include <filesystem>
#include <functional>

namespace ringsplat::detail::hdf5 {

/// Runs `use` in a child process first, in which HDF5 may fail: damaged files make its versions up to 1.14
/// read beyond their memory or run for ever. Throws InputError when the child crashes, or takes more than ten
/// seconds of its processor's time; what `use` throws is left to be thrown again outside. Does nothing where
/// no process can be made.
void try_first(const std::filesystem::path& file, const std::function<void()>& use);

}  // namespace ringsplat::detail::hdf5
