#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// The header of a MetaImage (Insight Journal, "MetaIO/Documentation"): lines of "key = value", the last of
/// which is ElementDataFile.
struct MetaHeader {
  std::filesystem::path path;
  Grid grid;
  int dimensions = 3;  ///< NDims, 2 to 4
  int frames = 1;      ///< along the fourth dimension
  int channels = 1;    ///< numbers in a voxel
  bool binary = true;  ///< else the voxels are numbers in text
  bool compressed = false;
  bool big_endian = std::endian::native == std::endian::big;
  std::int64_t header_size = 0;  ///< bytes before a data file's voxels; -1: the voxels are its last bytes
  std::string data_file;         ///< value of ElementDataFile: a name, or a pattern or list of names
  std::uint64_t end = 0;         ///< the byte after the header

  /// Throws InputError of the data file's name.
  template <class... Args>
  [[noreturn]] void fail(const std::string& hint, fmt::format_string<Args...> what, Args&&... args) const {
    refuse(path, hint, "ElementDataFile '{}' {}", excerpt(data_file),
           fmt::format(what, std::forward<Args>(args)...));
  }
  bool is_local() const { return data_file == "LOCAL" || data_file == "Local" || data_file == "local"; }
};

constexpr std::uint64_t longest_header = 1 << 20;  // bytes; a header has a few hundred

/// Reads and checks every field that matters here, and only the form of other lines. (MetaIO itself does not
/// check.) Throws InputError naming the file and the field.
class MetaReader {
 public:
  explicit MetaReader(const std::filesystem::path& path) : file_(path) {}

  MetaHeader read() {
    read_lines();
    MetaHeader header;
    header.path = file_.path();
    header.end = end_;
    header.data_file = required("ElementDataFile");
    if (std::ranges::any_of(header.data_file, [](unsigned char c) { return std::iscntrl(c); }))
      refuse(file_.path(), "correct the header", "ElementDataFile '{}' has control characters",
             excerpt(header.data_file));
    if (const auto type = value("ObjectType"); type && *type != "Image")
      refuse(file_.path(), "only an Image is a volume", "ObjectType is '{}'", excerpt(*type));
    header.binary = flag("BinaryData", true);
    header.compressed = flag("CompressedData", false);
    header.big_endian = flag("BinaryDataByteOrderMSB", flag("ElementByteOrderMSB", header.big_endian));
    header.header_size = integer("HeaderSize", 0, -1);
    integer("CompressedDataSize", 0, 0);
    const auto channels = integer("ElementNumberOfChannels", 1, 1);
    if (channels > std::numeric_limits<int>::max())
      refuse(file_.path(), "correct the header", "ElementNumberOfChannels is {}", channels);
    header.channels = int(channels);
    header.dimensions = read_dimensions();
    header.grid = read_grid(std::size_t(header.dimensions), header.frames);
    return header;
  }

 private:
  [[noreturn]] void fail_header(const std::string& what) const {
    throw InputError(fmt::format("{} has no readable MetaImage header: {}", file_.path().string(), what),
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
    values_.emplace(key, trimmed(line.substr(separator + 1)));
    return key == "ElementDataFile";
  }

  std::optional<std::string> value(const std::string& key) const {
    if (values_.count(key) > 1) fail_header(fmt::format("{} is given twice", key));
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
    refuse(file_.path(), "it is True or False", "{} is '{}'", key, excerpt(*text));
  }

  std::int64_t integer(const std::string& key, std::int64_t otherwise, std::int64_t least) const {
    const auto text = value(key);
    if (!text) return otherwise;
    const auto number = number_in<std::int64_t>(*text);
    if (!number || *number < least)
      refuse(file_.path(), fmt::format("it is a whole number from {} on", least), "{} is '{}'", key,
             excerpt(*text));
    return *number;
  }

  /// Reads as many numbers as the volume has dimensions, or the square of that.
  template <class T>
  std::vector<T> numbers(const std::string& key, const std::string& text, std::size_t count) const {
    auto list = mapped(words_of(text), [&](const std::string& word) {
      const auto number = number_in<T>(word);
      if (!number) refuse(file_.path(), "correct the header", "{}: '{}' is not a number", key, excerpt(word));
      return *number;
    });
    if (list.size() != count)
      refuse(file_.path(), "correct the header", "{} has {} numbers, {} are needed", key, list.size(), count);
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
    const auto* const found = std::find(std::begin(meta_types), std::end(meta_types), name);
    if (found != std::end(meta_types)) return ScalarType(found - std::begin(meta_types));
    // They have 4 bytes wherever they were written.
    return voxel_type(file_.path(), name == "MET_LONG" ? "int32" : name == "MET_ULONG" ? "uint32" : name);
  }

  int read_dimensions() const {
    if (!value("NDims")) fail_header("NDims is missing");
    const auto n = number_in<int>(*value("NDims"));
    if (!n || *n < 2 || *n > 4)
      refuse(file_.path(), "only volumes of 3 dimensions can be rendered", "NDims is '{}'",
             excerpt(*value("NDims")));
    return *n;
  }

  /// `frames`: set where the header has four dimensions.
  Grid read_grid(std::size_t count, int& frames) const {
    Grid grid;
    grid.type = element_type();
    const auto sizes = numbers<std::int64_t>("DimSize", required("DimSize"), count);
    for (std::size_t i = 0; i < count; ++i)
      if (sizes[i] < 1 || sizes[i] > std::numeric_limits<int>::max())
        refuse(file_.path(), "every dimension must be at least 1 and less than 2^31",
               "DimSize is {} along axis {}", sizes[i], i);
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

  InputFile file_;
  std::multimap<std::string, std::string> values_;
  std::uint64_t end_ = 0;
};

constexpr const char* pattern_hint = "write it as 'NAME%03d.raw FIRST LAST STEP'";

/// By "NAME FIRST LAST STEP", of which any numbers may be missing at the end. The name may have blanks only
/// when all three are given.
std::vector<std::string> names_of_pattern(const MetaHeader& header, std::int64_t files) {
  auto name = words_of(header.data_file);
  std::vector<std::int64_t> given;
  const auto numbers = name.size() > 4 ? 3 : name.size() - 1;
  for (auto word = name.end() - std::ptrdiff_t(numbers); word != name.end(); ++word) {
    const auto number = number_in<std::int32_t>(*word);
    if (!number || *number < 0)
      header.fail(pattern_hint, "has '{}' where a whole number belongs", excerpt(*word));
    given.push_back(*number);
  }
  name.resize(name.size() - numbers);
  const auto first = numbers > 0 ? given[0] : 1, last = numbers > 1 ? given[1] : first + files - 1;
  std::int64_t step = 1;
  if (numbers > 2)
    step = given[2];
  else if (files > 1)
    step = (last - first) / (files - 1);
  if (step < 1) header.fail(pattern_hint, "counts in steps of {}", step);
  const auto found = last < first ? 0 : (last - first) / step + 1;
  if (found != files)
    header.fail("correct the numbers behind the name, or DimSize", "names {} files, DimSize asks for {}",
                found, files);
  const auto names = numbered_names(joined(name, " "), first, files, step);
  if (names.empty())
    header.fail(pattern_hint,
                "is no pattern of file names: it needs one %d and nothing else with a percent sign");
  return names;
}

/// The lines behind the header; empty ones are skipped.
std::vector<std::string> names_of_list(const MetaHeader& header, std::int64_t files) {
  const InputFile file(header.path);
  TextReader text(file, header.end);
  std::vector<std::string> names;
  for (auto line = text.line(); line; line = text.line())
    if (const auto name = trimmed(*line); !name.empty()) names.push_back(name);
  if (std::int64_t(names.size()) != files)
    header.fail("give one file name a line", "names {} files, DimSize asks for {}", names.size(), files);
  return names;
}

bool is_list(const MetaHeader& header) { return words_of(header.data_file).front() == "LIST"; }

/// "LIST 2" and "LIST 3" say how many dimensions a file has; without a number it is one less than the volume.
int dimensions_of_a_file(const MetaHeader& header) {
  const auto words = words_of(header.data_file);
  int dimensions = header.dimensions - 1;
  if (is_list(header) && words.size() > 1) {
    const auto number = number_in<int>(
        lower_case(words[1]).ends_with('d') ? words[1].substr(0, words[1].size() - 1) : words[1]);
    if (words.size() > 2 || !number || *number < 2 || *number > 3)
      header.fail("a LIST is of files of 2 or 3 dimensions", "cannot be read");
    dimensions = *number;
  }
  if (dimensions < 2) header.fail("put whole slices into files", "names files of single lines");
  return dimensions;
}

/// The offset of one file's voxels. HeaderSize applies only to uncompressed voxels in a file of their own.
std::uint64_t voxel_offset(const MetaHeader& header, const std::filesystem::path& file,
                           std::uint64_t voxel_bytes) {
  if (header.is_local()) return header.end;
  if (header.compressed) return 0;
  if (header.header_size >= 0) return std::uint64_t(header.header_size);
  const auto size = InputFile(file).size();
  return header.binary ? size - std::min(size, voxel_bytes) : 0;
}

/// `grid`: of one frame.
std::unique_ptr<VolumeSource> open_slice_files(const MetaHeader& header, const Grid& grid, int frame) {
  if (!header.binary || header.compressed)
    header.fail("write the volume into one file", "names several files of {}",
                header.binary ? "compressed voxels" : "text");
  const std::int64_t files_of_frame = dimensions_of_a_file(header) > 2 ? 1 : grid.dims.z;
  const std::int64_t files = files_of_frame * header.frames;
  const auto names = is_list(header) ? names_of_list(header, files) : names_of_pattern(header, files);
  std::vector<StoredVoxels> pieces;
  for (std::int64_t k = 0; k < files_of_frame; ++k) {
    StoredVoxels piece{.file = header.path.parent_path() / names[std::size_t(frame * files_of_frame + k)],
                       .big_endian = header.big_endian,
                       .type = grid.type};
    piece.offset = voxel_offset(header, piece.file, grid.bytes() / std::uint64_t(files_of_frame));
    pieces.push_back(std::move(piece));
  }
  return stored_source(grid, std::move(pieces));
}

/// The interleaved voxels of one frame, which the header describes.
std::unique_ptr<VolumeSource> source_of(const MetaHeader& header, const Grid& grid, int frame) {
  if (is_list(header) || header.data_file.find('%') != std::string::npos)
    return open_slice_files(header, grid, frame);
  const auto file = header.is_local() ? header.path : header.path.parent_path() / header.data_file;
  if (!header.binary && header.frames > 1)
    header.fail("write them in binary", "has {} volumes in text", header.frames);
  StoredVoxels stored{.file = file,
                      .encoding = !header.binary      ? Encoding::text
                                  : header.compressed ? Encoding::deflate
                                                      : Encoding::raw,
                      .big_endian = header.big_endian,
                      .type = grid.type};
  const auto total = bytes_of_volumes(header.path, grid.bytes(), std::uint64_t(header.frames));
  stored.offset = voxel_offset(header, file, total);
  if (header.binary) stored.choose(grid.bytes(), header.frames, frame);
  return stored_source(grid, {stored});
}

}  // namespace

std::unique_ptr<VolumeSource> open_meta(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = MetaReader(path).read();
  const auto wide = interleaved_grid(header.grid, header.channels, path.string());
  auto source = source_of(header, wide, chosen_frame(choice, header.frames, path));
  source = channel_source(std::move(source), header.grid, header.channels, choice.channel, path.string());
  return with_notes(
      std::move(source),
      {.world = World::patient, .unit = "mm", .frames = header.frames, .channels = header.channels});
}

}  // namespace ringsplat::detail
