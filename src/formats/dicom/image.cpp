#include "formats/dicom/image.hpp"

#include <fmt/format.h>
#include <itkGDCMImageIO.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "formats/dicom/checks.hpp"
#include "formats/dicom/copy.hpp"
#include "formats/dicom/elements.hpp"
#include "formats/dicom/schema.hpp"
#include "formats/itk_image.hpp"

namespace ringsplat::detail {
namespace {

/// GDCM assumes a spacing of 1 when frames are not one even stack.
void require_frame_spacing(const DicomFile& file, const Grid& grid) {
  for (const auto groups : {dicom::shared_groups, dicom::frame_groups}) {
    const auto* const frame = file.elements.first_item(groups);
    const auto* const measures = frame == nullptr ? nullptr : frame->first_item(dicom::pixel_measures);
    if (measures == nullptr) continue;
    const auto spacing = dicom_numbers(file, *measures, dicom::pixel_spacing, dicom::pixel_measures);
    if (spacing.empty() || (spacing[1] == grid.spacing.x && spacing[0] == grid.spacing.y)) return;
    throw InputError(
        fmt::format("{}: its frames are not one stack of evenly spaced slices", file.path.string()),
        "give the frames as a series of files, one stack a folder");
  }
}

}  // namespace

struct DicomImage::Parts {
  std::filesystem::path path;
  MemoryFile copy;
  itk::GDCMImageIO::Pointer io;
  Grid grid;
  std::optional<DicomPlanes> planes;
  std::uint64_t stored_bytes = 0;  ///< before rescaling
};

DicomImage::DicomImage(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DicomImage::~DicomImage() = default;
DicomImage::DicomImage(DicomImage&&) noexcept = default;
const Grid& DicomImage::grid() const { return parts_->grid; }
const std::optional<DicomPlanes>& DicomImage::planes() const { return parts_->planes; }

std::optional<DicomImage> DicomImage::open(const std::filesystem::path& path) {
  const auto file = read_dicom_file(path);
  if (!file || !file->pixels) return {};
  const auto shape = check_dicom(*file);
  Parts parts{.path = path,
              .copy = copy_dicom(*file, shape),
              .io = itk::GDCMImageIO::New(),
              .grid = {},
              .planes = {},
              .stored_bytes = shape.bytes()};
  with_itk(path, [&] {
    parts.io->SetFileName(parts.copy.path().string());
    parts.io->ReadImageInformation();
    parts.grid = grid_of(*parts.io, path);
  });
  if (parts.grid.dims != glm::ivec3(shape.columns, shape.rows, shape.frames))
    throw InputError(
        fmt::format("{}: GDCM takes its {} x {} x {} pixels for {} x {} x {}", path.string(), shape.columns,
                    shape.rows, shape.frames, parts.grid.dims.x, parts.grid.dims.y, parts.grid.dims.z),
        "convert it to another format");
  if (shape.frames > 1) parts.planes = dicom_planes(*file, shape.frames);
  if (!parts.planes) require_frame_spacing(*file, parts.grid);
  return DicomImage(std::make_unique<Parts>(std::move(parts)));
}

void DicomImage::read(std::span<std::byte> out) {
  with_itk(parts_->path, [&] {
    if (parts_->stored_bytes <= parts_->grid.bytes()) return parts_->io->Read(out.data());
    // GDCM decodes into the given memory before it rescales to a narrower type.
    std::vector<std::byte> wide(parts_->stored_bytes);
    parts_->io->Read(wide.data());
    std::copy_n(wide.begin(), parts_->grid.bytes(), out.begin());
  });
}

}  // namespace ringsplat::detail
