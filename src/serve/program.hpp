#pragma once
#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ringsplat::serve {

/// The first program of that name in the folders of PATH; relative ones do not count.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Starts a program in a folder, without input and with its output discarded, in a process group of its own.
/// Throws RunError when it cannot be started.
pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder);

/// Runs a program like that until it ends. When the time is over or `cancelled` becomes true the group is
/// killed. Its exit code, 128 and the signal when it ended by one, or nothing when it was killed here.
std::optional<int> run_program(const std::filesystem::path& program,
                               const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                               std::chrono::steady_clock::time_point deadline,
                               const std::atomic<bool>& cancelled);

}  // namespace ringsplat::serve
