#include <fmt/format.h>

#include <optional>

#include "ringsplat/base/error.hpp"
#include "volume/formats.hpp"
#include "volume/input_file.hpp"
#include "volume/limits.hpp"
#include "volume/raw_name.hpp"
#include "volume/stored_source.hpp"

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

}  // namespace

std::unique_ptr<VolumeSource> open_raw(const std::filesystem::path& path, const RawDescription& raw) {
  const bool complete = raw.dims && raw.type;
  const auto named = complete ? std::nullopt : parse_raw_name(path);
  if (!complete && !named)
    throw InputError(fmt::format("{}: a raw file's {} must be known", path.string(),
                                 raw.dims   ? "type"
                                 : raw.type ? "dimensions"
                                            : "dimensions and type"),
                     hint_for(path));
  Grid grid;
  grid.dims = raw.dims ? *raw.dims : named->dims;
  grid.type = raw.type ? *raw.type : named->type;
  if (raw.spacing) grid.spacing = *raw.spacing;
  check_lattice(grid, path.string());

  const auto actual = InputFile(path).size(), offset = raw.offset.value_or(0);
  // Left-over bytes mean wrong dimensions, unless an offset shows that the user knows the file.
  const bool fits = actual >= offset && actual - offset >= grid.bytes();
  const bool exact = fits && actual - offset == grid.bytes();
  if (raw.offset ? !fits : !exact)
    throw InputError(fmt::format("{}: {} x {} x {} {} needs {} bytes after an offset of {}, the file has {}",
                                 path.string(), grid.dims.x, grid.dims.y, grid.dims.z, to_string(grid.type),
                                 grid.bytes(), offset, actual > offset ? actual - offset : 0),
                     "correct --dims, --type or --offset");
  return stored_source(
      grid,
      {.file = path, .offset = offset, .big_endian = raw.big_endian.value_or(false), .type = grid.type});
}

}  // namespace ringsplat::detail
