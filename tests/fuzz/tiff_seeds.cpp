#include <algorithm>
#include <map>

#include "formats/files.hpp"
#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {
namespace {

using namespace files;

/// An array that does not fit into its directory entry.
struct TiffArray {
  int type, item_bytes;  ///< type: 1 bytes, 2 text, 4 long numbers
  Input bytes;
};

/// A stack of pages with one strip or tile each, byte by byte (TIFF 6.0, section 2).
struct TiffStack {
  bool big_endian = false, tiled = false;
  int compression = 1, format = 2, bits = 16;  ///< format: 1 unsigned, 2 signed, 3 floating point
  std::vector<Input> pages;                    ///< in their stored form
  std::map<int, TiffArray> arrays = {};        ///< of every page, by their tags

  void describe(const Input& text) { arrays[270] = {2, 1, text + '\0'}; }

  Input bytes() const {
    Input out = big_endian ? Input("MM\0*", 4) : Input("II*\0", 4);
    std::size_t link = out.size();
    out += bytes_of(std::uint32_t{0}, big_endian);
    for (const Input& page : pages) {
      const auto at = std::uint32_t(out.size());
      out += page;
      for (const auto& [tag, array] : arrays) out += array.bytes;
      if (out.size() % 2 != 0) out += '\0';
      const Input offset = bytes_of(std::uint32_t(out.size()), big_endian);
      out.replace(link, 4, offset);
      link = out.size() + 2 + 12 * fields(at, page).size();
      out += bytes_of(std::uint16_t(fields(at, page).size()), big_endian);
      for (const auto& [tag, value] : fields(at, page)) out += entry(tag, value);
      out += bytes_of(std::uint32_t{0}, big_endian);
    }
    return out;
  }

 private:
  Input entry(int tag, std::uint32_t value) const {
    const auto array = arrays.find(tag);
    const bool is_number = array == arrays.end();
    const auto type = is_number ? 4 : array->second.type;
    const auto count = is_number ? 1 : array->second.bytes.size() / std::size_t(array->second.item_bytes);
    return bytes_of(std::uint16_t(tag), big_endian) + bytes_of(std::uint16_t(type), big_endian) +
           bytes_of(std::uint32_t(count), big_endian) + bytes_of(value, big_endian);
  }

  std::map<int, std::uint32_t> fields(std::uint32_t at, const Input& page) const {
    std::map<int, std::uint32_t> all{
        {256, nx}, {257, ny}, {258, std::uint32_t(bits)},  {259, std::uint32_t(compression)},
        {262, 1},  {277, 1},  {339, std::uint32_t(format)}};
    if (tiled) {
      all.insert({{322, 16}, {323, 16}, {324, at}, {325, std::uint32_t(page.size())}});
    } else {
      all.insert({{273, at}, {278, ny}, {279, std::uint32_t(page.size())}});
    }
    std::size_t begin = at + page.size();
    for (const auto& [tag, array] : arrays) {
      all.insert({tag, std::uint32_t(begin)});
      begin += array.bytes.size();
    }
    return all;
  }
};

/// Packs as literal runs only, which every PackBits decoder takes (TIFF 6.0, section 9).
Input pack_bits(const Input& data) {
  constexpr std::size_t longest = 128;
  Input out;
  for (std::size_t at = 0; at < data.size(); at += longest) {
    const std::size_t count = std::min(longest, data.size() - at);
    out += char(count - 1) + data.substr(at, count);
  }
  return out;
}

std::vector<Input> slices(const Input& all) {
  std::vector<Input> pages;
  const std::size_t bytes = all.size() / nz;
  for (std::size_t z = 0; z < nz; ++z) pages.push_back(all.substr(z * bytes, bytes));
  return pages;
}

/// Blocks of ImageJ's: one of ranges and two of colours.
void add_channels(TiffStack& stack) {
  const Input header =
      "JIJI" + Input("gnar") + bytes_of(std::uint32_t{1}) + "stul" + bytes_of(std::uint32_t{2});
  const Input ranges = bytes_of(3.0) + bytes_of(200.5) + bytes_of(0.0) + bytes_of(65535.0);
  Input lengths;
  for (const std::size_t bytes : {header.size(), ranges.size(), std::size_t{768}, std::size_t{768}})
    lengths += bytes_of(std::uint32_t(bytes));
  stack.arrays[50838] = {4, 4, lengths};
  stack.arrays[50839] = {1, 1, header + ranges + Input(2 * 768, 'c')};
}

/// Of 16 bits, rows without a filter (PNG, third edition).
Input png(const Input& pixels) {
  const auto chunk = [](const Input& data) {
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(data.data()), uInt(data.size()));
    return bytes_of(std::uint32_t(data.size() - 4), true) + data + bytes_of(std::uint32_t(sum), true);
  };
  Input rows;
  for (std::size_t at = 0; at < pixels.size(); at += 2 * nx) rows += '\0' + pixels.substr(at, 2 * nx);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR" + bytes_of(nx, true) + bytes_of(ny, true) + Input("\x10\0\0\0\0", 5)) +
         chunk("IDAT" + zlib_stream(rows)) + chunk("IEND");
}

}  // namespace

std::vector<Input> tiff_seeds() {
  TiffStack little{.pages = slices(samples<short>())},
      big{.big_endian = true, .pages = slices(samples<short>(true))};
  TiffStack floats{.format = 3, .bits = 32, .pages = slices(samples<float>())};
  TiffStack deflated{.compression = 8, .pages = little.pages},
      packed{.compression = 32773, .pages = little.pages};
  for (Input& page : deflated.pages) page = zlib_stream(page);
  for (Input& page : packed.pages) page = pack_bits(page);
  TiffStack tiles{.tiled = true, .format = 1, .bits = 8, .pages = std::vector<Input>(2, Input(256, 't'))};
  TiffStack ome{.pages = slices(samples<short>())}, image_j = ome, behind = ome;
  ome.describe(
      "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeX=\"5\" SizeY=\"4\" "
      "SizeZ=\"1\" SizeC=\"3\" SizeT=\"1\" PhysicalSizeX=\"0.2\" PhysicalSizeXUnit=\"nm\" "
      "PhysicalSizeZ=\"1\"><Channel Name=\"a&lt;\" SamplesPerPixel=\"1\"/><Channel/><Channel/>"
      "<TiffData IFD=\"0\" FirstC=\"0\" PlaneCount=\"2\"/><TiffData IFD=\"2\" "
      "FirstC=\"2\"/></Pixels></Image></OME>");
  image_j.describe(
      "ImageJ=1.53t\nimages=3\nchannels=3\nslices=1\nframes=1\nhyperstack=true\nunit=\\u00B5m\nspacing=2\n");
  add_channels(image_j);
  behind.describe("ImageJ=1.53t\nimages=2\nslices=2\n");
  behind.pages.resize(1);
  return {ome.bytes(),       image_j.bytes(),  behind.bytes() + samples<short>(),
          little.bytes(),    big.bytes(),      floats.bytes(),
          png(big.pages[0]), deflated.bytes(), packed.bytes(),
          tiles.bytes()};
}

}  // namespace ringsplat::fuzz
