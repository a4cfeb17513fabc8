#include <itkVTKImageIO.h>

#include <fstream>
#include <utility>

#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/itk_image.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// The byte after the last header line: COLOR_SCALARS, VECTORS or SCALARS, and LOOKUP_TABLE when it follows
/// (VTK file formats, "Simple legacy formats").
std::uint64_t header_end(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  constexpr int longest_header = 100;  // lines; ITK reads a dozen
  for (int i = 0; i < longest_header && std::getline(stream, line); ++i) {
    if (i == 0 && line.rfind("# vtk DataFile", 0) != 0) break;
    const auto key = lower_case(line).substr(0, line.find(' '));
    if (key != "scalars" && key != "color_scalars" && key != "vectors") continue;
    const auto end = stream.tellg();
    if (std::getline(stream, line) && lower_case(line).rfind("lookup_table", 0) == 0)
      return std::uint64_t(stream.tellg());
    return std::uint64_t(end);
  }
  throw InputError(path.string() + " is not a legacy VTK file with SCALARS",
                   "write it as STRUCTURED_POINTS with scalars, or as .nrrd or .mhd");
}

}  // namespace

std::unique_ptr<VolumeSource> open_vtk(const std::filesystem::path& path, const VolumeChoice& choice) {
  return with_itk(path, [&] {
    const auto offset = header_end(path);
    auto io = itk::VTKImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();
    Grid grid = lattice_of(*io, path);
    grid.type = scalar_type_of(*io, path);
    const auto components = int(io->GetNumberOfComponents());
    const auto wide = interleaved_grid(grid, components, path.string());
    std::unique_ptr<VolumeSource> source;
    if (io->GetFileType() == itk::IOFileEnum::ASCII) {
      require_numbers(path, offset, std::uint64_t(wide.voxels()));
      source = itk_source(io.GetPointer(), wide, path);
    } else {
      source = stored_source(wide, {.file = path, .offset = offset, .big_endian = true, .type = grid.type});
    }
    if (components == 1) return source;
    const auto taken =
        choose_channel(choice.channel, components, are_colours(grid.type, components), path.string());
    return with_notes(channel_source(std::move(source), grid, components, taken), {.channels = components});
  });
}

}  // namespace ringsplat::detail
