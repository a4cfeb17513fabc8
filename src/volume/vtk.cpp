#include <itkVTKImageIO.h>

#include <fstream>

#include "volume/formats.hpp"
#include "volume/itk_image.hpp"
#include "volume/limits.hpp"
#include "volume/stored_source.hpp"

namespace ringsplat::detail {
namespace {

/// The byte after the last header line: SCALARS, and LOOKUP_TABLE when it follows (VTK file formats,
/// "Simple legacy formats").
std::uint64_t header_end(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  constexpr int longest_header = 100;  // lines; ITK reads a dozen
  for (int i = 0; i < longest_header && std::getline(stream, line); ++i) {
    if (i == 0 && line.rfind("# vtk DataFile", 0) != 0) break;
    if (lower_case(line).rfind("scalars", 0) != 0) continue;
    const auto end = stream.tellg();
    if (std::getline(stream, line) && lower_case(line).rfind("lookup_table", 0) == 0)
      return std::uint64_t(stream.tellg());
    return std::uint64_t(end);
  }
  throw InputError(path.string() + " is not a legacy VTK file with SCALARS",
                   "write it as STRUCTURED_POINTS with scalars, or as .nrrd or .mhd");
}

}  // namespace

std::unique_ptr<VolumeSource> open_vtk(const std::filesystem::path& path, const VolumeChoice&) {
  return with_itk(path, [&] {
    const auto offset = header_end(path);
    auto io = itk::VTKImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();
    const Grid grid = grid_of(*io, path);
    if (io->GetFileType() == itk::IOFileEnum::ASCII) {
      require_numbers(path, offset, std::uint64_t(grid.voxels()));
      return itk_source(io.GetPointer(), grid, path);
    }
    return stored_source(grid, {.file = path, .offset = offset, .big_endian = true, .type = grid.type});
  });
}

}  // namespace ringsplat::detail
