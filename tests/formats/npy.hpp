#pragma once
#include "formats/files.hpp"

namespace files {

/// The bytes of a NumPy array file before its voxels (NEP 1).
inline std::string npy_of_text(const std::string& text, int version = 1) {
  auto file = "\x93NUMPY" + std::string(1, char(version)) + std::string(1, '\0');
  file += version == 1 ? bytes_of(std::uint16_t(text.size())) : bytes_of(std::uint32_t(text.size()));
  return file + text;
}

inline std::string npy(const std::string& type, const std::string& shape, int version = 1,
                       bool fortran_order = false) {
  return npy_of_text("{'descr': '" + type + "', 'fortran_order': " + (fortran_order ? "True" : "False") +
                         ", 'shape': " + shape + ", }\n",
                     version);
}

}  // namespace files
