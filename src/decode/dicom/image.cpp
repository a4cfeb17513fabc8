#include "decode/dicom/image.hpp"

#include <gdcmImageHelper.h>
#include <gdcmMediaStorage.h>
#include <gdcmTrace.h>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "base/byte_order.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

using namespace std::string_view_literals;

constexpr const char *again = "copy or write the file again",
                     *elsewhere = "check the file with another viewer";

std::uint32_t little32(std::string_view bytes, std::size_t at) {
  return BinaryFields(std::as_bytes(std::span(bytes)), false).at<std::uint32_t>(at);
}

/// The frames' bytes (PS3.5, annex A.4): of fragments the first is a table of where the frames begin.
std::vector<std::string> frames_of(const DicomFile& file, const DicomShape& shape) {
  const auto count = std::size_t(shape.frames);
  const auto& all = file.pixels->fragments;
  if (all.size() < 2) refuse(file.path, again, "its pixels have no fragments");
  const bool has_table = all[0].size() == 4 * count;
  const bool one_each = all.size() == count + 1;
  std::vector<std::string> frames;
  for (auto fragment = all.begin() + 1; fragment != all.end(); ++fragment) {
    const auto next = frames.size();
    const bool begins =
        one_each || (count == 1 && next == 0) ||
        (next < count && has_table && fragment->data() - all[1].data() == little32(all[0], 4 * next));
    if (begins) frames.emplace_back();
    if (frames.empty()) break;
    frames.back() += *fragment;
  }
  if (frames.size() != count)
    refuse(file.path, again, "{} fragments cannot be told to be {} frames", all.size() - 1, count);
  return frames;
}

/// GDCM fills what a frame lacks, and reads run lengths of other pixels.
void require_whole(const DicomFile& file, const DicomShape& shape, std::string& frame) {
  if (shape.codec == DicomCodec::rle) {
    if (frame.size() < 4 || little32(frame, 0) != shape.bytes_per_voxel())
      refuse(file.path, again, "a frame of run lengths is not of {} segments", shape.bytes_per_voxel());
    return;
  }
  const auto end = frame.rfind("\xFF\xD9"sv);
  if (end == std::string::npos) refuse(file.path, again, "a compressed frame is cut short or damaged");
  frame.resize(end + 2);
}

/// A JPEG frame without comments and applications' segments, on which GDCM stumbles, and fill bytes.
std::string without_notes(const DicomFile& file, const std::string& frame) {
  constexpr unsigned scan = 0xDA, first_application = 0xE0, last_application = 0xEF, comment = 0xFE;
  std::string kept = frame.substr(0, 2);
  for (std::size_t at = 2;;) {
    while (at + 1 < frame.size() && frame[at] == '\xFF' && frame[at + 1] == '\xFF') ++at;
    if (at + 4 > frame.size() || frame[at] != '\xFF')
      refuse(file.path, again, "a compressed frame is cut short or damaged");
    const auto byte = [&](std::size_t i) { return unsigned(static_cast<unsigned char>(frame[at + i])); };
    const unsigned marker = byte(1);
    if (marker == scan) return kept + frame.substr(at);
    const std::size_t length = 2 + 256 * byte(2) + byte(3);
    if (marker != comment && (marker < first_application || marker > last_application))
      kept += frame.substr(at, length);
    at += length;
  }
}

/// A fragment of these bytes.
std::string item_of(const std::string& bytes) {
  std::string item("\xFE\xFF\x00\xE0", 4);
  for (int i = 0; i < 4; ++i) item += char(bytes.size() >> (8 * i));
  return item + bytes;
}

/// The bytes of a file that GDCM would not read, or not rightly, as it does: with one fragment a frame,
/// without segments of JPEG that decide no pixel, without what media pad it with. Nothing for other files.
/// Throws InputError for frames that cannot be told apart, are cut short, or not as the header says.
std::optional<std::string> bytes_for_gdcm(const DicomFile& file, const DicomShape& shape) {
  if (shape.codec == DicomCodec::none) {
    if (file.deflated() || file.data.size() == std::filesystem::file_size(file.path)) return {};
    return std::string(file.data);
  }
  std::string bytes = std::string(file.data.substr(0, file.pixels->begin)) + item_of({});
  for (auto& frame : frames_of(file, shape)) {
    require_whole(file, shape, frame);
    if (shape.codec == DicomCodec::jpeg) frame = without_notes(file, frame);
    if (frame.size() % 2 != 0) frame += '\0';
    bytes += item_of(frame);
  }
  bytes += "\xFE\xFF\xDD\xE0\0\0\0\0"sv;
  return bytes.append(file.data.substr(file.pixels->end));
}

/// Of these kinds GDCM does not say how far pixels are apart.
bool lacks_spacing(const gdcm::File& file) {
  using Kind = gdcm::MediaStorage;
  constexpr Kind::MSType kinds[] = {Kind::HardcopyGrayscaleImageStorage,
                                    Kind::GEPrivate3DModelStorage,
                                    Kind::Philips3D,
                                    Kind::VideoEndoscopicImageStorage,
                                    Kind::UltrasoundMultiFrameImageStorage,
                                    Kind::UltrasoundImageStorage,
                                    Kind::UltrasoundImageStorageRetired,
                                    Kind::UltrasoundMultiFrameImageStorageRetired};
  Kind kind;
  kind.SetFromFile(file);
  return std::find(std::begin(kinds), std::end(kinds), kind) != std::end(kinds);
}

glm::dvec3 spacing_of(const DicomFile& file, const gdcm::ImageReader& reader) {
  if (lacks_spacing(reader.GetFile())) {
    const auto said = checked_numbers(file, file.elements, dicom::pixel_spacing);
    return said.empty() ? glm::dvec3(1) : glm::dvec3(said[1], said[0], 1);
  }
  return glm::make_vec3(reader.GetImage().GetSpacing());
}

/// The lattice without the type. Its axes become orthogonal.
Grid lattice_of(const DicomFile& file, const gdcm::ImageReader& reader) {
  const gdcm::Image& image = reader.GetImage();
  const unsigned* const dims = image.GetDimensions();
  const double *const origin = image.GetOrigin(), *const axes = image.GetDirectionCosines();
  Grid grid;
  grid.dims = {int(dims[0]), int(dims[1]), image.GetNumberOfDimensions() == 3 ? int(dims[2]) : 1};
  grid.spacing = spacing_of(file, reader);
  grid.origin = glm::make_vec3(origin);
  const glm::dvec3 row = glm::make_vec3(axes), column = glm::make_vec3(axes + 3);
  grid.direction[2] = glm::normalize(glm::cross(row, column));
  grid.direction[0] = glm::normalize(glm::cross(column, grid.direction[2]));
  grid.direction[1] = glm::cross(grid.direction[2], grid.direction[0]);
  return grid;
}

/// GDCM assumes a spacing of 1 when frames are not one even stack.
void require_frame_spacing(const DicomFile& file, const Grid& grid) {
  for (const auto& groups : {dicom::shared_groups, dicom::frame_groups}) {
    const auto* const frame = file.elements.first_item(groups);
    const auto* const measures = frame ? frame->first_item(dicom::pixel_measures) : nullptr;
    if (!measures) continue;
    const auto spacing = checked_numbers(file, *measures, dicom::pixel_spacing);
    if (spacing.empty() || (spacing[1] == grid.spacing.x && spacing[0] == grid.spacing.y)) return;
    refuse(file.path, "give the frames as a series of files, one stack a folder",
           "its frames are not one stack of evenly spaced slices");
  }
}

/// GDCM may read pixels of a frame's own header rather than of the file's.
void require_shape(const DicomFile& file, const DicomShape& shape, const gdcm::Image& image,
                   const Grid& grid) {
  const auto bits = image.GetPixelFormat().GetBitsAllocated();
  if (grid.dims == glm::ivec3(shape.columns, shape.rows, shape.frames) && bits == shape.bits_allocated &&
      image.GetBufferLength() == shape.bytes())
    return;
  refuse(file.path, "convert it to another format",
         "GDCM takes its {} x {} x {} pixels of {} bits for {} x {} x {} of {}", shape.columns, shape.rows,
         shape.frames, shape.bits_allocated, grid.dims.x, grid.dims.y, grid.dims.z, bits);
}

}  // namespace

std::unique_ptr<DicomImage> DicomImage::open(const std::filesystem::path& path) {
  const auto file = read_dicom_file(path);
  if (!file || !file->pixels) return {};
  auto opened = std::make_unique<DicomImage>();
  opened->path_ = path;
  auto& shape = opened->shape_ = check_dicom(*file);
  auto& reader = opened->reader_;
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::ImageHelper::SetForceRescaleInterceptSlope(true);
  std::istringstream changed;
  if (auto bytes = bytes_for_gdcm(*file, shape)) {
    changed.str(std::move(*bytes));
    reader.SetStream(changed);
  } else {
    reader.SetFileName(path.c_str());
  }
  if (!reader.Read()) refuse(path, elsewhere, "GDCM does not understand it");
  gdcm::Image& image = reader.GetImage();
  Grid& grid = opened->grid_ = lattice_of(*file, reader);
  require_shape(*file, shape, image, grid);
  opened->rescale_ = {image.GetSlope(), image.GetIntercept()};
  grid.type = rescaled_type(*file, shape, opened->rescale_);
  check_lattice(grid, path.string());
  // What may have become more bits that count than the file says.
  gdcm::PixelFormat format = image.GetPixelFormat();
  format.SetBitsStored(static_cast<unsigned short>(shape.bits_stored));
  format.SetHighBit(static_cast<unsigned short>(shape.high_bit));
  image.SetPixelFormat(format);
  if (shape.frames > 1) opened->planes_ = dicom_planes(*file, shape.frames);
  if (!opened->planes_) require_frame_spacing(*file, grid);
  return opened;
}

void DicomImage::read(std::span<std::byte> out) {
  const auto decode = [this](std::span<std::byte> pixels) {
    if (!reader_.GetImage().GetBuffer(reinterpret_cast<char*>(pixels.data())))
      refuse(path_, elsewhere, "its pixels cannot be decoded");
  };
  if (rescale_.slope == 1 && rescale_.intercept == 0) return decode(out);
  std::vector<std::byte> stored(shape_.bytes());
  decode(stored);
  apply(rescale_, stored_type(shape_), stored, grid_.type, out);
}

}  // namespace ringsplat::detail
