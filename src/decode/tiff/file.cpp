#include "decode/tiff/file.hpp"

#include <tiffio.h>

#include <cmath>
#include <numeric>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

struct TiffPage {
  bool beside = false;   ///< a smaller copy of another page, or a mask
  bool palette = false;  ///< its pixels are indices of colours
  bool big_endian = false;
  /// Where its pixels lie when they are uncompressed and in one piece, else 0 bytes.
  std::uint64_t raw_begin = 0, raw_bytes = 0;
};

/// A file for libtiff, which takes what lies behind the end for missing and goes on.
struct TiffBytes {
  std::string_view bytes;
  std::uint64_t at = 0;
  bool all_there = true;  ///< what was asked for
};

tmsize_t read_bytes(thandle_t file, void* out, tmsize_t wanted) {
  auto& [bytes, at, all_there] = *static_cast<TiffBytes*>(file);
  const auto found = bytes.substr(std::min<std::uint64_t>(at, bytes.size()), std::size_t(wanted));
  all_there &= found.size() == std::size_t(wanted);
  at += found.copy(static_cast<char*>(out), found.size());
  return tmsize_t(found.size());
}

/// The current page's field; 0 when it has none.
template <class T>
T field(TIFF* tiff, std::uint32_t tag) {
  T value{};
  TIFFGetField(tiff, tag, &value);
  return value;
}

/// An array of a tag that libtiff does not know; empty when its type is another.
template <class T>
std::span<const T> array_field(TIFF* tiff, std::uint32_t tag, TIFFDataType type) {
  std::uint32_t count = 0;
  const T* values = nullptr;
  if (TIFFFindField(tiff, tag, type) != nullptr) TIFFGetField(tiff, tag, &count, &values);
  return {values, count};
}

/// The current page. Looks whether its strips or tiles are there: pixels of missing ones would be anything.
TiffPage page_of(TIFF* tiff, TiffBytes& file) {
  TiffPage page;
  page.beside =
      (field<std::uint32_t>(tiff, TIFFTAG_SUBFILETYPE) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
  page.palette = field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC) == PHOTOMETRIC_PALETTE;
  page.big_endian = TIFFIsBigEndian(tiff) != 0;
  const bool tiled = TIFFIsTiled(tiff) != 0;
  const bool compressed = field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION) != COMPRESSION_NONE;
  bool raw = !tiled && !compressed && field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_CONTIG;
  const auto parts = tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
  for (std::uint32_t i = 0; i < parts; ++i) {
    const auto begin = TIFFGetStrileOffset(tiff, i), length = TIFFGetStrileByteCount(tiff, i);
    file.all_there &= length > 0 && length <= file.bytes.size() && begin <= file.bytes.size() - length;
    if (i == 0) page.raw_begin = begin;
    raw = raw && begin == page.raw_begin + page.raw_bytes;
    page.raw_bytes += length;
  }
  const auto least = TIFFVStripSize64(tiff, field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH));
  file.all_there &= compressed || page.raw_bytes >= least;
  if (!raw) page.raw_begin = page.raw_bytes = 0;
  return page;
}

/// All that 8 or 16 bits hold was nobody's choice.
std::optional<glm::dvec2> window_of(double low, double high) {
  const bool all = low == 0 && (high == 255 || high == 65535);
  return low < high && std::isfinite(high - low) && !all ? std::optional(glm::dvec2(low, high))
                                                         : std::nullopt;
}

/// ImageJ's blocks (ij/io/TiffEncoder.java): the first says how many there are of each kind behind it. A
/// channel's colours are 256 reds, greens and blues; ranges are two float64 a channel.
void read_channels(TIFF* tiff, TiffBytes& file, std::vector<ChannelNotes>& channels) {
  constexpr std::uint32_t lengths_tag = 50838, blocks_tag = 50839, colours = 0x6c757473, ranges = 0x72616e67;
  const auto lengths = array_field<std::uint32_t>(tiff, lengths_tag, TIFF_LONG);
  const auto blocks = array_field<std::byte>(tiff, blocks_tag, TIFF_BYTE);
  if (lengths.empty() || blocks.empty()) return;
  file.all_there &= std::accumulate(lengths.begin(), lengths.end(), std::uint64_t{0}) <= blocks.size();
  if (!file.all_there) return;
  const BinaryFields numbers(blocks, TIFFIsBigEndian(tiff) != 0);
  std::size_t next = lengths[0], block = 1;
  for (std::size_t entry = 4; entry + 8 <= lengths[0]; entry += 8) {
    const auto kind = numbers.at<std::uint32_t>(entry), count = numbers.at<std::uint32_t>(entry + 4);
    for (std::size_t k = 0; k < count && block < lengths.size(); ++k) {
      const std::size_t length = lengths[block++], at = std::exchange(next, next + length);
      const auto full = [&](std::size_t colour) { return numbers.at<std::uint8_t>(at + 256 * colour + 255); };
      if (kind == colours && length == 3 * 256 && k < channels.size())
        channels[k].colour = glm::dvec3(full(0), full(1), full(2)) / 255.0;
      for (std::size_t c = 0; kind == ranges && c < std::min(length / 16, channels.size()); ++c)
        channels[c].window = window_of(numbers.at<double>(at + 16 * c), numbers.at<double>(at + 16 * c + 8));
    }
  }
}

Microscopy microscopy_of_first_page(TIFF* tiff, TiffBytes& file) {
  const char* const text = field<const char*>(tiff, TIFFTAG_IMAGEDESCRIPTION);
  // A ratio that is a decimal becomes it again, without the noise of float32.
  const auto decimal = [](float ratio) { return number_in<double>(fmt::format("{}", ratio)).value_or(0); };
  const std::array resolution{decimal(field<float>(tiff, TIFFTAG_XRESOLUTION)),
                              decimal(field<float>(tiff, TIFFTAG_YRESOLUTION))};
  auto said = read_microscopy(text != nullptr ? text : "", resolution).value_or(Microscopy());
  if (said.by != "ImageJ") return said;
  constexpr std::int64_t most_channels = 256;
  said.of_channels.resize(std::size_t(std::clamp<std::int64_t>(said.channels, 0, most_channels)));
  read_channels(tiff, file, said.of_channels);
  return said;
}

/// In the order of the file's chain. Of a file that is not TIFF, or whose first page cannot be read, none.
std::vector<TiffPage> pages_of(const InputFile& input, Microscopy& microscopy) {
  const auto mapped = input.mapped();
  TiffBytes file{{mapped.get(), std::size_t(input.size())}};
  const auto write = [](thandle_t, void*, tmsize_t) { return tmsize_t{0}; };
  const auto seek = [](thandle_t in, toff_t to, int) { return static_cast<TiffBytes*>(in)->at = to; };
  const auto close = [](thandle_t) { return 0; };
  const auto size = [](thandle_t of) { return toff_t(static_cast<TiffBytes*>(of)->bytes.size()); };
  const auto print_nothing = [](TIFF*, void*, const char*, const char*, va_list) { return 1; };
  auto* const options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, print_nothing, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, print_nothing, nullptr);
  TIFF* const opened = TIFFClientOpenExt(input.path().c_str(), "rc", &file, read_bytes, write, seek, close,
                                         size, nullptr, nullptr, options);  // c: strips as they are
  TIFFOpenOptionsFree(options);
  const std::unique_ptr<TIFF, decltype(&TIFFClose)> tiff(opened, TIFFClose);
  std::vector<TiffPage> pages;
  if (!tiff) return pages;
  microscopy = microscopy_of_first_page(tiff.get(), file);
  for (bool readable = true; readable && file.all_there; readable = TIFFReadDirectory(tiff.get()) != 0) {
    pages.push_back(page_of(tiff.get(), file));
    if (file.all_there && TIFFLastDirectory(tiff.get()) != 0) return pages;
  }
  refuse(input.path(), "copy or write the file again",
         "it is cut short or damaged: a page, or a part of one, is not where it should be");
}

void set_shape(const ImageShape& shape, bool indices, TiffFile& file) {
  if (shape.depth > 1) refuse(file.path, "write one slice a page", "{} planes in one page", shape.depth);
  if (!indices && shape.type == SampleType::other)
    refuse(file.path, "convert them to at most 32 bits or float first",
           "pixels of type {} cannot be rendered", shape.type_name);
  file.width = shape.width;
  file.height = shape.height;
  const bool half = shape.type == SampleType::float16;
  file.type = indices ? ScalarType::uint8 : half ? ScalarType::float32 : ScalarType(shape.type);
  file.samples = indices ? 1 : shape.channels;
  file.has_alpha = !indices && shape.alpha_channel >= 0 && shape.alpha_channel == shape.channels - 1;
}

/// Adds the pages that are slices. Smaller copies and masks are none, unless the file has nothing else.
void add_pages(const std::vector<TiffPage>& pages, TiffFile& file) {
  const auto image = open_tiff_image(file.path);
  const bool none_else = std::ranges::all_of(pages, &TiffPage::beside);
  std::uint64_t bytes = 0;
  std::size_t index = 0;
  for (; index < pages.size() && image->seek(int(index)); ++index) {
    const TiffPage& page = pages[index];
    if (page.beside && !none_else) continue;
    const ImageShape shape = image->shape();
    // A palette's indices are what was measured; the library gives their colours, so they are read without
    // it where that is possible.
    const bool indices =
        page.palette && page.raw_bytes == std::uint64_t(shape.width) * std::uint64_t(shape.height);
    TiffFile found{.path = file.path};
    set_shape(shape, indices, found);
    if (file.planes.empty()) set_shape(shape, indices, file);
    if (found.width != file.width || found.height != file.height || found.type != file.type ||
        found.samples != file.samples)
      refuse(file.path, "all slices must have one size and type",
             "page {} is {} x {} {}, the pages before it are {} x {} {}", index, found.width, found.height,
             to_string(found.type), file.width, file.height, to_string(file.type));
    file.planes.push_back({file.path, int(index)});
    if (indices) file.planes.back().raw_begin = page.raw_begin;
    bytes += shape.bytes;
  }
  if (index != pages.size() || image->seek(int(index)))
    refuse(file.path, "the file was cut short or damaged", "page {} cannot be read", index);
  require_compressed_bytes(file.path, InputFile(file.path).size(), bytes, any_best_ratio);
}

/// ImageJ writes one page for a stack of more than 4 GB; its other planes follow the first.
void add_planes_behind(const TiffPage& page, std::uint64_t planes, TiffFile& file) {
  const auto bytes = std::uint64_t(file.width) * std::uint64_t(file.height) * std::uint64_t(file.samples) *
                     size_of(file.type);
  if (page.raw_begin == 0 || (page.raw_bytes != bytes && page.raw_bytes / planes != bytes)) return;
  constexpr std::uint64_t most = 1 << 24;  // keeps the list of planes small
  const auto size = InputFile(file.path).size();
  if (planes > most || (size - page.raw_begin) / bytes < planes) return;
  file.planes.clear();
  for (std::uint64_t i = 0; i < planes; ++i)
    file.planes.push_back({file.path, 0, page.raw_begin + i * bytes, page.big_endian});
}

void require_planes(const std::vector<TiffPage>& pages, TiffFile& file) {
  const Microscopy& said = file.microscopy;
  const auto planes = said.planes(file.slices());
  if (said.by == "ImageJ" && file.planes.size() == 1 && planes && *planes > 1)
    add_planes_behind(pages[std::size_t(file.planes[0].page)], *planes, file);
  const bool all_there =
      planes && (said.runs.empty() ? *planes == file.planes.size() : *planes <= file.planes.size());
  if (all_there) return;
  const std::string slices = said.slices ? std::to_string(*said.slices) : "some";
  const auto counts =
      said.channels == 1 && said.frames == 1
          ? slices + " slices"
          : fmt::format("{} channels, {} time points and {} slices", said.channels, said.frames, slices);
  refuse(file.path, "write all slices as pages of one file",
         "it says that it has {} (by its {}), and has {} pages", counts, said.by, file.planes.size());
}

}  // namespace

std::string in_words(const std::string& problem) {
  const bool too_large = problem.find("bad_alloc") != std::string::npos;
  return too_large ? "its parts are too large for a file of its size" : one_line(problem);
}

std::unique_ptr<ImageFile> open_tiff_image(const std::filesystem::path& path) {
  const InputFile readable(path);
  auto [file, problem] = open_image_file(path);
  if (!file)
    throw InputError(fmt::format("{} is not a readable image file: {}", path.string(), in_words(problem)),
                     "check the file with another viewer");
  return std::move(file);
}

TiffFile read_tiff_file(const std::filesystem::path& path) {
  const InputFile input(path);
  TiffFile file{.path = path};
  auto pages = pages_of(input, file.microscopy);
  if (is_png(path)) pages.resize(1);
  add_pages(pages, file);
  if (!file.microscopy.problem.empty())
    refuse(path, "extract one image as a stack, in Fiji with Image > Duplicate, or with tiffsplit",
           "{} (by its {})", file.microscopy.problem, file.microscopy.by);
  require_planes(pages, file);
  return file;
}

}  // namespace ringsplat::detail
