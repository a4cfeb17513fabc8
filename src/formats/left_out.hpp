#pragma once
#include <filesystem>
#include <string>

namespace ringsplat::detail {

/// Throws InputError: the file is of a format that this build cannot read, as it does without `library` (as
/// in "ITK"), whose CMake option is RINGSPLAT_WITH_ and the name in capitals.
[[noreturn]] void refuse_left_out(const std::filesystem::path& path, const std::string& format,
                                  const std::string& library);

}  // namespace ringsplat::detail
