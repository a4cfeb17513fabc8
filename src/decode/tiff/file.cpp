#include "decode/tiff/file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/input_file.hpp"
#include "formats/limits.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

bool same_shape(const TiffFile& a, const TiffFile& b) {
  return a.width == b.width && a.height == b.height && a.type == b.type && a.samples == b.samples;
}

/// A palette's indices are what was measured; the library gives their colours, so they are read without it
/// where that is possible.
bool has_raw_indices(const TiffPage& page, const ImageShape& shape) {
  return page.palette && page.raw_bytes == std::uint64_t(shape.width) * std::uint64_t(shape.height);
}

void set_shape(const ImageShape& shape, bool indices, TiffFile& file) {
  if (shape.depth > 1)
    throw InputError(fmt::format("{}: {} planes in one page", file.path.string(), shape.depth),
                     "write one slice a page");
  const auto type = indices ? ScalarType::uint8 : scalar_type_of(shape.type);
  if (!type)
    throw InputError(
        fmt::format("{}: pixels of type {} cannot be rendered", file.path.string(), shape.type_name),
        "convert them to at most 32 bits or float first");
  file.width = shape.width;
  file.height = shape.height;
  file.type = *type;
  file.samples = indices ? 1 : shape.channels;
  file.has_alpha = !indices && shape.alpha_channel >= 0 && shape.alpha_channel == shape.channels - 1;
}

/// Sums the bytes that the pages' pixels have uncompressed.
class Amount {
 public:
  void add(const TiffPage& page, const ImageShape& shape, const ImageFile& image) {
    constexpr int whole_byte = 8;
    auto bytes = page.palette ? shape.bytes / std::uint64_t(std::max(1, shape.channels)) : shape.bytes;
    if (const int bits = image.number("oiio:BitsPerSample"); bits > 0 && bits < whole_byte)
      bytes = bytes * std::uint64_t(bits) / whole_byte;
    bytes_ += bytes;
    const std::string compression = image.text("compression");
    compressed_ |= !compression.empty() && compression != "none";
  }
  void require(const std::filesystem::path& path) const {
    const auto size = InputFile(path).size();
    if (compressed_)
      require_compressed_bytes(path, size, bytes_, any_best_ratio);
    else
      require_bytes(path, size, 0, bytes_);
  }

 private:
  std::uint64_t bytes_ = 0;
  bool compressed_ = false;
};

/// Adds the pages that are slices. Smaller copies and masks are none, unless the file has nothing else.
void add_pages(const TiffPages& chain, TiffFile& file) {
  const auto image = open_tiff_image(file.path);
  const bool none_else =
      std::all_of(chain.pages.begin(), chain.pages.end(), [](const TiffPage& page) { return page.beside; });
  Amount amount;
  std::size_t index = 0;
  for (; index < chain.pages.size() && image->seek(int(index)); ++index) {
    const TiffPage& page = chain.pages[index];
    if (page.beside && !none_else) continue;
    const ImageShape shape = image->shape();
    const bool indices = has_raw_indices(page, shape);
    TiffFile found;
    found.path = file.path;
    set_shape(shape, indices, found);
    if (file.planes.empty()) set_shape(shape, indices, file);
    if (!same_shape(found, file))
      throw InputError(fmt::format("{}: page {} is {} x {} {}, the pages before it are {} x {} {}",
                                   file.path.string(), index, found.width, found.height,
                                   to_string(found.type), file.width, file.height, to_string(file.type)),
                       "all slices must have one size and type");
    file.planes.push_back({file.path, int(index)});
    if (indices) file.planes.back().raw_begin = page.raw_begin;
    amount.add(page, shape, *image);
  }
  if (index != chain.pages.size() || image->seek(int(index)))
    throw InputError(fmt::format("{}: page {} cannot be read", file.path.string(), index),
                     "the file was cut short or damaged");
  amount.require(file.path);
}

/// ImageJ writes one page for a stack of more than 4 GB; its other planes follow the first.
void add_planes_behind(const TiffPages& chain, std::uint64_t planes, TiffFile& file) {
  const TiffPage& page = chain.pages[std::size_t(file.planes[0].page)];
  const auto bytes = std::uint64_t(file.width) * std::uint64_t(file.height) * std::uint64_t(file.samples) *
                     size_of(file.type);
  if (page.raw_begin == 0 || (page.raw_bytes != bytes && page.raw_bytes / planes != bytes)) return;
  constexpr std::uint64_t most = 1 << 24;  // keeps the list of planes small
  const auto size = InputFile(file.path).size();
  if (planes > most || (size - page.raw_begin) / bytes < planes) return;
  file.planes.clear();
  for (std::uint64_t i = 0; i < planes; ++i)
    file.planes.push_back({file.path, 0, page.raw_begin + i * bytes, chain.big_endian});
}

void require_planes(const TiffPages& chain, TiffFile& file) {
  const Microscopy& said = *file.microscopy;
  const auto planes = said.planes(file.slices());
  if (said.by == "ImageJ" && file.planes.size() == 1 && planes && *planes > 1)
    add_planes_behind(chain, *planes, file);
  const bool all_there =
      planes && (said.runs.empty() ? *planes == file.planes.size() : *planes <= file.planes.size());
  if (all_there) return;
  const std::string slices = said.slices ? std::to_string(*said.slices) : "some";
  const auto counts =
      said.channels == 1 && said.frames == 1
          ? slices + " slices"
          : fmt::format("{} channels, {} time points and {} slices", said.channels, said.frames, slices);
  throw InputError(fmt::format("{}: it says that it has {} (by its {}), and has {} pages", file.path.string(),
                               counts, said.by, file.planes.size()),
                   "write all slices as pages of one file");
}

}  // namespace

std::int64_t TiffFile::slices() const {
  if (!microscopy) return std::int64_t(planes.size());
  if (microscopy->slices) return *microscopy->slices;
  const auto others = microscopy->planes(1).value_or(1);
  return std::max<std::int64_t>(1, std::int64_t(planes.size() / others));
}

TiffFile read_tiff_file(const std::filesystem::path& path) {
  const TiffPages chain = read_tiff_pages(path);
  TiffFile file;
  file.path = path;
  add_pages(chain, file);
  if (file.planes.empty()) return file;
  file.microscopy = read_microscopy(read_tiff_notes(path));
  if (!file.microscopy) return file;
  if (!file.microscopy->problem.empty())
    throw InputError(
        fmt::format("{}: {} (by its {})", path.string(), file.microscopy->problem, file.microscopy->by),
        "extract one image as a stack, in Fiji with Image > Duplicate, or with tiffsplit");
  require_planes(chain, file);
  return file;
}

}  // namespace ringsplat::detail
