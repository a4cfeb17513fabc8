#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/input_file.hpp"
#include "base/text.hpp"

/// Which format a file is of, by its first bytes or its name.
namespace ringsplat::detail {

inline bool begins_with(const InputFile& file, std::uint64_t at, std::string_view signature) {
  std::string bytes(signature.size(), '\0');
  return file.read_some(at, std::as_writable_bytes(std::span(bytes))) == bytes.size() && bytes == signature;
}

/// By its signature, whatever its ending. Throws InputError when it cannot be read.
inline bool is_hdf5(const std::filesystem::path& path) {
  const InputFile file(path);
  // HDF5 File Format Specification, "Superblock": at 0, 512, 1024, ... twice as far each time.
  constexpr std::uint64_t farthest = 1 << 20;
  for (std::uint64_t at = 0; at <= farthest; at = at == 0 ? 512 : 2 * at)
    if (begins_with(file, at, "\x89HDF\r\n\x1a\n")) return true;
  return false;
}

/// A file and what follows the colon behind its name. A path that exists as a whole has nothing behind.
inline std::pair<std::filesystem::path, std::string> split_dataset(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::string text = path.string();
  if (std::filesystem::exists(path, ignored)) return {path, ""};
  for (auto at = text.find(':'); at != std::string::npos; at = text.find(':', at + 1))
    if (std::filesystem::is_regular_file(text.substr(0, at), ignored))
      return {text.substr(0, at), text.substr(at + 1)};
  return {path, ""};
}

/// True when the file has DICOM's four letters behind its preamble.
inline bool is_dicom(const std::filesystem::path& path) {
  constexpr std::uint64_t preamble = 128;
  return begins_with(InputFile(path), preamble, "DICM");
}

inline bool is_gzip(const std::filesystem::path& path) { return begins_with(InputFile(path), 0, "\x1F\x8B"); }
// By their endings.
inline bool is_tiff(const std::filesystem::path& path) {
  const auto ending = lower_case(path.extension().string());
  return ending == ".tif" || ending == ".tiff";
}

inline bool is_png(const std::filesystem::path& path) {
  return lower_case(path.extension().string()) == ".png";
}

}  // namespace ringsplat::detail
