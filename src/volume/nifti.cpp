#include <fmt/format.h>
#include <itkNiftiImageIO.h>
#include <nifti1_io.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>

#include "volume/formats.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/itk_image.hpp"
#include "volume/stored_source.hpp"

namespace ringsplat::detail {
namespace {

/// Refuses headers that ITK and its NIfTI library would answer with an abort, a line on stderr or a guess:
/// dimensions of 0 (read as 1), unknown types, numbers that are not finite.
void require_sound(const nifti_1_header& header, const std::filesystem::path& path) {
  if (header.dim[0] < 1 || header.dim[0] > 7)
    throw InputError(fmt::format("{}: dim[0] is {}, no NIfTI header", path.string(), header.dim[0]),
                     "it needs a NIfTI-1 header of 348 bytes");
  for (int i = 1; i <= header.dim[0]; ++i)
    if (header.dim[i] < 1)
      throw InputError(fmt::format("{}: dim[{}] is {}", path.string(), i, header.dim[i]),
                       "every dimension must be at least 1");
  if (nifti_is_valid_datatype(header.datatype) == 0)
    throw InputError(fmt::format("{}: unknown datatype {}", path.string(), header.datatype),
                     "it needs one of the NIfTI-1 types");
  constexpr float largest = 1e12F;  // squares and products stay finite, too
  const auto sound = [](float value) { return std::abs(value) <= largest; };
  const std::initializer_list<std::span<const float>> numbers{std::span(header.pixdim).first(4),
                                                              header.srow_x,
                                                              header.srow_y,
                                                              header.srow_z,
                                                              std::span(&header.quatern_b, 1),
                                                              std::span(&header.quatern_c, 1),
                                                              std::span(&header.quatern_d, 1),
                                                              std::span(&header.qoffset_x, 1),
                                                              std::span(&header.qoffset_y, 1),
                                                              std::span(&header.qoffset_z, 1),
                                                              std::span(&header.vox_offset, 1)};
  for (const auto& list : numbers)
    if (!std::all_of(list.begin(), list.end(), sound))
      throw InputError(fmt::format("{}: spacing, offset or orientation is not a number", path.string()),
                       "correct the header");
}

using NiftiHeader = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

NiftiHeader read_header(const std::filesystem::path& path) {
  nifti_set_debug_level(0);
  int swapped = 0;
  constexpr int no_check = 0;
  const std::unique_ptr<nifti_1_header, decltype(&std::free)> stored(
      nifti_read_header(path.c_str(), &swapped, no_check), &std::free);
  if (stored) require_sound(*stored, path);
  NiftiHeader header(stored ? nifti_image_read(path.c_str(), 0) : nullptr, &nifti_image_free);
  if (!header || header->iname == nullptr)
    throw InputError(
        fmt::format("{} has no readable NIfTI header, or its image file is missing", path.string()),
        "it needs a NIfTI-1 header of 348 bytes");
  return header;
}

ScalarType stored_type(const nifti_image& header, const std::filesystem::path& path) {
  switch (header.datatype) {
    case DT_INT8:
      return ScalarType::int8;
    case DT_UINT8:
      return ScalarType::uint8;
    case DT_INT16:
      return ScalarType::int16;
    case DT_UINT16:
      return ScalarType::uint16;
    case DT_INT32:
      return ScalarType::int32;
    case DT_UINT32:
      return ScalarType::uint32;
    case DT_FLOAT32:
      return ScalarType::float32;
    case DT_FLOAT64:
      return ScalarType::float64;
    default:
      break;
  }
  throw InputError(fmt::format("{}: voxels of type {} cannot be rendered", path.string(),
                               nifti_datatype_string(header.datatype)),
                   "convert them to a scalar of at most 32 bits or float64 first");
}

/// NIfTI-1 standard, "scl_slope and scl_inter": a slope of 0 means that the values are as stored.
std::optional<Rescale> rescale_of(const nifti_image& header) {
  const double slope = header.scl_slope, intercept = header.scl_inter;
  if (!std::isfinite(slope) || !std::isfinite(intercept) || slope == 0) return {};
  if (slope == 1 && intercept == 0) return {};
  return Rescale{slope, intercept};
}

}  // namespace

std::unique_ptr<VolumeSource> open_nifti(const std::filesystem::path& path, const VolumeChoice&) {
  return with_itk(path, [&] {
    const auto header = read_header(path);
    auto io = itk::NiftiImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();

    StoredVoxels stored{.file = header->iname};
    stored.compressed = nifti_is_gzfile(header->iname) != 0;
    const auto offset = std::uint64_t(std::max(header->iname_offset, 0));
    (stored.compressed ? stored.skip : stored.offset) = offset;
    const bool swapped = header->byteorder != nifti_short_order();
    stored.big_endian = swapped != (std::endian::native == std::endian::big);
    Grid grid = grid_of(*io, path);
    stored.type = stored_type(*header, path);
    stored.rescale = rescale_of(*header);
    grid.type = !stored.rescale                      ? stored.type
                : stored.type == ScalarType::float64 ? ScalarType::float64
                                                     : ScalarType::float32;
    return with_notes(stored_source(grid, stored), {.world = World::patient, .unit = "mm"});
  });
}

}  // namespace ringsplat::detail
