#pragma once
#include <fmt/format.h>

#include <map>

#include "formats/files.hpp"

namespace files {

/// The metadata of an array of version 3; what a test changes are words of it.
inline std::string zarr_json(const std::map<std::string, std::string>& changed = {}) {
  std::string text = R"({"zarr_format": 3, "node_type": "array", "shape": [3, 4, 5], "data_type": "int16",
 "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 4, 5]}},
 "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}, "fill_value": 0,
 "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}], "attributes": {}})";
  for (const auto& [from, to] : changed) text.replace(text.find(from), from.size(), to);
  return text;
}

/// The sample volume's chunks of two slices.
inline std::string zarr_chunk(int number) {
  return (samples<short>() + std::string(40, '\0')).substr(std::size_t(number) * 80, 80);
}

/// Writes an array; its chunks by `packed`.
inline fs::path write_zarr(const fs::path& folder, const std::string& json,
                           std::string (*packed)(const std::string&) = nullptr) {
  for (int z = 0; z < 2; ++z) {
    const auto path = folder / fmt::format("c/{}/0", z);
    fs::create_directories(path);
    write(path / "0", packed != nullptr ? packed(zarr_chunk(z)) : zarr_chunk(z));
  }
  write(folder / "zarr.json", json);
  return folder;
}

/// The metadata of an N5 array, and what is before the numbers of a block of so many slices.
inline std::string n5_json(const std::map<std::string, std::string>& changed = {}) {
  std::string text = R"({"dimensions": [5, 4, 3], "blockSize": [5, 4, 2], "dataType": "int16",
 "compression": {"type": "raw"}})";
  for (const auto& [from, to] : changed) text.replace(text.find(from), from.size(), to);
  return text;
}
inline std::string n5_head(int slices) {
  return std::string("\0\0\0\3", 4) + bytes_of(nx, true) + bytes_of(ny, true) + bytes_of(slices, true);
}

inline const std::string zarr_gzip = R"(}, {"name": "gzip", "configuration": {"level": 5}}])";

}  // namespace files
