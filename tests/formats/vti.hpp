#pragma once
#include <lz4.h>
#include <lzma.h>

#include "formats/files.hpp"

namespace files {

inline std::string base64(const std::string& bytes) {
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto part = bytes.substr(i, 3);
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < part.size() ? std::uint8_t(part[k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= part.size() ? letters[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

inline std::string lz4_block(const std::string& data) {
  std::string out(std::size_t(LZ4_compressBound(int(data.size()))), '\0');
  out.resize(std::size_t(LZ4_compress_default(data.data(), out.data(), int(data.size()), int(out.size()))));
  return out;
}

inline std::string xz_stream(const std::string& data) {
  std::string out(lzma_stream_buffer_bound(data.size()), '\0');
  std::size_t size = 0;
  lzma_easy_buffer_encode(5, LZMA_CHECK_CRC32, nullptr, reinterpret_cast<const std::uint8_t*>(data.data()),
                          data.size(), reinterpret_cast<std::uint8_t*>(out.data()), &size, out.size());
  out.resize(size);
  return out;
}

/// A VTK XML ImageData file ("VTK XML formats").
struct Vti {
  std::string format = "appended", encoding = "raw", compressor = {};  ///< compressor: ZLib, LZ4 or LZMA
  bool big_endian = false, wide_numbers = false;
  bool keys_behind = false;  ///< an array's keys follow its data, as newer versions of VTK have them
  std::size_t block = 32;    ///< bytes of a compressed block
  std::string version = "1.0", extent = "0 4 0 3 0 2", piece = extent, type = "ImageData";
  std::string image = "Origin=\"0 0 0\" Spacing=\"1 2 3\"";

  struct Array {
    std::string name, type, bytes;  ///< in the file's byte order; text when the format is ascii
    int components = 1;
    bool of_cells = false;
  };
  std::vector<Array> arrays;
  std::string point_scalars, cell_scalars;

  std::string number(std::size_t value) const {
    return wide_numbers ? bytes_of(std::uint64_t(value), big_endian)
                        : bytes_of(std::uint32_t(value), big_endian);
  }

  std::string packed(const std::string& data) const {
    return compressor == "ZLib" ? zlib_stream(data) : compressor == "LZ4" ? lz4_block(data) : xz_stream(data);
  }

  std::string encoded(const std::string& data, bool in_base64) const {
    if (compressor.empty()) {
      const auto all = number(data.size()) + data;
      return in_base64 ? base64(all) : all;
    }
    std::string sizes, blocks;
    const auto count = (data.size() + block - 1) / block;
    for (std::size_t i = 0; i < count; ++i) {
      const auto one = packed(data.substr(i * block, block));
      sizes += number(one.size());
      blocks += one;
    }
    const auto head = number(count) + number(block) + number(data.size() % block) + sizes;
    return in_base64 ? base64(head) + base64(blocks) : head + blocks;
  }

  std::string file() const {
    std::string appended, lists[2];
    for (const auto& array : arrays) {
      auto& list = lists[array.of_cells ? 1 : 0];
      list += "<DataArray type=\"" + array.type + "\" Name=\"" + array.name + "\" NumberOfComponents=\"" +
              std::to_string(array.components) + "\" format=\"" + format + "\"";
      if (format == "appended") {
        list += " offset=\"" + std::to_string(appended.size()) + "\"/>\n";
        appended += encoded(array.bytes, encoding == "base64");
      } else {
        const std::string keys =
            "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\"><Value "
            "index=\"0\">0</Value></InformationKey>\n  ";
        list += ">\n" + (keys_behind ? "" : keys) +
                (format == "ascii" ? array.bytes : encoded(array.bytes, true)) + "\n" +
                (keys_behind ? keys : "") + "</DataArray>\n";
      }
    }
    const auto active = [](const std::string& name) {
      return name.empty() ? "" : " Scalars=\"" + name + "\"";
    };
    std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type + "\" version=\"" + version +
                      "\" byte_order=\"" + (big_endian ? "Big" : "Little") + "Endian\" header_type=\"UInt" +
                      (wide_numbers ? "64" : "32") + "\"";
    if (!compressor.empty()) xml += " compressor=\"vtk" + compressor + "DataCompressor\"";
    xml += ">\n<" + type + " WholeExtent=\"" + extent + "\" " + image + ">\n<Piece Extent=\"" + piece +
           "\">\n<PointData" + active(point_scalars) + ">\n" + lists[0] + "</PointData>\n<CellData" +
           active(cell_scalars) + ">\n" + lists[1] + "</CellData>\n</Piece>\n</" + type + ">\n";
    if (format == "appended")
      xml += "<AppendedData encoding=\"" + encoding + "\">\n   _" + appended + "\n  </AppendedData>\n";
    return xml + "</VTKFile>\n";
  }
};

}  // namespace files
