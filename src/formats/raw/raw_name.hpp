#pragma once
#include <filesystem>
#include <optional>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

struct RawName {
  glm::ivec3 dims;
  ScalarType type;
};

/// Parses a name like NAME_256x256x128_uint8.raw (the convention of the Open SciVis data sets); nothing when
/// it has no such tag. Throws InputError for an unknown type or a size beyond int.
std::optional<RawName> parse_raw_name(const std::filesystem::path& path);

}  // namespace ringsplat::detail
