#pragma once
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// The header of a MetaImage (Insight Journal, "MetaIO/Documentation"): lines of "key = value", the last of
/// which is ElementDataFile.
struct MetaHeader {
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

  bool is_local() const { return data_file == "LOCAL" || data_file == "Local" || data_file == "local"; }
};

/// Reads and checks every field that matters here, and only the form of other lines. (MetaIO itself does not
/// check.) Throws InputError naming the file and the field.
MetaHeader read_meta_header(const std::filesystem::path& path);

}  // namespace ringsplat::detail
