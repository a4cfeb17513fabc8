#include "ringsplat/volume/grid.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <string_view>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// By type its own name, then others.
constexpr std::array<std::array<std::string_view, 7>, 8> type_names{{
    {{"int8", "i8", "schar", "signed char", "int8_t"}},
    {{"uint8", "u8", "uchar", "byte", "unsigned char", "uint8_t"}},
    {{"int16", "i16", "short", "int16_t", "short int", "signed short", "signed short int"}},
    {{"uint16", "u16", "ushort", "uint16_t", "unsigned short", "unsigned short int"}},
    {{"int32", "i32", "int", "int32_t", "signed int"}},
    {{"uint32", "u32", "uint", "uint32_t", "unsigned int"}},
    {{"float32", "f32", "float"}},
    {{"float64", "f64", "double"}},
}};

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

std::size_t size_of(ScalarType type) {
  return visit_type(type, [](auto value) { return sizeof(value); });
}

std::string to_string(ScalarType type) { return std::string(type_names[std::size_t(type)].front()); }

ScalarType scalar_type_from(const std::string& name) {
  const std::string lower = detail::lower_case(name);
  std::vector<std::string_view> known;
  for (std::size_t i = 0; i < type_names.size(); ++i) {
    const auto& names = type_names[i];
    if (!lower.empty() && std::find(names.begin(), names.end(), lower) != names.end()) return ScalarType(i);
    known.push_back(names.front());
  }
  throw InputError(fmt::format("'{}' is not a scalar type", name), "use one of " + detail::joined(known));
}

void detail::check_lattice(const Grid& grid, const std::string& where) {
  const auto& d = grid.dims;
  if (d.x < 1 || d.y < 1 || d.z < 1)
    throw InputError(fmt::format("{}: dimensions {}", where, product_of(d)),
                     "every dimension must be at least 1");
  const auto most = std::numeric_limits<std::int64_t>::max() / std::int64_t(size_of(grid.type));
  if (std::int64_t(d.x) * d.y > most / d.z)
    throw InputError(
        fmt::format("{}: {} voxels of {} overflow 64 bits", where, product_of(d), to_string(grid.type)),
        "correct the sizes in the header");
  if (!finite(grid.origin))
    throw InputError(fmt::format("{}: the origin is not finite", where), "correct the origin in the header");
  double lengths = 1;
  for (int i = 0; i < 3; ++i) lengths *= glm::length(grid.direction[i]);
  // A shear this flat has no usable normals; scanners tilt by 30 degrees at most.
  constexpr double flattest = 1e-3;
  const double volume = std::abs(glm::determinant(grid.direction));
  if (!std::isfinite(lengths) || !(volume > flattest * lengths))
    throw InputError(fmt::format("{}: the direction matrix is singular", where),
                     "correct the orientation in the header");
}

void check(const Grid& grid, const std::string& where) {
  detail::check_lattice(grid, where);
  const auto& s = grid.spacing;
  const auto steps = s * glm::dvec3(glm::length(grid.direction[0]), glm::length(grid.direction[1]),
                                    glm::length(grid.direction[2]));
  const auto extents = steps * glm::dvec3(grid.dims);
  const double finest = std::min({steps.x, steps.y, steps.z}),
               longest = std::max({extents.x, extents.y, extents.z});
  constexpr double least = 1e-300, most = 1e300, most_apart = 1e6;
  const char* const hint = "give the distances between voxels, for instance --spacing 1x1x1";
  if (!finite(s) || s.x <= 0 || s.y <= 0 || s.z <= 0 || !(finest >= least && longest <= most))
    throw InputError(fmt::format("{}: spacing {} {} {}", where, s.x, s.y, s.z), hint);
  // Nothing of the finer axes would be seen, and rays count voxels.
  const int most_voxels = std::max({grid.dims.x, grid.dims.y, grid.dims.z});
  if (longest > std::max(most_apart, double(most_voxels)) * finest)
    throw InputError(
        fmt::format("{}: spacing {} {} {}: the volume would be {:.2g} times as long as its finest "
                    "voxel",
                    where, s.x, s.y, s.z, longest / finest),
        hint);
}

Facts facts_of(const Grid& grid) {
  // Adding 0 makes -0 the 0 that it equals.
  const auto text = [](const glm::dvec3& v) { return fmt::format("{} {} {}", v.x + 0, v.y + 0, v.z + 0); };
  return {{"dimensions", detail::product_of(grid.dims)},
          {"type", to_string(grid.type)},
          {"spacing", text(grid.spacing)},
          {"origin", text(grid.origin)},
          {"direction", fmt::format("{}, {}, {}", text(grid.direction[0]), text(grid.direction[1]),
                                    text(grid.direction[2]))}};
}

}  // namespace ringsplat
