#include <utility>

#include "base/byte_order.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* hint = "write it with FreeSurfer's mri_convert, or as .nii";

ScalarType stored_type(int code, const std::filesystem::path& path) {
  constexpr std::pair<int, ScalarType> types[] = {{0, ScalarType::uint8},
                                                  {1, ScalarType::int32},
                                                  {3, ScalarType::float32},
                                                  {4, ScalarType::int16},
                                                  {10, ScalarType::uint16}};
  if (const auto type = found(types, code)) return *type;
  refuse(path, hint, "voxels of type {} cannot be rendered", code);
}

/// Where a header does not say it, slices are coronal, around the world's middle (FreeSurfer's mri.c).
void place(const BinaryFields& header, Grid& grid) {
  constexpr std::size_t has_place = 28, spacing = 30, axes = 42, centre = 78;
  const auto reals = [&](std::size_t at) {
    return glm::dvec3(header.at<float>(at), header.at<float>(at + 4), header.at<float>(at + 8));
  };
  const bool there = header.at<std::int16_t>(has_place) > 0;
  const glm::dvec3 to_lps(-1, -1, 1), coronal[] = {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}};
  if (there) grid.origin = reals(centre) * to_lps;
  for (int k = 0; k < 3; ++k) {
    grid.direction[k] = there ? reals(axes + 12 * std::size_t(k)) * to_lps : coronal[k];
    if (there) grid.spacing[k] = reals(spacing)[k];
    grid.origin -= grid.direction[k] * grid.spacing[k] * (grid.dims[k] / 2.0);
  }
}

}  // namespace

std::unique_ptr<VolumeSource> open_mgh(const std::filesystem::path& path, const VolumeChoice& choice) {
  std::vector<std::byte> bytes(284);
  auto stored = stored_in(path);
  stored.big_endian = true;
  stored.read_head(bytes);
  const BinaryFields header(bytes, stored.big_endian);
  if (const int version = header.at<int>(0); version != 1)
    refuse(path, hint, "its version is {}, not 1", version);
  const int frames = header.at<int>(16);
  if (frames < 1) refuse(path, hint, "it has {} frames", frames);
  Grid grid;
  grid.dims = {header.at<int>(4), header.at<int>(8), header.at<int>(12)};
  grid.type = stored.type = stored_type(header.at<int>(20), path);
  place(header, grid);
  check_lattice(grid, path.string());
  stored.before() = bytes.size();
  stored.choose(grid.bytes(), frames, chosen_frame(choice, frames, path));
  return with_notes(stored_source(grid, {stored}), {.world = World::patient, .unit = "mm", .frames = frames});
}

}  // namespace ringsplat::detail
