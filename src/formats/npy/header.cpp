#include "formats/npy/header.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/binary_fields.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::size_t longest_header = 64 << 10;  // bytes; NumPy itself reads 10000

/// Type strings without the byte order; b1 holds 0 and 1.
constexpr std::array<std::pair<std::string_view, ScalarType>, 10> types{{
    {"b1", ScalarType::uint8},
    {"i1", ScalarType::int8},
    {"u1", ScalarType::uint8},
    {"i2", ScalarType::int16},
    {"u2", ScalarType::uint16},
    {"i4", ScalarType::int32},
    {"u4", ScalarType::uint32},
    {"f2", ScalarType::uint16},
    {"f4", ScalarType::float32},
    {"f8", ScalarType::float64},
}};

/// Reads the dictionary {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }.
class Dictionary {
 public:
  Dictionary(std::string_view text, std::string where) : text_(text), where_(std::move(where)) {}

  void read(NpyHeader& header) {
    expect('{');
    while (!accept('}')) {
      const auto key = word();
      if (!keys_.insert(key).second) fail(fmt::format("{} is given twice", excerpt(key)));
      expect(':');
      if (key == "descr")
        read_type(header);
      else if (key == "fortran_order")
        header.fortran_order = boolean();
      else if (key == "shape")
        header.shape = sizes();
      else
        fail(fmt::format("unknown key '{}'", excerpt(key)));
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    skip_blanks();
    if (!text_.empty()) fail("more after the dictionary");
    if (keys_.size() != 3) fail("descr, fortran_order or shape is missing");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{} has no readable NumPy header: {}", where_, what),
                     "write it with numpy.save");
  }

  void skip_blanks() {
    while (!text_.empty() && std::isspace(static_cast<unsigned char>(text_.front())) != 0)
      text_.remove_prefix(1);
  }
  bool accept(char c) {
    skip_blanks();
    if (text_.empty() || text_.front() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!accept(c)) fail(fmt::format("'{}' is missing before '{}'", c, excerpt(std::string(text_))));
  }

  /// A text in quotes.
  std::string word() {
    const char quote = accept('"') ? '"' : '\'';
    if (quote == '\'') expect(quote);
    const auto end = text_.find(quote);
    if (end == text_.npos) fail("a text without an end");
    const std::string value(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return value;
  }

  bool boolean() {
    skip_blanks();
    for (const auto& [name, value] : {std::pair("True", true), std::pair("False", false)})
      if (text_.starts_with(name)) {
        text_.remove_prefix(std::strlen(name));
        return value;
      }
    fail("fortran_order is neither True nor False");
  }

  std::vector<std::int64_t> sizes() {
    constexpr std::size_t most_axes = 64;  // of NumPy
    expect('(');
    std::vector<std::int64_t> list;
    while (!accept(')')) {
      skip_blanks();
      std::size_t digits = 0;
      while (digits < text_.size() && std::isdigit(static_cast<unsigned char>(text_[digits])) != 0) ++digits;
      const auto number = number_in<std::int64_t>(text_.substr(0, digits));
      if (!number) fail("shape is no list of sizes");
      if (list.size() == most_axes) fail("shape has too many axes");
      list.push_back(*number);
      text_.remove_prefix(digits);
      accept('L');  // Python 2
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return list;
  }

  void read_type(NpyHeader& header) {
    skip_blanks();
    if (text_.starts_with('['))
      throw InputError(fmt::format("{}: its array has several named fields", where_),
                       "save one of them: np.save('volume.npy', a['FIELD'])");
    const auto descr = word();
    const auto name = std::string_view(descr).substr(descr.empty() ? 0 : 1);
    for (const auto& [known, type] : types) {
      if (known != name || std::string_view("<>|=").find(descr[0]) == std::string_view::npos) continue;
      header.type = type;
      header.half = name == "f2";
      header.big_endian = descr[0] == '>' || (descr[0] == '=' && std::endian::native == std::endian::big);
      return;
    }
    const bool whole = name == "i8" || name == "u8";
    throw InputError(
        fmt::format("{}: voxels of type '{}' cannot be rendered", where_, excerpt(descr)),
        whole ? "64-bit numbers are not held exactly: save a.astype(np.int32) or a.astype(np.float32)"
              : "save an array of real numbers of at most 32 bits or float64");
  }

  std::string_view text_;
  std::string where_;
  std::set<std::string> keys_;
};

}  // namespace

NpyHeader read_npy_header(const std::filesystem::path& path) {
  const InputFile file(path);
  std::array<unsigned char, 12> start{};
  const auto got = file.read_some(0, std::as_writable_bytes(std::span(start)));
  constexpr std::string_view magic = "\x93NUMPY";
  if (got < start.size() || std::memcmp(start.data(), magic.data(), magic.size()) != 0 || start[6] < 1 ||
      start[6] > 3)
    throw InputError(fmt::format("{} is no NumPy array file of format 1 to 3", path.string()),
                     "write it with numpy.save");
  // Two bytes in format 1, four since.
  const BinaryFields fields(std::as_bytes(std::span(start)), false);
  const std::uint64_t length = start[6] > 1 ? fields.at<std::uint32_t>(8) : fields.at<std::uint16_t>(8);
  const std::uint64_t begin = start[6] > 1 ? 12 : 10;
  if (length > longest_header || begin + length > file.size())
    throw InputError(
        fmt::format("{}: its NumPy header of {} bytes is cut short or endless", path.string(), length),
        "write it with numpy.save");
  std::string text(std::size_t(length), '\0');
  file.read(begin, std::as_writable_bytes(std::span(text)));
  NpyHeader header;
  header.end = begin + length;
  Dictionary(text, path.string()).read(header);
  return header;
}

}  // namespace ringsplat::detail
