#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "base/input_file.hpp"

/// Which format a file is of, by its first bytes or its name.
namespace ringsplat::detail {

bool begins_with(const InputFile& file, std::uint64_t at, std::string_view signature);

/// By its signature, whatever its ending. Throws InputError when it cannot be read.
bool is_hdf5(const std::filesystem::path& path);
/// A file and what follows the colon behind its name. A path that exists as a whole has nothing behind.
std::pair<std::filesystem::path, std::string> split_dataset(const std::filesystem::path& path);
/// True when the file has DICOM's four letters behind its preamble.
bool is_dicom(const std::filesystem::path& path);
bool is_gzip(const std::filesystem::path& path);
// By their endings.
bool is_tiff(const std::filesystem::path& path);
bool is_png(const std::filesystem::path& path);

}  // namespace ringsplat::detail
