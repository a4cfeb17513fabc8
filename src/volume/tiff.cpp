#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "ringsplat/images/image_file.hpp"
#include "volume/formats.hpp"
#include "volume/input_file.hpp"
#include "volume/limits.hpp"
#include "volume/text.hpp"
#include "volume/tiff_description.hpp"
#include "volume/tiff_pages.hpp"
#include "volume/volume_files.hpp"

namespace ringsplat::detail {
namespace {

/// One slice: a page of a file.
struct Page {
  std::filesystem::path file;
  int index = 0;
};

struct PageShape {
  int width, height;
  ScalarType type;
  bool operator==(const PageShape&) const = default;
};

std::unique_ptr<ImageFile> open_image(const std::filesystem::path& path) {
  const InputFile readable(path);
  auto [file, problem] = open_image_file(path);
  if (!file)
    throw InputError(fmt::format("{} is not a readable TIFF file: {}", path.string(), one_line(problem)),
                     "check the file with another viewer");
  return std::move(file);
}

/// Which sample type gives which scalar type. Samples are read as the first one listed for their scalar type.
constexpr std::pair<ScalarType, SampleType> sample_types[] = {
    {ScalarType::int8, SampleType::int8},       {ScalarType::uint8, SampleType::uint8},
    {ScalarType::int16, SampleType::int16},     {ScalarType::uint16, SampleType::uint16},
    {ScalarType::int32, SampleType::int32},     {ScalarType::uint32, SampleType::uint32},
    {ScalarType::float32, SampleType::float32}, {ScalarType::float32, SampleType::float16},
    {ScalarType::float64, SampleType::float64}};

ScalarType scalar_type_of(const ImageShape& shape, const std::filesystem::path& path) {
  for (const auto& [scalar, sample] : sample_types)
    if (sample == shape.type) return scalar;
  throw InputError(fmt::format("{}: pixels of type {} cannot be rendered", path.string(), shape.type_name),
                   "convert them to at most 32 bits or float first");
}

SampleType sample_type_of(ScalarType type) {
  return std::find_if(std::begin(sample_types), std::end(sample_types),
                      [type](const auto& pair) { return pair.first == type; })
      ->second;
}

PageShape shape_of(const ImageShape& shape, const std::filesystem::path& path) {
  if (shape.channels != 1)
    throw InputError(fmt::format("{}: {} channels per pixel", path.string(), shape.channels),
                     "only scalar volumes can be rendered: convert the pages to grey");
  if (shape.depth > 1)
    throw InputError(fmt::format("{}: {} planes in one page", path.string(), shape.depth),
                     "write one slice a page");
  return {shape.width, shape.height, scalar_type_of(shape, path)};
}

/// Adds the pages of one file, which must have the shape of those before it.
void add_pages(const std::filesystem::path& path, std::vector<Page>& pages, std::vector<PageShape>& shape) {
  const auto chained = count_tiff_pages(path);
  const auto image = open_image(path);
  std::uint64_t bytes = 0;
  bool compressed = false;
  int index = 0;
  for (; image->seek(index); ++index) {
    const ImageShape page = image->shape();
    const auto found = shape_of(page, path);
    if (!shape.empty() && found != shape.front())
      throw InputError(fmt::format("{}: page {} is {} x {} {}, the pages before it are {} x {} {}",
                                   path.string(), index, found.width, found.height, to_string(found.type),
                                   shape.front().width, shape.front().height, to_string(shape.front().type)),
                       "all slices must have one size and type");
    if (shape.empty()) shape.push_back(found);
    pages.push_back({path, index});
    bytes += page.bytes;
    const std::string compression = image->text("compression");
    compressed |= !compression.empty() && compression != "none";
  }
  if (std::uint64_t(index) != chained)
    throw InputError(fmt::format("{}: page {} cannot be read", path.string(), index),
                     "the file was cut short or damaged");
  require_one_stack(path, std::uint64_t(index));
  const auto size = InputFile(path).size();
  if (compressed)
    require_compressed_bytes(path, size, bytes, any_best_ratio);
  else
    require_bytes(path, size, 0, bytes);
}

/// Pages are found by number, so every process reads its own.
class TiffSource final : public VolumeSource {
 public:
  TiffSource(const Grid& grid, std::vector<Page> pages)
      : grid_(grid), pages_(std::move(pages)), files_(files_of(pages_)) {}
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  Facts facts() const override {
    Facts facts = files_.facts();
    facts.insert(facts.begin(), {"encoding", "TIFF"});
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int i = 0; i < count; ++i)
      read_page(pages_[std::size_t(first + i)], out.subspan(std::size_t(i) * bytes, bytes));
  }

 private:
  static std::vector<std::filesystem::path> files_of(const std::vector<Page>& pages) {
    std::vector<std::filesystem::path> files;
    for (const Page& page : pages) files.push_back(page.file);
    return files;
  }

  void read_page(const Page& page, std::span<std::byte> out) {
    files_.require_unchanged(page.file);
    if (!image_ || opened_ != page.file) {
      image_ = open_image(page.file);
      opened_ = page.file;
    }
    const std::string problem = image_->read(page.index, 1, sample_type_of(grid_.type), out.data());
    if (!problem.empty())
      throw InputError(
          fmt::format("cannot read page {} of {}: {}", page.index, page.file.string(), one_line(problem)),
          "the file was cut short or damaged");
    files_.require_unchanged(page.file);
  }

  Grid grid_;
  std::vector<Page> pages_;
  VolumeFiles files_;
  std::unique_ptr<ImageFile> image_;
  std::filesystem::path opened_;
};

/// slice2 comes before slice10: runs of digits compare as numbers.
bool natural_less(const std::string& a, const std::string& b) {
  const auto digits = [](const std::string& s, std::size_t& i) {
    while (i + 1 < s.size() && s[i] == '0' && std::isdigit(static_cast<unsigned char>(s[i + 1]))) ++i;
    const auto start = i;
    while (i < s.size() && std::isdigit(static_cast<unsigned char>(s[i]))) ++i;
    return s.substr(start, i - start);
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (std::isdigit(static_cast<unsigned char>(a[i])) && std::isdigit(static_cast<unsigned char>(b[j]))) {
      const auto left = digits(a, i), right = digits(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i, ++j;
    }
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

std::vector<std::filesystem::path> files_of(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path))
    if (is_tiff(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

}  // namespace

bool is_tiff(const std::filesystem::path& path) {
  const auto ending = lower_case(path.extension().string());
  return ending == ".tif" || ending == ".tiff";
}

void warn_of_tiff_spacing(const std::filesystem::path& path) {
  if (const auto files = files_of(path); !files.empty()) warn_of_voxel_size(files.front());
}

/// TIFF has no third spacing and its resolution is for printers: the spacing is 1.
std::unique_ptr<VolumeSource> open_tiff(const std::filesystem::path& path, const VolumeChoice&) {
  std::vector<Page> pages;
  std::vector<PageShape> shape;
  for (const auto& file : files_of(path)) add_pages(file, pages, shape);
  if (pages.empty()) throw InputError(fmt::format("{} has no pages", path.string()), "give a TIFF stack");
  Grid grid;
  grid.dims = {shape.front().width, shape.front().height, int(pages.size())};
  grid.type = shape.front().type;
  check(grid, path.string());
  return std::make_unique<TiffSource>(grid, std::move(pages));
}

}  // namespace ringsplat::detail
