#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ringsplat/base/log.hpp"
#include "volume/dicom_elements.hpp"
#include "volume/formats.hpp"
#include "volume/input_file.hpp"
#include "volume/itk_image.hpp"
#include "volume/limits.hpp"
#include "volume/volume_files.hpp"

namespace ringsplat::detail {
namespace {

struct DicomSlice {
  std::filesystem::path file;
  Grid grid;  ///< one slice, its type after rescaling
  std::string series;
  int number = 0;  ///< Instance Number
};

itk::GDCMImageIO::Pointer read_information(const std::filesystem::path& file) {
  auto io = itk::GDCMImageIO::New();
  io->SetFileName(file.string());
  io->ReadImageInformation();
  return io;
}

/// The text of an element named "gggg|eeee", without its padding; empty when there is none.
std::string text_of(const itk::GDCMImageIO& io, const char* tag) {
  std::string text;
  itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), tag, text);
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

/// What GDCM answers with an assertion or with zeros is refused before it sees it.
void require_sound(const std::filesystem::path& file, const DicomElements& elements) {
  if (!elements.followed) return;
  if (elements.samples != 1)
    throw InputError(fmt::format("{}: {} values per pixel", file.string(), elements.samples),
                     "only scalar volumes can be rendered: take a series of grey images");
  if (elements.rows < 1 || elements.columns < 1)
    throw InputError(
        fmt::format("{}: {} rows and {} columns", file.string(), elements.rows, elements.columns),
        "take an image that has pixels");
  if (elements.bits_allocated != 8 && elements.bits_allocated != 16 && elements.bits_allocated != 32)
    throw InputError(fmt::format("{}: {} bits allocated per pixel", file.string(), elements.bits_allocated),
                     "convert it to 8, 16 or 32 bits");
  const auto bytes = std::uint64_t(elements.rows) * std::uint64_t(elements.columns) *
                     std::uint64_t(elements.bits_allocated / 8);
  if (elements.pixel_bytes)
    require_bytes(file, *elements.pixel_bytes, 0, bytes);
  else
    require_compressed_bytes(file, InputFile(file).size(), bytes, any_best_ratio);
}

DicomSlice describe(const std::filesystem::path& file, const DicomElements& elements) {
  require_sound(file, elements);
  const auto io = read_information(file);
  DicomSlice slice{file, grid_of(*io, file), text_of(*io, "0020|000e"),
                   std::atoi(text_of(*io, "0020|0013").c_str())};
  // The frames of a multi-frame file are in its grid only.
  if (elements.pixel_bytes)
    require_bytes(file, *elements.pixel_bytes, 0,
                  std::uint64_t(slice.grid.voxels()) * std::uint64_t(elements.bits_allocated / 8));
  return slice;
}

/// Nothing for a file that is no DICOM image: notes, a DICOMDIR, a report.
std::optional<DicomSlice> try_describe(const std::filesystem::path& file) {
  const auto elements = follow_dicom_elements(file);
  if (!elements || !elements->has_pixels) return {};
  return describe(file, *elements);
}

template <class From, class To>
void convert(const std::vector<std::byte>& in, std::span<std::byte> out) {
  const auto* values = reinterpret_cast<const From*>(in.data());
  auto* results = reinterpret_cast<To*>(out.data());
  for (std::size_t i = 0; i < in.size() / sizeof(From); ++i) results[i] = To(values[i]);
}

/// Each slice is a file of its own, so every process reads its own.
class DicomSource final : public VolumeSource {
 public:
  DicomSource(const Grid& grid, std::vector<DicomSlice> slices)
      : grid_(grid), slices_(std::move(slices)), files_(files_of(slices_)) {}
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  Facts facts() const override {
    Facts facts = files_.facts();
    facts.insert(facts.begin(), {"encoding", "DICOM"});
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int i = 0; i < count; ++i)
      read_slice(slices_[std::size_t(first + i)], out.subspan(std::size_t(i) * bytes, bytes));
  }

 private:
  static std::vector<std::filesystem::path> files_of(const std::vector<DicomSlice>& slices) {
    std::vector<std::filesystem::path> files;
    for (const DicomSlice& slice : slices) files.push_back(slice.file);
    return files;
  }

  void read_slice(const DicomSlice& slice, std::span<std::byte> out) {
    // GDCM fills as many bytes as the file says now, whatever room there is.
    files_.require_unchanged(slice.file);
    const bool same = slice.grid.type == grid_.type;
    std::vector<std::byte> raw(same ? 0 : slice.grid.bytes());
    with_itk(slice.file, [&] { read_information(slice.file)->Read(same ? out.data() : raw.data()); });
    files_.require_unchanged(slice.file);
    if (same) return;
    // Where slices differ in their rescaling, types differ too and the volume's is float32.
    visit_type(slice.grid.type, [&](auto type) { convert<decltype(type), float>(raw, out); });
  }

  Grid grid_;
  std::vector<DicomSlice> slices_;
  VolumeFiles files_;
};

void require_alike(const std::vector<DicomSlice>& slices) {
  for (const auto& s : slices) {
    const auto &a = slices.front().grid, &b = s.grid;
    if (a.dims.x != b.dims.x || a.dims.y != b.dims.y)
      throw InputError(fmt::format("{} is {} x {}, the slices before it are {} x {}", s.file.string(),
                                   b.dims.x, b.dims.y, a.dims.x, a.dims.y),
                       "take slices of one size only");
    if (b.dims.z != 1)
      throw InputError(fmt::format("{} holds {} frames", s.file.string(), b.dims.z),
                       "put a multi-frame file alone into its folder");
  }
}

/// The third axis comes from the slices' positions: a tilted gantry shears the lattice.
Grid stack_grid(const std::vector<DicomSlice>& slices, const std::filesystem::path& where) {
  Grid grid = slices.front().grid;
  for (const auto& s : slices)
    if (s.grid.type != grid.type) grid.type = ScalarType::float32;
  grid.dims.z = int(slices.size());
  if (slices.size() == 1) return grid;
  const auto step = (slices.back().grid.origin - grid.origin) / double(slices.size() - 1);
  grid.spacing.z = glm::length(step);
  if (!(grid.spacing.z > 0))
    throw InputError(
        fmt::format("{}: the slices have no different positions (Image Position Patient)", where.string()),
        "the folder may hold several series: give one file of the right one");
  grid.direction[2] = step / grid.spacing.z;
  check(grid, where.string());
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const double off = glm::length(slices[i].grid.origin - (slices.front().grid.origin + double(i) * step));
    constexpr double tolerated = 0.1;  // of the slice distance
    if (off <= tolerated * grid.spacing.z) continue;
    log_warning_once("{}: the slices are not evenly spaced, one may be missing near {}", where.string(),
                     slices[i].file.filename().string());
    break;
  }
  return grid;
}

using Series = std::map<std::string, std::vector<DicomSlice>>;

Series series_in(const std::filesystem::path& folder) {
  Series series;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    if (auto slice = try_describe(entry.path())) series[slice->series].push_back(std::move(*slice));
  }
  return series;
}

/// In space along the slices' normal; by number where they have no positions.
void sort_slices(std::vector<DicomSlice>& slices) {
  const auto normal = glm::cross(slices.front().grid.direction[0], slices.front().grid.direction[1]);
  const auto key = [&](const DicomSlice& s) {
    return std::tuple(glm::dot(normal, s.grid.origin), s.number, s.file);
  };
  std::sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
}

/// Of a folder's several series the longest, of a file its own.
std::vector<DicomSlice> choose_series(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) {
    const auto slice = try_describe(path);
    if (!slice) return {};
    if (slice->grid.dims.z > 1) return {*slice};
    return series_in(std::filesystem::absolute(path).parent_path())[slice->series];
  }
  auto series = series_in(path);
  if (series.empty()) return {};
  auto longest = std::max_element(series.begin(), series.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  if (series.size() > 1)
    log_warning_once(
        "{} holds {} DICOM series, taken is the longest ({} slices); name a file of another to take that",
        path.string(), series.size(), longest->second.size());
  return std::move(longest->second);
}

}  // namespace

std::unique_ptr<VolumeSource> open_dicom(const std::filesystem::path& path) {
  return with_itk(path, [&]() -> std::unique_ptr<VolumeSource> {
    auto slices = choose_series(path);
    if (slices.empty())
      throw InputError(fmt::format("{} holds no DICOM or TIFF images", path.string()),
                       "give a folder with one series or stack, or a volume file");
    if (slices.size() == 1 && slices.front().grid.dims.z > 1)
      return itk_source(read_information(slices.front().file).GetPointer(), slices.front().grid,
                        slices.front().file);
    sort_slices(slices);
    require_alike(slices);
    const Grid grid = stack_grid(slices, path);
    return std::make_unique<DicomSource>(grid, std::move(slices));
  });
}

}  // namespace ringsplat::detail
