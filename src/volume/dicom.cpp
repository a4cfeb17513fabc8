#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/dicom_elements.hpp"
#include "volume/dicom_image.hpp"
#include "volume/formats.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/text.hpp"
#include "volume/volume_files.hpp"
#include "volume/whole_source.hpp"

namespace ringsplat::detail {
namespace {

struct DicomSlice {
  std::filesystem::path file;
  Grid grid;  ///< its type after rescaling; several slices in a multi-frame file
  std::string series;
  int number = 0;  ///< Instance Number
};

std::optional<DicomSlice> try_describe(const std::filesystem::path& file) {
  const auto image = DicomImage::open(file);
  if (!image) return {};
  return DicomSlice{file, image->grid(), image->series(), image->number()};
}

/// Reads a file that was described before. Throws InputError when it is another one now.
void read_image(const DicomSlice& slice, std::span<std::byte> out) {
  auto image = DicomImage::open(slice.file);
  if (!image || image->grid().dims != slice.grid.dims || image->grid().type != slice.grid.type)
    throw InputError(fmt::format("{} has changed while it was read", slice.file.string()), "start again");
  image->read(out);
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
    files_.require_unchanged(slice.file);
    const bool same = slice.grid.type == grid_.type;
    std::vector<std::byte> raw(same ? 0 : slice.grid.bytes());
    read_image(slice, same ? out : raw);
    files_.require_unchanged(slice.file);
    if (same) return;
    // Slices with different rescaling may have different types; the volume is then float32.
    visit_type(slice.grid.type, [&](auto type) { convert<decltype(type), float>(raw, out); });
  }

  Grid grid_;
  std::vector<DicomSlice> slices_;
  VolumeFiles files_;
};

/// The frames of one file. GDCM decodes all at once.
class MultiFrameSource final : public WholeSource {
 public:
  explicit MultiFrameSource(DicomSlice frames) : WholeSource(frames.grid), frames_(std::move(frames)) {}

 private:
  void decode(std::span<std::byte> voxels) override { read_image(frames_, voxels); }

  DicomSlice frames_;
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

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void tell(const std::vector<InputError>& problems, const std::filesystem::path& folder) {
  constexpr std::size_t most = 5;
  for (std::size_t i = 0; i < std::min(problems.size(), most); ++i)
    log_warning_once("left out: {}", problems[i].what());
  if (problems.size() > most)
    log_warning_once("left out: {} more files of {} that cannot be read", problems.size() - most,
                     folder.string());
}

/// The readable files of a folder; warns of the others. Throws the first complaint when none can be read.
Series series_in(const std::filesystem::path& folder) {
  Series series;
  std::vector<InputError> problems;
  for (const auto& file : files_in(folder)) {
    try {
      if (auto slice = try_describe(file))
        series[slice->series].push_back(std::move(*slice));
      else if (lower_case(file.extension().string()) == ".dcm" && !is_dicom(file))
        throw InputError(fmt::format("{} is no DICOM file", file.string()), "copy the file again");
    } catch (const InputError& error) {
      problems.push_back(error);
    }
  }
  if (series.empty() && !problems.empty()) throw InputError(problems.front());
  tell(problems, folder);
  return series;
}

/// Sorts along the slices' normal, or by number when they have no positions.
void sort_slices(std::vector<DicomSlice>& slices) {
  const auto normal = glm::cross(slices.front().grid.direction[0], slices.front().grid.direction[1]);
  const auto key = [&](const DicomSlice& s) {
    return std::tuple(glm::dot(normal, s.grid.origin), s.number, s.file);
  };
  std::sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
}

/// The longest series of a folder, or the series of a file.
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

std::unique_ptr<VolumeSource> open_dicom(const std::filesystem::path& path, const VolumeChoice&) {
  const auto noted = [](std::unique_ptr<VolumeSource> source) {
    return with_notes(std::move(source), {.world = World::patient, .unit = "mm", .modality = "OT"});
  };
  auto slices = choose_series(path);
  if (slices.empty())
    throw InputError(fmt::format("{} holds no DICOM or TIFF images", path.string()),
                     "give a folder with one series or stack, or a volume file");
  if (slices.size() == 1 && slices.front().grid.dims.z > 1)
    return noted(std::make_unique<MultiFrameSource>(std::move(slices.front())));
  sort_slices(slices);
  require_alike(slices);
  const Grid grid = stack_grid(slices, path);
  return noted(std::make_unique<DicomSource>(grid, std::move(slices)));
}

}  // namespace ringsplat::detail
