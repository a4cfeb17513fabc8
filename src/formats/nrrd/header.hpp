#pragma once
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "formats/encoded_bytes.hpp"
#include "formats/limits.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// What an axis is of. A colour's numbers are channels, too.
enum class NrrdKind { unknown, lattice, time, list, channels, colours };

struct NrrdAxis {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  int size = 1;
  NrrdKind kind = NrrdKind::unknown;
  double spacing = none, min = none, max = none;
  bool nodes = false;             ///< min and max are where the first and the last voxels' centres are
  std::vector<double> direction;  ///< as many numbers as the space has axes; empty without a direction
  /// Of the direction.
  double length() const {
    double square = 0;
    for (const double step : direction) square += step * step;
    return std::sqrt(square);
  }
};

/// The header of an NRRD ("Definition of NRRD File Format", teem.sourceforge.net/nrrd).
struct NrrdHeader {
  std::filesystem::path path;
  ScalarType type = ScalarType::uint8;
  std::vector<NrrdAxis> axes;  ///< at least one, the fastest first
  int space_axes = 0;          ///< 0 without a space
  bool patient = false;        ///< the space is a patient's
  glm::dvec3 to_lps{1};        ///< what makes the space's axes left, posterior, superior
  std::vector<double> origin;  ///< in the space; empty without one
  Encoding encoding = Encoding::raw;
  bool big_endian = false;
  std::int64_t line_skip = 0;  ///< lines of each file before its voxels
  /// Bytes behind these lines, of the decoded ones when compressed; -1 - N: N bytes follow a file's voxels.
  std::int64_t byte_skip = 0;
  std::string data_file;            ///< a name, a pattern as "s%03d.raw 1 60 1", or LIST; empty: its own file
  std::vector<std::string> listed;  ///< names behind LIST
  std::uint64_t end = 0;            ///< the byte behind the header where its file holds the voxels

  /// Throws InputError.
  [[noreturn]] void fail(const std::string& what) const {
    refuse(path, "extract one volume, or write its axes as [component] x y z [time]", "{}", what);
  }
};

[[noreturn]] inline void fail_nrrd(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("{} is not a readable NRRD file: {}", path.string(), what),
                   "see teem.sourceforge.net/nrrd for the format");
}

/// Throws InputError for a damaged header, and for one that says what no volume may have.
NrrdHeader read_nrrd_header(const std::filesystem::path& path);

}  // namespace ringsplat::detail
