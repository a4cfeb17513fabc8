#include <fmt/format.h>
#include <itkNiftiImageIO.h>
#include <nifti1_io.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "base/input_file.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/itk_image.hpp"
#include "formats/limits.hpp"
#include "formats/nifti/nifti_image.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

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

/// Where the sform puts it; ITK, which drops a shear, finds other orientations.
Grid grid_of(const nifti_image& header, const std::filesystem::path& path) {
  if (header.sform_code > 0) {
    Grid grid;
    grid.dims = {header.nx, std::max(1, header.ny), std::max(1, header.nz)};
    NiftiAffine affine{};
    for (std::size_t column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) affine[column][row] = double(header.sto_xyz.m[row][column]);
    place_nifti(affine, header.xyz_units, path, grid);
    return grid;
  }
  auto io = itk::NiftiImageIO::New();
  io->SetFileName(path.string());
  io->ReadImageInformation();
  Grid grid = lattice_of(*io, path);
  grid.origin *= nifti_millimetres(header.xyz_units);  // ITK scales the spacing only
  return grid;
}

NiftiImage read_nifti1(const std::filesystem::path& path) {
  const auto header = read_header(path);
  NiftiImage image;
  const auto [type, colours] = nifti_type(header->datatype, nifti_datatype_string(header->datatype), path);
  image.grid = grid_of(*header, path);
  image.grid.type = image.stored.type = type;
  image.colours = colours;
  image.frames = std::max(1, header->nt);
  const auto vectors =
      std::int64_t(std::max(1, header->nu)) * std::max(1, header->nv) * std::max(1, header->nw);
  image.vectors = int(std::min<std::int64_t>(vectors, std::numeric_limits<int>::max()));
  image.stored.file = header->iname;
  image.stored.compressed = nifti_is_gzfile(header->iname) != 0;
  const auto offset = std::uint64_t(std::max(header->iname_offset, 0));
  (image.stored.compressed ? image.stored.skip : image.stored.offset) = offset;
  const bool swapped = header->byteorder != nifti_short_order();
  image.stored.big_endian = swapped != (std::endian::native == std::endian::big);
  image.stored.rescale = nifti_rescale(header->scl_slope, header->scl_inter);
  return image;
}

std::unique_ptr<VolumeSource> source_of(NiftiImage image, const VolumeChoice& choice,
                                        const std::filesystem::path& path) {
  auto& stored = image.stored;
  const auto wide = interleaved_grid(image.grid, image.colours, path.string());
  const auto volumes = std::uint64_t(image.frames) * std::uint64_t(image.vectors);
  const auto before = stored.compressed ? stored.skip : stored.offset;
  const auto total = bytes_of_volumes(path, wide.bytes(), volumes, before);
  const auto size = InputFile(stored.file).size();
  if (stored.compressed)
    require_compressed_bytes(stored.file, size, total, deflate_best_ratio);
  else
    require_bytes(stored.file, size, before, total - before);

  if (image.vectors > 1 && image.colours > 1)
    throw InputError(fmt::format("{}: {} colours a voxel", path.string(), image.vectors),
                     "extract one of them");
  const int channels = image.vectors * image.colours;
  const auto taken = channels > 1 ? choose_channel(choice.channel, channels, image.colours > 1, path.string())
                                  : ChannelChoice{};
  const auto frame = std::uint64_t(std::clamp(choice.frame.value_or(0), 0, image.frames - 1));
  const auto vector = std::uint64_t(image.vectors > 1 ? taken.index.value_or(0) : 0);
  (stored.compressed ? stored.skip : stored.offset) +=
      (vector * std::uint64_t(image.frames) + frame) * wide.bytes();

  std::unique_ptr<VolumeSource> source;
  if (image.colours > 1) {
    stored.rescale.reset();  // the standard: not for colours
    source = channel_source(stored_source(wide, stored), image.grid, image.colours, taken);
  } else {
    Grid grid = image.grid;
    if (stored.rescale && grid.type != ScalarType::float64) grid.type = ScalarType::float32;
    source = stored_source(grid, stored);
  }
  return with_notes(std::move(source),
                    {.world = World::patient, .unit = "mm", .frames = image.frames, .channels = channels});
}

}  // namespace

NiftiType nifti_type(int code, const std::string& name, const std::filesystem::path& path) {
  switch (code) {
    case DT_INT8:
      return {ScalarType::int8};
    case DT_UINT8:
      return {ScalarType::uint8};
    case DT_INT16:
      return {ScalarType::int16};
    case DT_UINT16:
      return {ScalarType::uint16};
    case DT_INT32:
      return {ScalarType::int32};
    case DT_UINT32:
      return {ScalarType::uint32};
    case DT_FLOAT32:
      return {ScalarType::float32};
    case DT_FLOAT64:
      return {ScalarType::float64};
    case DT_RGB24:
      return {ScalarType::uint8, 3};
    case DT_RGBA32:
      return {ScalarType::uint8, 4};
    default:
      break;
  }
  throw InputError(fmt::format("{}: voxels of type {} cannot be rendered", path.string(), name),
                   "convert them to int32, uint32 or float32 first");
}

double nifti_millimetres(int xyzt_units) {
  const int space = xyzt_units & 7;
  return space == NIFTI_UNITS_METER ? 1e3 : space == NIFTI_UNITS_MICRON ? 1e-3 : 1;
}

std::optional<Rescale> nifti_rescale(double slope, double intercept) {
  if (!std::isfinite(slope) || !std::isfinite(intercept) || slope == 0) return {};
  if (slope == 1 && intercept == 0) return {};
  return Rescale{slope, intercept};
}

std::unique_ptr<VolumeSource> open_nifti(const std::filesystem::path& path, const VolumeChoice& choice) {
  if (auto image = read_nifti2(path)) return source_of(std::move(*image), choice, path);
  return with_itk(path, [&] { return source_of(read_nifti1(path), choice, path); });
}

}  // namespace ringsplat::detail
