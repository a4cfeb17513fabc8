#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// The header of a legacy VTK file of structured points (VTK file formats, "Simple legacy formats"), up to
/// its first SCALARS, COLOR_SCALARS or VECTORS.
struct VtkHeader {
  Grid grid;
  bool binary = false;  ///< big-endian; else numbers in text
  int components = 1;   ///< numbers in a voxel
  std::uint64_t end = 0;
};

constexpr const char* other_hint = "write it as STRUCTURED_POINTS with scalars, or as .nrrd or .mhd";

/// Reads the words of each line, of which the first is the key.
class VtkHeaderReader {
 public:
  explicit VtkHeaderReader(const std::filesystem::path& path) : file_(path), text_(file_) {}

  VtkHeader read() {
    constexpr int most_lines = 100;  // a header has a dozen
    if (const auto magic = text_.line(); !magic || !lower_case(*magic).starts_with("# vtk datafile"))
      fail("is not a legacy VTK file");
    text_.line();  // the title
    for (int i = 0; i < most_lines; ++i) {
      const auto line = text_.line();
      if (!line) break;
      words_ = words_of(lower_case(*line));
      if (!words_.empty() && take_line()) return header_;
    }
    fail("is not a legacy VTK file with SCALARS");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{} {}", file_.path().string(), what), other_hint);
  }
  [[noreturn]] void fail_line() const {
    refuse(file_.path(), "correct the header", "its header has a line '{}'", excerpt(joined(words_, " ")));
  }

  /// True for the header's last line.
  bool take_line() {
    const auto& key = words_[0];
    if (key == "ascii" || key == "binary") {
      header_.binary = key == "binary";
      has_encoding_ = true;
    } else if (key == "dataset") {
      if (words_.size() < 2 || words_[1] != "structured_points") fail("holds no STRUCTURED_POINTS");
    } else if (key == "dimensions") {
      take_dimensions();
    } else if (key == "spacing" || key == "aspect_ratio") {
      header_.grid.spacing = {number<double>(1), number<double>(2), number<double>(3)};
    } else if (key == "origin") {
      header_.grid.origin = {number<double>(1), number<double>(2), number<double>(3)};
    } else if (key == "cell_data") {
      fail("holds values of cells");
    } else {
      return take_values(key);
    }
    return false;
  }

  void take_dimensions() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto size = number<std::int64_t>(axis + 1);
      if (size > std::numeric_limits<int>::max())
        refuse(file_.path(), "correct the sizes in the header", "{} voxels along axis {}", size, axis);
      header_.grid.dims[int(axis)] = int(std::max<std::int64_t>(size, -1));
    }
  }

  bool take_values(const std::string& key) {
    if (key == "scalars") {
      header_.grid.type = type(2);
      header_.components = words_.size() > 3 ? number<int>(3) : 1;
    } else if (key == "color_scalars") {
      // In text they are numbers from 0 to 1.
      header_.grid.type = header_.binary ? ScalarType::uint8 : ScalarType::float32;
      header_.components = number<int>(2);
    } else if (key == "vectors") {
      header_.grid.type = type(2);
      header_.components = 3;
    } else {
      return false;
    }
    if (!has_encoding_) fail("is neither ASCII nor BINARY");
    if (header_.components < 1) fail_line();
    header_.end = text_.position();
    if (const auto next = text_.line(); next && lower_case(*next).starts_with("lookup_table"))
      header_.end = text_.position();
    return true;
  }

  template <class T>
  T number(std::size_t word) const {
    const auto value = word < words_.size() ? number_in<T>(words_[word]) : std::nullopt;
    if (!value) fail_line();
    return *value;
  }

  ScalarType type(std::size_t word) const {
    if (word >= words_.size()) fail_line();
    auto name = words_[word];
    std::replace(name.begin(), name.end(), '_', ' ');
    return voxel_type(file_.path(), name == "char" ? "schar" : name);
  }

  InputFile file_;
  TextReader text_;
  VtkHeader header_;
  std::vector<std::string> words_;  ///< of the line
  bool has_encoding_ = false;
};

}  // namespace

std::unique_ptr<VolumeSource> open_vtk(const std::filesystem::path& path, const VolumeChoice& choice) {
  const VtkHeader header = VtkHeaderReader(path).read();
  const auto& grid = header.grid;
  const auto wide = interleaved_grid(grid, header.components, path.string());
  const StoredVoxels stored{.file = path,
                            .offset = header.end,
                            .encoding = header.binary ? Encoding::raw : Encoding::text,
                            .big_endian = true,
                            .type = grid.type};
  return with_notes(
      channel_source(stored_source(wide, {stored}), grid, header.components, choice.channel, path.string()),
      {.channels = header.components});
}

}  // namespace ringsplat::detail
