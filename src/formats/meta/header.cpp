#include "formats/meta/header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/text_reader.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t longest_header = 1 << 20;  // bytes; a header has a few hundred

/// MET_LONG has 4 bytes wherever it was written.
constexpr std::array<std::pair<std::string_view, ScalarType>, 10> element_types{{
    {"MET_CHAR", ScalarType::int8},
    {"MET_UCHAR", ScalarType::uint8},
    {"MET_SHORT", ScalarType::int16},
    {"MET_USHORT", ScalarType::uint16},
    {"MET_INT", ScalarType::int32},
    {"MET_UINT", ScalarType::uint32},
    {"MET_LONG", ScalarType::int32},
    {"MET_ULONG", ScalarType::uint32},
    {"MET_FLOAT", ScalarType::float32},
    {"MET_DOUBLE", ScalarType::float64},
}};

constexpr std::array<std::string_view, 21> known_keys{"ObjectType",
                                                      "NDims",
                                                      "DimSize",
                                                      "ElementType",
                                                      "ElementNumberOfChannels",
                                                      "ElementSpacing",
                                                      "ElementSize",
                                                      "Offset",
                                                      "Position",
                                                      "Origin",
                                                      "ImagePosition",
                                                      "TransformMatrix",
                                                      "Rotation",
                                                      "Orientation",
                                                      "BinaryData",
                                                      "BinaryDataByteOrderMSB",
                                                      "ElementByteOrderMSB",
                                                      "CompressedData",
                                                      "CompressedDataSize",
                                                      "HeaderSize",
                                                      "ElementDataFile"};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path), file_(path) {}

  MetaHeader read() {
    read_lines();
    MetaHeader header;
    header.end = end_;
    header.data_file = required("ElementDataFile");
    if (std::any_of(header.data_file.begin(), header.data_file.end(),
                    [](unsigned char c) { return std::iscntrl(c); }))
      fail(fmt::format("ElementDataFile '{}' has control characters", excerpt(header.data_file)),
           "correct the header");
    if (const auto type = value("ObjectType"); type && *type != "Image")
      fail(fmt::format("ObjectType is '{}'", excerpt(*type)), "only an Image is a volume");
    header.binary = flag("BinaryData", true);
    header.compressed = flag("CompressedData", false);
    header.big_endian = flag("BinaryDataByteOrderMSB", flag("ElementByteOrderMSB", header.big_endian));
    header.header_size = integer("HeaderSize", 0, -1);
    integer("CompressedDataSize", 0, 0);
    const auto channels = integer("ElementNumberOfChannels", 1, 1);
    if (channels > std::numeric_limits<int>::max())
      fail(fmt::format("ElementNumberOfChannels is {}", channels), "correct the header");
    header.channels = int(channels);
    header.dimensions = read_dimensions();
    header.grid = read_grid(std::size_t(header.dimensions), header.frames);
    check_lattice(header.grid, path_.string());
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& hint) const {
    throw InputError(fmt::format("{}: {}", path_.string(), what), hint);
  }
  [[noreturn]] void fail_header(const std::string& what) const {
    throw InputError(fmt::format("{} has no readable MetaImage header: {}", path_.string(), what),
                     "it needs NDims, DimSize, ElementType and, last, ElementDataFile");
  }

  void read_lines() {
    TextReader text(file_, 0, longest_header);
    auto line = text.line();
    for (int number = 1; line && !take_line(*line, number); ++number) line = text.line();
    if (!line) fail_header("no line ElementDataFile");
    end_ = text.position();
  }

  /// True for the header's last line.
  bool take_line(const std::string& line, int number) {
    if (one_line(line).empty()) return false;
    const auto separator = line.find_first_of("=:");
    if (separator == std::string::npos)
      fail_header(fmt::format("line {}, '{}', is not 'key = value'", number, excerpt(line)));
    const auto key = one_line(line.substr(0, separator));
    const bool known = std::find(known_keys.begin(), known_keys.end(), key) != known_keys.end();
    if (known && !values_.emplace(key, trimmed(line.substr(separator + 1))).second)
      fail_header(fmt::format("{} is given twice", key));
    return key == "ElementDataFile";
  }

  std::optional<std::string> value(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::nullopt : std::optional(found->second);
  }
  std::string required(const std::string& key) const {
    const auto text = value(key);
    if (!text || text->empty()) fail_header(key + " is missing");
    return *text;
  }

  bool flag(const std::string& key, bool otherwise) const {
    const auto text = value(key);
    if (!text) return otherwise;
    const auto word = lower_case(*text);
    if (word == "true" || word == "t" || word == "1" || word == "yes") return true;
    if (word == "false" || word == "f" || word == "0" || word == "no") return false;
    fail(fmt::format("{} is '{}'", key, excerpt(*text)), "it is True or False");
  }

  std::int64_t integer(const std::string& key, std::int64_t otherwise, std::int64_t least) const {
    const auto text = value(key);
    if (!text) return otherwise;
    const auto number = number_in<std::int64_t>(*text);
    if (!number || *number < least)
      fail(fmt::format("{} is '{}'", key, excerpt(*text)),
           fmt::format("it is a whole number from {} on", least));
    return *number;
  }

  /// Reads as many numbers as the volume has dimensions, or the square of that.
  template <class T>
  std::vector<T> numbers(const std::string& key, const std::string& text, std::size_t count) const {
    std::vector<T> list;
    for (const auto& word : words_of(text)) {
      const auto number = number_in<T>(word);
      if (!number) fail(fmt::format("{}: '{}' is not a number", key, excerpt(word)), "correct the header");
      list.push_back(*number);
    }
    if (list.size() != count)
      fail(fmt::format("{} has {} numbers, {} are needed", key, list.size(), count), "correct the header");
    return list;
  }

  /// Reads the first key that is there, of several with one meaning.
  std::vector<double> reals(std::initializer_list<const char*> keys, std::size_t count) const {
    for (const char* key : keys)
      if (const auto text = value(key)) return numbers<double>(key, *text, count);
    return {};
  }

  ScalarType element_type() const {
    const auto name = required("ElementType");
    for (const auto& [known, type] : element_types)
      if (known == name) return type;
    fail(fmt::format("voxels of type '{}' cannot be rendered", excerpt(name)),
         "convert them to int32, uint32 or float32 first");
  }

  int read_dimensions() const {
    if (!value("NDims")) fail_header("NDims is missing");
    const auto n = number_in<int>(*value("NDims"));
    if (!n || *n < 2 || *n > 4)
      fail(fmt::format("NDims is '{}'", excerpt(*value("NDims"))),
           "only volumes of 3 dimensions can be rendered");
    return *n;
  }

  /// `frames`: set where the header has four dimensions.
  Grid read_grid(std::size_t count, int& frames) const {
    Grid grid;
    grid.type = element_type();
    const auto sizes = numbers<std::int64_t>("DimSize", required("DimSize"), count);
    for (std::size_t i = 0; i < count; ++i)
      if (sizes[i] < 1 || sizes[i] > std::numeric_limits<int>::max())
        fail(fmt::format("DimSize is {} along axis {}", sizes[i], i),
             "every dimension must be at least 1 and less than 2^31");
    if (count > 3) frames = int(sizes[3]);
    const auto spacing = reals({"ElementSpacing", "ElementSize"}, count);
    const auto origin = reals({"Offset", "Position", "Origin", "ImagePosition"}, count);
    const auto matrix = reals({"TransformMatrix", "Rotation", "Orientation"}, count * count);
    grid.dims = glm::ivec3(1);
    for (std::size_t i = 0; i < std::min<std::size_t>(count, 3); ++i) {
      const int axis = int(i);
      grid.dims[axis] = int(sizes[i]);
      if (!spacing.empty()) grid.spacing[axis] = spacing[i];
      if (!origin.empty()) grid.origin[axis] = origin[i];
      if (matrix.empty()) continue;
      for (std::size_t j = 0; j < std::min<std::size_t>(count, 3); ++j)
        grid.direction[axis][int(j)] = matrix[i * count + j];
    }
    return grid;
  }

  std::filesystem::path path_;
  InputFile file_;
  std::map<std::string, std::string> values_;
  std::uint64_t end_ = 0;
};

}  // namespace

MetaHeader read_meta_header(const std::filesystem::path& path) { return Reader(path).read(); }

}  // namespace ringsplat::detail
