#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/encoded_bytes.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// One DataArray, and how its file has binary data. Its type may be none that a volume can have.
struct VtiArray {
  std::string name, type;
  bool of_cells = false;  ///< else of points
  int components = 1;
  Encoding format = Encoding::text;  ///< else base64, or appended as it is
  std::uint64_t begin = 0,
                end = 0;  ///< bytes of the file that hold it; appended data ends where the file does
  bool big_endian = false;
  int header_bytes = 4;  ///< of a number before binary data
  Compressor compressor = Compressor::none;
};

struct VtiPiece {
  std::filesystem::path file;
  glm::ivec3 first{0}, last{0};  ///< its points, also those that it only has beside other pieces
  std::vector<VtiArray> arrays;  ///< of points and cells
};

/// A .vti file's XML ("VTK XML formats", ImageData), up to the appended data, or a .pvti file's and that of
/// its pieces.
struct VtiHeader {
  glm::dvec3 origin{0}, spacing{1};
  glm::dmat3 direction{1};
  glm::ivec3 first{0}, last{0};             ///< the whole's points
  int ghosts = 0;                           ///< cells that pieces have of their neighbours
  std::string point_scalars, cell_scalars;  ///< the active arrays' names; empty: none
  std::vector<VtiPiece> pieces;             ///< at least one
};

/// Throws InputError naming the file and the line: no XML, another kind of file, missing or damaged
/// attributes.
VtiHeader read_vti_header(const std::filesystem::path& path);

}  // namespace ringsplat::detail
