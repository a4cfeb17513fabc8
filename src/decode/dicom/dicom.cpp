#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/dicom/image.hpp"
#include "decode/dicom/planes.hpp"
#include "decode/dicom/series.hpp"
#include "decode/readers.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat::detail {
namespace {

struct DicomFrame {
  std::filesystem::path file;
  Grid grid;  ///< its type after rescaling; several slices in a multi-frame file
  DicomPlane plane;
};

/// Makes `voxels` the mean of itself and `next`, of which `part` counts; whole numbers are rounded.
void mix(ScalarType type, std::span<const std::byte> next, double part, std::span<std::byte> voxels) {
  for_values(type, next, [&](auto others) {
    using T = typename decltype(others)::value_type;
    auto* value = reinterpret_cast<T*>(voxels.data());
    for (const T other : others) {
      const double mean = (1 - part) * double(*value) + part * double(other);
      *value++ = T(std::is_integral_v<T> ? std::nearbyint(mean) : mean);
    }
  });
}

/// Slices are images of files, or of the frames of an only file, or lie between two.
class DicomSource final : public LayeredSource {
 public:
  DicomSource(const Grid& grid, std::vector<DicomFrame> images, std::vector<DicomSlice> slices)
      : LayeredSource(grid, files_of(images, slices), {{"encoding", "DICOM"}}, images[0].grid.dims.z == 1),
        images_(std::move(images)),
        slices_(std::move(slices)) {}

 private:
  static std::size_t file_of(const std::vector<DicomFrame>& images, std::size_t image) {
    return images.size() == 1 ? 0 : image;
  }
  static std::vector<std::filesystem::path> files_of(const std::vector<DicomFrame>& images,
                                                     const std::vector<DicomSlice>& slices) {
    return mapped(slices, [&](const auto& slice) { return images[file_of(images, slice.image)].file; });
  }

  void read_layer(int z, int, std::span<std::byte> out) override {
    const DicomSlice& slice = slices_[std::size_t(z)];
    read_image(slice.image, out);
    if (slice.part == 0) return;
    std::vector<std::byte> next(out.size());
    read_image(slice.next, next);
    mix(grid().type, next, slice.part, out);
  }

  void read_image(std::size_t image, std::span<std::byte> out) {
    const auto number = file_of(images_, image);
    const Grid& stored = images_[number].grid;
    hold(number);
    const auto bytes = stored.slice_bytes(Axis::z);
    const auto voxels = std::span(held_).subspan((image - number) * bytes, bytes);
    // Slices with different rescaling may have different types; the volume is then float32.
    if (stored.type != grid().type) return apply({}, stored.type, voxels, grid().type, out);
    std::ranges::copy(voxels, out.begin());
  }

  /// GDCM decodes all frames of a file at once. Throws InputError when it is another file now.
  void hold(std::size_t number) {
    if (held_number_ == number) return;
    const DicomFrame& image = images_[number];
    held_number_.reset();
    held_.resize(image.grid.bytes());
    require_unchanged(image.file);
    auto opened = DicomImage::open(image.file);
    if (!opened || opened->grid().dims != image.grid.dims || opened->grid().type != image.grid.type)
      throw InputError(fmt::format("{} has changed while it was read", image.file.string()), "start again");
    opened->read(held_);
    require_unchanged(image.file);
    held_number_ = number;
  }

  std::vector<DicomFrame> images_;
  std::vector<DicomSlice> slices_;
  std::vector<std::byte> held_;  ///< voxels of the file that was read last
  std::optional<std::size_t> held_number_;
};

void require_alike(const std::vector<DicomFrame>& images) {
  constexpr double tolerated = 1e-2;
  for (const auto& s : images) {
    const auto &a = images.front().grid, &b = s.grid;
    if (a.dims.x != b.dims.x || a.dims.y != b.dims.y)
      refuse(s.file, "take slices of one size only", "it is {} x {}, the slices before it are {} x {}",
             b.dims.x, b.dims.y, a.dims.x, a.dims.y);
    if (b.dims.z != 1)
      refuse(s.file, "put a multi-frame file alone into its folder", "it holds {} frames", b.dims.z);
    if (glm::distance(a.direction[0], b.direction[0]) > tolerated ||
        glm::distance(a.direction[1], b.direction[1]) > tolerated)
      throw InputError(fmt::format("{} is turned against the slices before it (Image Orientation Patient)",
                                   s.file.string()),
                       "take slices of one orientation only");
  }
}

/// The images of a series that can be read; warns of the others. Throws the first complaint when none can.
std::vector<DicomFrame> images_of(const DicomSeries& series) {
  std::vector<DicomFrame> images;
  std::vector<InputError> problems;
  for (const auto& header : series.images) {
    progress(std::filesystem::file_size(header.file));
    try {
      if (const auto image = DicomImage::open(header.file))
        images.push_back({header.file, image->grid(), {image->grid().origin, header.times}});
    } catch (const InputError& error) {
      problems.push_back(error);
    }
  }
  if (images.empty() && !problems.empty()) throw InputError(problems.front());
  for (const auto& problem : problems) log_warning_once("left out: {}", problem.what());
  return images;
}

/// `times`: becomes the number of time points.
std::unique_ptr<VolumeSource> open_series(const DicomSeries& series, const VolumeChoice& choice,
                                          const std::filesystem::path& where, int& times) {
  auto images = images_of(series);
  require_alike(images);
  Grid grid = images.front().grid;
  for (const auto& image : images)
    if (image.grid.type != grid.type) grid.type = ScalarType::float32;
  const auto planes = mapped(images, [](const auto& image) { return image.plane; });
  const auto name_of = [&](std::size_t i) { return images[i].file.filename().string(); };
  auto stack = stack_planes(planes, choice.frame, where.string(), name_of, grid);
  times = stack.frames;
  return std::make_unique<DicomSource>(grid, std::move(images), std::move(stack.slices));
}

/// Where the frames have places of their own these count; GDCM takes frames for an even stack in their order.
std::unique_ptr<VolumeSource> open_frames(const DicomHeader& header, const VolumeChoice& choice, int& times) {
  const auto image = DicomImage::open(header.file);
  if (!image) throw InputError(fmt::format("{} has changed", header.file.string()), "start again");
  Grid grid = image->grid();
  std::vector<DicomSlice> slices(std::size_t(grid.dims.z));
  for (std::size_t z = 0; z < slices.size(); ++z) slices[z] = {.image = z, .next = z};
  if (const auto& planes = image->planes()) {
    grid.spacing = {planes->spacing.x, planes->spacing.y, grid.spacing.z};
    grid.direction[0] = planes->row;
    grid.direction[1] = planes->column;
    const auto name_of = [](std::size_t i) { return fmt::format("frame {}", i); };
    auto stack = stack_planes(planes->planes, choice.frame, header.file.string(), name_of, grid);
    slices = std::move(stack.slices);
    times = stack.frames;
  } else if (grid.spacing.z < 0) {  // the frames go against the normal
    grid.spacing.z = -grid.spacing.z;
    grid.direction[2] = -grid.direction[2];
  }
  return std::make_unique<DicomSource>(grid, std::vector<DicomFrame>{{header.file, image->grid(), {}}},
                                       std::move(slices));
}

VolumeNotes notes_of(const DicomSeries& series, int frames) {
  VolumeNotes notes{.world = World::patient, .unit = "mm", .frames = frames};
  notes.modality = series.modality.empty() ? "OT" : excerpt(series.modality);
  for (char& c : notes.modality) c = char(std::toupper(static_cast<unsigned char>(c)));
  const auto& type = series.rescale_type;
  if (type == "HU" || (notes.modality == "CT" && (type.empty() || type == "US"))) notes.quantity = "HU";
  return notes;
}

}  // namespace

std::unique_ptr<VolumeSource> read_dicom(const std::filesystem::path& path, const VolumeChoice& choice) {
  const bool folder = std::filesystem::is_directory(path);
  const auto all = folder ? find_series(path, true) : find_series_of(path);
  if (all.empty()) {
    if (folder) refuse_without_images(path);
    throw InputError(fmt::format("{} holds no DICOM image", path.string()), "give a file that has pixels");
  }
  const auto& series = choose_series(all, choice.series, path.string());
  const bool multi_frame = series.images.size() == 1 && series.images.front().frames > 1;
  int times = 1;
  auto source = multi_frame ? open_frames(series.images.front(), choice, times)
                            : open_series(series, choice, path, times);
  auto notes = notes_of(series, times);
  notes.series = describe(all);
  return with_notes(std::move(source), std::move(notes));
}

}  // namespace ringsplat::detail
