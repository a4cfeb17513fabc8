#pragma once
#include <filesystem>
#include <optional>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

struct RawName {
  glm::ivec3 dims;
  ScalarType type;
};

/// What a name like NAME_256x256x128_uint8.raw says (the convention of the Open SciVis data sets), or
/// nothing when it has no such tag. Throws InputError for an unknown type or a size beyond int.
std::optional<RawName> parse_raw_name(const std::filesystem::path& path);

}  // namespace ringsplat::detail
