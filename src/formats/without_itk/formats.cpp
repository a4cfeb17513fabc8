#include "formats/formats.hpp"
#include "formats/left_out.hpp"

/// A build without ITK.
namespace ringsplat::detail {

std::unique_ptr<VolumeSource> open_vtk(const std::filesystem::path& path, const VolumeChoice&) {
  refuse_left_out(path, "legacy VTK", "ITK");
}

}  // namespace ringsplat::detail
