#include "decode/tiff/file.hpp"

#include <bit>
#include <cmath>
#include <utility>

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
  /// Where its pixels lie when they are uncompressed and in one piece, else 0 bytes.
  std::uint64_t raw_begin = 0, raw_bytes = 0;
};
struct TiffPages {
  bool big_endian = false;
  std::vector<TiffPage> pages;  ///< in the order of the file's chain
  // Of the first page; empty and 0 when missing.
  std::string description;                 ///< tag ImageDescription
  std::array<double, 2> resolution{0, 0};  ///< tags XResolution and YResolution: pixels for a unit
  std::vector<ChannelNotes> of_channels;   ///< ImageJ's tags
};

enum Version : std::uint64_t { classic = 42, big_tiff = 43 };
enum FieldTag : std::uint64_t {
  new_subfile_type = 254,
  compression = 259,
  photometric = 262,
  image_description = 270,
  x_resolution = 282,
  y_resolution = 283,
  strip_offsets = 273,
  strip_bytes = 279,
  planar_configuration = 284,
  tile_offsets = 324,
  tile_bytes = 325,
  image_j_lengths = 50838,
  image_j_blocks = 50839
};
enum FieldType : std::uint64_t {
  single_bytes = 1,
  text = 2,
  short_numbers = 3,
  long_numbers = 4,
  ratios = 5,
  long8_numbers = 16
};

/// An array of numbers, inside its directory entry when it fits there.
struct Field {
  std::uint64_t begin = 0, count = 0;
  std::size_t number_bytes = 0;
};

/// All that 8 or 16 bits hold was nobody's choice.
std::optional<glm::dvec2> window_of(double low, double high) {
  const bool all = low == 0 && (high == 255 || high == 65535);
  return low < high && std::isfinite(high - low) && !all ? std::optional(glm::dvec2(low, high))
                                                         : std::nullopt;
}

/// Reads the directories of a TIFF or BigTIFF file (TIFF 6.0, section 2) and checks that they and their
/// strips or tiles lie in the file. In a cut file the library takes a chain that leads beyond the end for the
/// last page, and missing strips for zeros; here both throw InputError. A file that is not TIFF has no pages.
class TiffChain {
 public:
  explicit TiffChain(const InputFile& file)
      : path_(file.path()), mapped_(file.mapped()), bytes_(mapped_.get(), std::size_t(file.size())) {
    const auto order = bytes_.substr(0, 2);
    if (order != "II" && order != "MM") return;
    big_endian_ = order == "MM";
    const auto version = number(2, 2);
    wide_ = version == big_tiff;
    is_tiff_ = version == classic || wide_;
  }

  TiffPages pages() const {
    TiffPages found;
    found.big_endian = big_endian_;
    if (!is_tiff_) return found;
    const auto most = bytes_.size() / (count_bytes() + offset_bytes());
    for (auto at = number(wide_ ? 8 : 4, offset_bytes()); at != 0;) {
      if (found.pages.size() > most) refuse(path_, "write the file again", "its pages form a loop");
      at = read_page(at, found);
    }
    return found;
  }

 private:
  std::size_t offset_bytes() const { return wide_ ? 8 : 4; }
  std::size_t count_bytes() const { return wide_ ? 8 : 2; }
  std::size_t entry_bytes() const { return wide_ ? 20 : 12; }

  [[noreturn]] void fail() const {
    refuse(path_, "copy the file again", "it is cut short: a page lies behind its end");
  }

  std::uint64_t number(std::uint64_t offset, std::size_t bytes) const {
    if (offset > bytes_.size() || bytes_.size() - offset < bytes) fail();
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8 | std::uint8_t(bytes_[offset + (big_endian_ ? i : bytes - 1 - i)]);
    return value;
  }

  /// Returns the offset of the next page's directory, 0 after the last.
  std::uint64_t read_page(std::uint64_t at, TiffPages& found) const {
    auto& page = found.pages.emplace_back();
    const bool first = found.pages.size() == 1;
    const auto entries = number(at, count_bytes());
    if (entries > bytes_.size() / entry_bytes()) fail();
    Field offsets, lengths, block_lengths, blocks;
    bool raw = true, compressed = false;
    for (std::uint64_t i = 0; i < entries; ++i) {
      const auto entry = at + count_bytes() + i * entry_bytes();
      const auto tag = number(entry, 2), type = number(entry + 2, 2);
      if (first && tag == image_description && type == text) found.description = text_of(field(entry));
      if (first && (tag == x_resolution || tag == y_resolution) && type == ratios)
        found.resolution[tag == x_resolution ? 0 : 1] = ratio_of(field(entry));
      if (first && tag == image_j_lengths && type == long_numbers) block_lengths = field(entry);
      if (first && tag == image_j_blocks && type == single_bytes) blocks = field(entry);
      if (tag == strip_offsets || tag == tile_offsets) offsets = field(entry);
      if (tag == strip_bytes || tag == tile_bytes) lengths = field(entry);
      constexpr std::uint64_t smaller_copy = 1, mask = 4, is_palette = 3;
      if (tag == new_subfile_type) page.beside = (value_of(field(entry)) & (smaller_copy | mask)) != 0;
      if (tag == photometric) page.palette = value_of(field(entry)) == is_palette;
      if (tag == compression) compressed = value_of(field(entry)) != 1;
      if (tag == tile_offsets || (tag == planar_configuration && value_of(field(entry)) != 1)) raw = false;
    }
    if (block_lengths.count > 0 && blocks.count > 0) read_channels(block_lengths, blocks, found.of_channels);
    const auto parts = std::min(offsets.count, lengths.count);
    for (std::uint64_t i = 0; i < parts; ++i) {
      const auto begin = value_of(offsets, i), length = value_of(lengths, i);
      if (begin > bytes_.size() || length > bytes_.size() - begin) fail();
      if (i == 0) page.raw_begin = begin;
      raw = raw && begin == page.raw_begin + page.raw_bytes;
      page.raw_bytes += length;
    }
    if (!raw || compressed) page.raw_begin = page.raw_bytes = 0;
    return number(at + count_bytes() + entries * entry_bytes(), offset_bytes());
  }

  /// 0 beyond a field's last number.
  std::uint64_t value_of(const Field& field, std::uint64_t i = 0) const {
    return i < field.count ? number(field.begin + i * field.number_bytes, field.number_bytes) : 0;
  }

  Field field(std::uint64_t entry) const {
    const auto type = number(entry + 2, 2);
    const std::size_t bytes = type == text || type == single_bytes      ? 1
                              : type == short_numbers                   ? 2
                              : type == long_numbers                    ? 4
                              : type == long8_numbers || type == ratios ? 8
                                                                        : 0;
    const auto count = number(entry + 4, offset_bytes()), value = entry + 4 + offset_bytes();
    if (bytes == 0 || count > bytes_.size() / bytes) fail();
    return {count * bytes <= offset_bytes() ? value : number(value, offset_bytes()), count, bytes};
  }

  /// The field's text up to its first zero byte.
  std::string text_of(const Field& field) const {
    const auto text = bytes_.substr(std::min<std::uint64_t>(field.begin, bytes_.size()), field.count);
    if (text.size() < field.count) fail();
    return std::string(text.substr(0, text.find('\0')));
  }

  /// ImageJ's blocks (ij/io/TiffEncoder.java): the first says how many there are of each kind behind it. A
  /// channel's colours are 256 reds, greens and blues; ranges are two float64 a channel.
  void read_channels(const Field& lengths, const Field& blocks, std::vector<ChannelNotes>& channels) const {
    constexpr std::uint64_t colours = 0x6c757473, ranges = 0x72616e67;
    constexpr std::uint64_t most_channels = 256, most_kinds = 4 + 8 * 64;
    const auto length = [&](std::uint64_t block) { return value_of(lengths, block); };
    const auto channel = [&](std::uint64_t k) -> ChannelNotes& {
      if (k >= channels.size()) channels.resize(std::size_t(k + 1));
      return channels[std::size_t(k)];
    };
    const auto kinds = std::min(length(0), most_kinds);
    auto at = blocks.begin + length(0);
    std::uint64_t block = 1;
    for (std::uint64_t entry = 4; entry + 8 <= kinds; entry += 8) {
      const auto kind = number(blocks.begin + entry, 4), count = number(blocks.begin + entry + 4, 4);
      for (std::uint64_t k = 0; k < count && block < lengths.count; ++k, ++block) {
        if (kind == colours && length(block) == 3 * 256 && k < most_channels)
          channel(k).colour =
              glm::dvec3(number(at + 255, 1), number(at + 511, 1), number(at + 767, 1)) / 255.0;
        for (std::uint64_t c = 0; kind == ranges && c < std::min(length(block) / 16, most_channels); ++c)
          channel(c).window = window_of(std::bit_cast<double>(number(at + 16 * c, 8)),
                                        std::bit_cast<double>(number(at + 16 * c + 8, 8)));
        at += length(block);
      }
    }
  }

  double ratio_of(const Field& field) const {
    if (field.count < 1) return 0;
    const auto above = number(field.begin, 4), below = number(field.begin + 4, 4);
    return below == 0 ? 0 : double(above) / double(below);
  }

  std::filesystem::path path_;
  std::shared_ptr<const char> mapped_;
  std::string_view bytes_;
  bool is_tiff_ = false, big_endian_ = false, wide_ = false;
};

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

/// The bytes that a page's pixels have uncompressed.
std::uint64_t bytes_of(const TiffPage& page, const ImageShape& shape, const ImageFile& image) {
  constexpr int whole_byte = 8;
  const auto bytes = page.palette ? shape.bytes / std::uint64_t(std::max(1, shape.channels)) : shape.bytes;
  const int bits = image.number("oiio:BitsPerSample");
  return bits > 0 && bits < whole_byte ? bytes * std::uint64_t(bits) / whole_byte : bytes;
}

/// Adds the pages that are slices. Smaller copies and masks are none, unless the file has nothing else.
void add_pages(const TiffPages& chain, TiffFile& file) {
  const auto image = open_tiff_image(file.path);
  const bool none_else = std::ranges::all_of(chain.pages, [](const TiffPage& page) { return page.beside; });
  std::uint64_t bytes = 0;
  bool compressed = is_png(file.path);
  std::size_t index = 0;
  for (; index < chain.pages.size() && image->seek(int(index)); ++index) {
    const TiffPage& page = chain.pages[index];
    if (page.beside && !none_else) continue;
    const ImageShape shape = image->shape();
    // A palette's indices are what was measured; the library gives their colours, so they are read without
    // it where that is possible.
    const bool indices =
        page.palette && page.raw_bytes == std::uint64_t(shape.width) * std::uint64_t(shape.height);
    TiffFile found;
    found.path = file.path;
    set_shape(shape, indices, found);
    if (file.planes.empty()) set_shape(shape, indices, file);
    if (found.width != file.width || found.height != file.height || found.type != file.type ||
        found.samples != file.samples)
      refuse(file.path, "all slices must have one size and type",
             "page {} is {} x {} {}, the pages before it are {} x {} {}", index, found.width, found.height,
             to_string(found.type), file.width, file.height, to_string(file.type));
    file.planes.push_back({file.path, int(index)});
    if (indices) file.planes.back().raw_begin = page.raw_begin;
    bytes += bytes_of(page, shape, *image);
    const auto compression = image->text("compression");
    compressed |= !compression.empty() && compression != "none";
  }
  if (index != chain.pages.size() || image->seek(int(index)))
    refuse(file.path, "the file was cut short or damaged", "page {} cannot be read", index);
  const auto size = InputFile(file.path).size();
  if (compressed)
    require_compressed_bytes(file.path, size, bytes, any_best_ratio);
  else
    require_bytes(file.path, size, 0, bytes);
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
  const Microscopy& said = file.microscopy;
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
  TiffPages chain = TiffChain(input).pages();
  if (is_png(path)) chain.pages.resize(1);
  TiffFile file;
  file.path = path;
  add_pages(chain, file);
  if (file.planes.empty()) return file;
  file.microscopy = read_microscopy(chain.description, chain.resolution).value_or(Microscopy());
  if (!file.microscopy.problem.empty())
    refuse(path, "extract one image as a stack, in Fiji with Image > Duplicate, or with tiffsplit",
           "{} (by its {})", file.microscopy.problem, file.microscopy.by);
  require_planes(chain, file);
  if (file.microscopy.by == "ImageJ") file.microscopy.of_channels = chain.of_channels;
  return file;
}

}  // namespace ringsplat::detail
