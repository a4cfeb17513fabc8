#include "decode/tiff/pages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "base/input_file.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

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
  tile_bytes = 325
};
enum FieldType : std::uint64_t {
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

class TiffChain {
 public:
  explicit TiffChain(const InputFile& file) : file_(file) {
    std::array<std::byte, 2> order{};
    if (file.read_some(0, order) != order.size() || order[0] != order[1]) return;
    if (order[0] != std::byte{'I'} && order[0] != std::byte{'M'}) return;
    big_endian_ = order[0] == std::byte{'M'};
    const auto version = number(2, 2);
    wide_ = version == big_tiff;
    is_tiff_ = version == classic || wide_;
  }

  TiffPages pages() const {
    TiffPages found{.big_endian = big_endian_, .pages = {}};
    if (!is_tiff_) return found;
    const auto most = file_.size() / (count_bytes() + offset_bytes());
    for (auto at = first_page(); at != 0;) {
      if (found.pages.size() > most)
        throw InputError(fmt::format("{}: its pages form a loop", file_.path().string()),
                         "write the file again");
      found.pages.emplace_back();
      at = read_page(at, found.pages.back());
    }
    return found;
  }

  TiffNotes notes() const {
    TiffNotes notes;
    const auto at = is_tiff_ ? first_page() : 0;
    if (at == 0) return notes;
    const auto entries = number(at, count_bytes());
    if (entries > file_.size() / entry_bytes()) fail();
    for (std::uint64_t i = 0; i < entries; ++i) {
      const auto entry = at + count_bytes() + i * entry_bytes();
      const auto tag = number(entry, 2), type = number(entry + 2, 2);
      if (tag == image_description && type == text) notes.description = text_of(field(entry));
      if ((tag == x_resolution || tag == y_resolution) && type == ratios)
        notes.resolution[tag == x_resolution ? 0 : 1] = ratio_of(field(entry));
    }
    return notes;
  }

 private:
  std::uint64_t first_page() const { return number(wide_ ? 8 : 4, offset_bytes()); }
  std::size_t offset_bytes() const { return wide_ ? 8 : 4; }
  std::size_t count_bytes() const { return wide_ ? 8 : 2; }
  std::size_t entry_bytes() const { return wide_ ? 20 : 12; }

  [[noreturn]] void fail() const {
    throw InputError(fmt::format("{} is cut short: a page lies behind its end", file_.path().string()),
                     "copy the file again");
  }

  std::uint64_t number(std::uint64_t offset, std::size_t bytes) const {
    std::array<std::byte, 8> raw{};
    if (offset > file_.size() || file_.read_some(offset, std::span(raw).first(bytes)) != bytes) fail();
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8 | std::to_integer<std::uint64_t>(raw[big_endian_ ? i : bytes - 1 - i]);
    return value;
  }

  /// Returns the offset of the next page's directory, 0 after the last.
  std::uint64_t read_page(std::uint64_t at, TiffPage& page) const {
    const auto entries = number(at, count_bytes());
    if (entries > file_.size() / entry_bytes()) fail();
    Field offsets, lengths;
    bool raw = true, compressed = false;
    for (std::uint64_t i = 0; i < entries; ++i) {
      const auto entry = at + count_bytes() + i * entry_bytes();
      const auto tag = number(entry, 2);
      if (tag == strip_offsets || tag == tile_offsets) offsets = field(entry);
      if (tag == strip_bytes || tag == tile_bytes) lengths = field(entry);
      constexpr std::uint64_t smaller_copy = 1, mask = 4, is_palette = 3;
      if (tag == new_subfile_type) page.beside = (value_of(entry) & (smaller_copy | mask)) != 0;
      if (tag == photometric) page.palette = value_of(entry) == is_palette;
      if (tag == compression) compressed = value_of(entry) != 1;
      if (tag == tile_offsets || (tag == planar_configuration && value_of(entry) != 1)) raw = false;
    }
    const auto parts = std::min(offsets.count, lengths.count);
    for (std::uint64_t i = 0; i < parts; ++i) {
      const auto begin = number(offsets.begin + i * offsets.number_bytes, offsets.number_bytes);
      const auto length = number(lengths.begin + i * lengths.number_bytes, lengths.number_bytes);
      if (begin > file_.size() || length > file_.size() - begin) fail();
      if (i == 0) page.raw_begin = begin;
      raw = raw && begin == page.raw_begin + page.raw_bytes;
      page.raw_bytes += length;
    }
    if (!raw || compressed) page.raw_begin = page.raw_bytes = 0;
    return number(at + count_bytes() + entries * entry_bytes(), offset_bytes());
  }

  /// A field's first number, 0 when it has none.
  std::uint64_t value_of(std::uint64_t entry) const {
    const auto one = field(entry);
    return one.count == 0 ? 0 : number(one.begin, one.number_bytes);
  }

  Field field(std::uint64_t entry) const {
    const auto type = number(entry + 2, 2);
    const std::size_t bytes = type == text                              ? 1
                              : type == short_numbers                   ? 2
                              : type == long_numbers                    ? 4
                              : type == long8_numbers || type == ratios ? 8
                                                                        : 0;
    const auto count = number(entry + 4, offset_bytes()), value = entry + 4 + offset_bytes();
    if (bytes == 0 || count > file_.size() / bytes) fail();
    return {count * bytes <= offset_bytes() ? value : number(value, offset_bytes()), count, bytes};
  }

  /// The field's text up to its first zero byte.
  std::string text_of(const Field& field) const {
    std::string text(std::size_t(field.count), '\0');
    if (field.begin > file_.size() || file_.size() - field.begin < field.count) fail();
    file_.read(field.begin, std::as_writable_bytes(std::span(text)));
    return text.substr(0, text.find('\0'));
  }

  double ratio_of(const Field& field) const {
    if (field.count < 1) return 0;
    const auto above = number(field.begin, 4), below = number(field.begin + 4, 4);
    return below == 0 ? 0 : double(above) / double(below);
  }

  const InputFile& file_;
  bool is_tiff_ = false, big_endian_ = false, wide_ = false;
};

}  // namespace

TiffPages read_tiff_pages(const std::filesystem::path& path) {
  const InputFile file(path);
  return TiffChain(file).pages();
}

TiffNotes read_tiff_notes(const std::filesystem::path& path) {
  const InputFile file(path);
  return TiffChain(file).notes();
}

}  // namespace ringsplat::detail
