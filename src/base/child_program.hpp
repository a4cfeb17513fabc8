#pragma once
#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ringsplat {

/// A file that may be executed.
bool is_program(const std::filesystem::path& file);

/// The first program of that name in the folders of PATH; relative ones do not count.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Starts a program in a folder, without input and with its output discarded, in a process group of its own.
/// It is given copies of `descriptors` as 3 and so on, and no others. Throws RunError when it cannot be
/// started.
pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                    const std::filesystem::path& folder, const std::vector<int>& descriptors = {});

/// Runs a program like that until it ends. When the time is over or `cancelled` becomes true the group is
/// killed. Its exit code, 128 and the signal when it ended by one, or nothing when it was killed here.
std::optional<int> run_program(const std::filesystem::path& program,
                               const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                               std::chrono::steady_clock::time_point deadline,
                               const std::atomic<bool>& cancelled);

}  // namespace ringsplat
