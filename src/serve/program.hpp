#pragma once
#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ringsplat::serve {

/// The first program of that name in the folders of PATH; relative ones do not count.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Runs a program in a folder until it ends, without input and with its output discarded, in a process group
/// of its own. When the time is over or `cancelled` becomes true the group is killed. Its exit code, 128
/// and the signal when it ended by one, or nothing when it was killed here. Throws RunError when it cannot be
/// started.
std::optional<int> run_program(const std::filesystem::path& program,
                               const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                               std::chrono::steady_clock::time_point deadline,
                               const std::atomic<bool>& cancelled);

}  // namespace ringsplat::serve
