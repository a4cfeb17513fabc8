#include "decode/dicom/image.hpp"

#include <fmt/format.h>
#include <gdcmImageHelper.h>
#include <gdcmImageReader.h>
#include <gdcmMediaStorage.h>
#include <gdcmTrace.h>

#include <glm/geometric.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "decode/dicom/checks.hpp"
#include "decode/dicom/elements.hpp"
#include "decode/dicom/frames.hpp"
#include "decode/dicom/schema.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("cannot read {}: {}", path.string(), what),
                   "check the file with another viewer");
}

/// Of these kinds GDCM does not say how far pixels are apart.
bool lacks_spacing(const gdcm::File& file) {
  gdcm::MediaStorage kind;
  kind.SetFromFile(file);
  switch (gdcm::MediaStorage::MSType(kind)) {
    case gdcm::MediaStorage::HardcopyGrayscaleImageStorage:
    case gdcm::MediaStorage::GEPrivate3DModelStorage:
    case gdcm::MediaStorage::Philips3D:
    case gdcm::MediaStorage::VideoEndoscopicImageStorage:
    case gdcm::MediaStorage::UltrasoundMultiFrameImageStorage:
    case gdcm::MediaStorage::UltrasoundImageStorage:
    case gdcm::MediaStorage::UltrasoundImageStorageRetired:
    case gdcm::MediaStorage::UltrasoundMultiFrameImageStorageRetired:
      return true;
    default:
      return false;
  }
}

glm::dvec3 spacing_of(const DicomFile& file, const gdcm::ImageReader& reader) {
  if (lacks_spacing(reader.GetFile())) {
    const auto said = dicom_numbers(file, file.elements, dicom::pixel_spacing);
    return said.empty() ? glm::dvec3(1) : glm::dvec3(said[1], said[0], 1);
  }
  const double* const spacing = reader.GetImage().GetSpacing();
  return {spacing[0], spacing[1], spacing[2]};
}

/// The lattice without the type. Its axes become orthogonal.
Grid lattice_of(const DicomFile& file, const gdcm::ImageReader& reader) {
  const gdcm::Image& image = reader.GetImage();
  const unsigned* const dims = image.GetDimensions();
  const double *const origin = image.GetOrigin(), *const axes = image.GetDirectionCosines();
  Grid grid;
  grid.dims = {int(dims[0]), int(dims[1]), image.GetNumberOfDimensions() == 3 ? int(dims[2]) : 1};
  grid.spacing = spacing_of(file, reader);
  grid.origin = {origin[0], origin[1], origin[2]};
  const glm::dvec3 row(axes[0], axes[1], axes[2]), column(axes[3], axes[4], axes[5]);
  grid.direction[2] = glm::normalize(glm::cross(row, column));
  grid.direction[0] = glm::normalize(glm::cross(column, grid.direction[2]));
  grid.direction[1] = glm::cross(grid.direction[2], grid.direction[0]);
  return grid;
}

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

/// GDCM may read pixels of a frame's own header rather than of the file's.
void require_shape(const DicomFile& file, const DicomShape& shape, const gdcm::Image& image,
                   const Grid& grid) {
  const auto bits = image.GetPixelFormat().GetBitsAllocated();
  if (grid.dims == glm::ivec3(shape.columns, shape.rows, shape.frames) && bits == shape.bits_allocated &&
      image.GetBufferLength() == shape.bytes())
    return;
  throw InputError(fmt::format("{}: GDCM takes its {} x {} x {} pixels of {} bits for {} x {} x {} of {}",
                               file.path.string(), shape.columns, shape.rows, shape.frames,
                               shape.bits_allocated, grid.dims.x, grid.dims.y, grid.dims.z, bits),
                   "convert it to another format");
}

}  // namespace

struct DicomImage::Parts {
  std::filesystem::path path;
  gdcm::ImageReader reader = {};
  DicomShape shape = {};
  Grid grid = {};
  Rescale rescale = {};
  std::optional<DicomPlanes> planes = {};
};

DicomImage::DicomImage(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DicomImage::~DicomImage() = default;
DicomImage::DicomImage(DicomImage&&) noexcept = default;
const Grid& DicomImage::grid() const { return parts_->grid; }
const std::optional<DicomPlanes>& DicomImage::planes() const { return parts_->planes; }

std::optional<DicomImage> DicomImage::open(const std::filesystem::path& path) {
  const auto file = read_dicom_file(path);
  if (!file || !file->pixels) return {};
  auto parts = std::make_unique<Parts>();
  parts->path = path;
  parts->shape = check_dicom(*file);
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::ImageHelper::SetForceRescaleInterceptSlope(true);
  std::istringstream changed;
  if (auto bytes = bytes_for_gdcm(*file, parts->shape)) {
    changed.str(std::move(*bytes));
    parts->reader.SetStream(changed);
  } else {
    parts->reader.SetFileName(path.c_str());
  }
  if (!parts->reader.Read()) fail(path, "GDCM does not understand it");
  gdcm::Image& image = parts->reader.GetImage();
  parts->grid = lattice_of(*file, parts->reader);
  require_shape(*file, parts->shape, image, parts->grid);
  parts->rescale = {image.GetSlope(), image.GetIntercept()};
  parts->grid.type = rescaled_type(*file, parts->shape, parts->rescale);
  check_lattice(parts->grid, path.string());
  // What may have become more bits that count than the file says.
  gdcm::PixelFormat format = image.GetPixelFormat();
  format.SetBitsStored(static_cast<unsigned short>(parts->shape.bits_stored));
  format.SetHighBit(static_cast<unsigned short>(parts->shape.high_bit));
  image.SetPixelFormat(format);
  if (parts->shape.frames > 1) parts->planes = dicom_planes(*file, parts->shape.frames);
  if (!parts->planes) require_frame_spacing(*file, parts->grid);
  return DicomImage(std::move(parts));
}

void DicomImage::read(std::span<std::byte> out) {
  const auto decode = [this](std::span<std::byte> pixels) {
    if (!parts_->reader.GetImage().GetBuffer(reinterpret_cast<char*>(pixels.data())))
      fail(parts_->path, "its pixels cannot be decoded");
  };
  const Rescale& rescale = parts_->rescale;
  if (rescale.slope == 1 && rescale.intercept == 0) return decode(out);
  std::vector<std::byte> stored(parts_->shape.bytes());
  decode(stored);
  apply(rescale, stored_type(parts_->shape), stored, parts_->grid.type, out);
}

}  // namespace ringsplat::detail
