#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>
#include <span>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/text.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat::detail {
namespace {

/// If x.raw has a header beside it, the user probably wants that.
std::string hint_for(const std::filesystem::path& path) {
  for (const char* ending : {".nhdr", ".mhd"}) {
    auto header = path;
    header.replace_extension(ending);
    std::error_code ignored;
    if (std::filesystem::exists(header, ignored)) return fmt::format("open {} instead", header.string());
  }
  return "name it like head_256x256x128_uint8.raw, or give --dims 256x256x128 --type uint8";
}

/// Part of the numbers other than 0 that have a size in which something is measured.
double usual_part(ScalarType type, std::vector<std::byte> bytes, bool big_endian) {
  to_native_order(bytes, size_of(type), big_endian);
  constexpr double least = 1e-12, most = 1e12;
  std::size_t usual = 0, all = 0;
  for_values(type, bytes, [&](auto numbers) {
    for (const auto number : numbers) {
      const double size = std::abs(double(number));
      if (size >= least && size <= most) ++usual;
      if (size != 0) ++all;
    }
  });
  return all == 0 ? 1 : double(usual) / double(all);
}

/// Floats in the wrong order have any exponent.
void warn_of_byte_order(const InputFile& file, const StoredVoxels& voxels, std::uint64_t bytes) {
  constexpr std::uint64_t runs = 64, run_bytes = 512;
  const auto size = size_of(voxels.type);
  std::vector<std::byte> some;
  for (std::uint64_t k = 0; k < runs; ++k) {
    const auto at = bytes / size * k / runs * size, had = some.size();
    some.resize(had + std::min<std::uint64_t>(run_bytes, bytes - at));
    some.resize(had + file.read_some(voxels.offset + at, std::span(some).subspan(had)));
  }
  constexpr double few = 0.6, nearly_all = 0.98;
  if (usual_part(voxels.type, some, voxels.big_endian) > few) return;
  if (usual_part(voxels.type, some, !voxels.big_endian) < nearly_all) return;
  log_warning_once("{}: its numbers make sense only in the other byte order: give --endian {}",
                   file.path().string(), voxels.big_endian ? "little" : "big");
}

}  // namespace

std::optional<Grid> parse_raw_name(const std::filesystem::path& path) {
  static const std::regex pattern(R"(.*_(\d+)x(\d+)x(\d+)_([A-Za-z0-9]+)\.raw)", std::regex::icase);
  const std::string name = path.filename().string();
  std::smatch match;
  if (!std::regex_match(name, match, pattern)) return {};
  const auto size = [&](std::size_t i) {
    if (const auto value = number_in<int>(match[i].str())) return *value;
    refuse(path, "give the true size with --dims", "the dimension {} in its name is too large",
           match[i].str());
  };
  return Grid{.dims = {size(1), size(2), size(3)}, .type = scalar_type_from(match[4].str())};
}

std::unique_ptr<VolumeSource> open_raw(const std::filesystem::path& path, const RawDescription& raw) {
  const bool complete = raw.dims && raw.type;
  const auto named = complete ? std::nullopt : parse_raw_name(path);
  if (!complete && !named)
    refuse(path, hint_for(path), "a raw file's {} must be known",
           raw.dims   ? "type"
           : raw.type ? "dimensions"
                      : "dimensions and type");
  Grid grid = named.value_or(Grid());
  if (raw.dims) grid.dims = *raw.dims;
  if (raw.type) grid.type = *raw.type;
  if (raw.spacing) grid.spacing = *raw.spacing;
  check_lattice(grid, path.string());

  const auto actual = InputFile(path).size(), offset = raw.offset.value_or(0);
  // Left-over bytes mean wrong dimensions, unless an offset shows that the user knows the file.
  const bool fits = actual >= offset && actual - offset >= grid.bytes();
  const bool exact = fits && actual - offset == grid.bytes();
  if (raw.offset ? !fits : !exact)
    refuse(path, "correct --dims, --type or --offset",
           "{} x {} x {} {} needs {} bytes after an offset of {}, the file has {}", grid.dims.x, grid.dims.y,
           grid.dims.z, to_string(grid.type), grid.bytes(), offset, actual > offset ? actual - offset : 0);
  const StoredVoxels voxels{
      .file = path, .offset = offset, .big_endian = raw.big_endian.value_or(false), .type = grid.type};
  if (!is_whole(grid.type)) warn_of_byte_order(InputFile(path), voxels, grid.bytes());
  return stored_source(grid, {voxels});
}

}  // namespace ringsplat::detail
