#include "formats/signatures.hpp"

#include <span>
#include <system_error>

#include "base/text.hpp"

namespace ringsplat::detail {

bool begins_with(const InputFile& file, std::uint64_t at, std::string_view signature) {
  std::string bytes(signature.size(), '\0');
  return file.read_some(at, std::as_writable_bytes(std::span(bytes))) == bytes.size() && bytes == signature;
}

bool is_hdf5(const std::filesystem::path& path) {
  const InputFile file(path);
  // HDF5 File Format Specification, "Superblock": at 0, 512, 1024, ... twice as far each time.
  constexpr std::uint64_t farthest = 1 << 20;
  for (std::uint64_t at = 0; at <= farthest; at = at == 0 ? 512 : 2 * at)
    if (begins_with(file, at, "\x89HDF\r\n\x1a\n")) return true;
  return false;
}

std::pair<std::filesystem::path, std::string> split_dataset(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::string text = path.string();
  if (std::filesystem::exists(path, ignored)) return {path, ""};
  for (auto at = text.find(':'); at != std::string::npos; at = text.find(':', at + 1))
    if (std::filesystem::is_regular_file(text.substr(0, at), ignored))
      return {text.substr(0, at), text.substr(at + 1)};
  return {path, ""};
}

bool is_dicom(const std::filesystem::path& path) {
  constexpr std::uint64_t preamble = 128;
  return begins_with(InputFile(path), preamble, "DICM");
}

bool is_gzip(const std::filesystem::path& path) { return begins_with(InputFile(path), 0, "\x1F\x8B"); }

bool is_tiff(const std::filesystem::path& path) {
  const auto ending = lower_case(path.extension().string());
  return ending == ".tif" || ending == ".tiff";
}

bool is_png(const std::filesystem::path& path) { return lower_case(path.extension().string()) == ".png"; }

}  // namespace ringsplat::detail
