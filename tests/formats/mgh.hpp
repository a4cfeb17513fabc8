#pragma once
#include <array>

#include "formats/files.hpp"

namespace files {

/// A MGH header of 284 bytes; `type`: 0 uint8, 4 int16.
struct Mgh {
  std::array<int, 4> sizes{nx, ny, nz, 1};
  int version = 1, type = 4;
  bool has_place = true;
  std::array<float, 15> place{1, 2, 3, -1, 0, 0, 0, 0, -1, 0, 1, 0, 10, 20, 30};

  std::string header() const {
    std::string bytes = bytes_of(version, true);
    for (const int size : sizes) bytes += bytes_of(size, true);
    bytes += bytes_of(type, true) + bytes_of(0) + bytes_of(short(has_place ? 1 : 0), true);
    for (const float number : place) bytes += bytes_of(number, true);
    bytes.resize(284);
    return bytes;
  }
};

}  // namespace files
