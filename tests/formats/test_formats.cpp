#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <functional>

#include "formats/files.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace files;

namespace {

std::string nrrd(const std::string& fields, const std::string& data = {}) {
  return "NRRD0004\n# test\ndimension: 3\nsizes: 5 4 3\n" + fields + "\n" + data;
}

std::string meta(const std::string& fields, const std::string& data = {}) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n" + fields + data;
}

void write_tiff(const fs::path& path, int first, int count) {
  OIIO::ImageSpec spec(nx, ny, 1, OIIO::TypeDesc::INT16);
  const auto data = samples<short>();
  auto out = OIIO::ImageOutput::create(path.string());
  REQUIRE(out);
  for (int i = 0; i < count; ++i) {
    REQUIRE(out->open(path.string(), spec,
                      i == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage));
    REQUIRE(out->write_image(OIIO::TypeDesc::INT16,
                             data.data() + std::size_t(first + i) * nx * ny * sizeof(short)));
  }
  out->close();
}

struct Format {
  const char* what;
  bool concurrent;
  std::function<fs::path(const Folder&)> make;
};

using Files = std::vector<std::pair<std::string, std::string>>;

/// Files by their names and bytes, of which the last is opened.
Format files_of(const char* what, bool concurrent, const Files& files) {
  return {what, concurrent, [=](const Folder& folder) {
            for (const auto& [name, bytes] : files) write(folder / name, bytes);
            return folder / files.back().first;
          }};
}

std::string vtk_header(const std::string& kind) {
  return "# vtk DataFile Version 3.0\ntest\n" + kind +
         "\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nSPACING 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 60\n"
         "SCALARS values short 1\nLOOKUP_TABLE default\n";
}

const std::string little = samples<short>(), big = samples<short>(true);

std::vector<Format> nrrd_formats() {
  const std::string raw = "type: short\nencoding: raw\nendian: little\n",
                    packed = "type: short\nencoding: gzip\nendian: little\n";
  std::string digits;
  for (const char c : big)
    digits += fmt::format("{}{:02X}", c % 8 == 0 ? "\n" : "", static_cast<unsigned char>(c));
  Files rows;
  std::string list;
  for (int row = 0; row < ny * nz; ++row) {
    rows.emplace_back(fmt::format("r{}.gz", row),
                      "a line\n" + gzip(little.substr(std::size_t(row) * 10, 10)));
    list += rows.back().first + "\n";
  }
  rows.emplace_back("a.nhdr", nrrd(packed + "line skip: 1\ndata file: LIST 1\n" + list));
  return {
      files_of("nrrd raw little", true, {{"a.nrrd", nrrd(raw, little)}}),
      files_of("nrrd gzip little", false, {{"a.nrrd", nrrd(packed, gzip(little))}}),
      files_of("nrrd gzip of two members", false,
               {{"a.nrrd", nrrd(packed, gzip(little.substr(0, 50)) + gzip(little.substr(50)))}}),
      files_of("nrrd ascii", false, {{"a.nrrd", nrrd("type: short\nencoding: ascii\n", text_of_samples())}}),
      files_of("nhdr detached raw at the end, after a line", true,
               {{"data.bin", "a line\nmore junk" + little},
                {"a.nhdr", nrrd(raw + "line skip: 1\nbyte skip: -1\ndata file: data.bin\n")}}),
      files_of("nhdr with one file a slice", true,
               {{"s0.bin", slice_of_samples(0)},
                {"s1.bin", slice_of_samples(1)},
                {"s2.bin", slice_of_samples(2)},
                {"a.nhdr", nrrd(raw + "data file: s%d.bin 0 2 1 2\n")}}),
      files_of("nhdr with a list of compressed rows, each behind a line", false, rows),
      files_of("nrrd hex", false, {{"a.nrrd", nrrd("type: short\nencoding: hex\nendian: big\n", digits)}}),
  };
}

std::vector<Format> meta_formats() {
  const std::string local = "ElementDataFile = LOCAL\n", beside = "ElementDataFile = a.raw\n";
  return {
      files_of("mha little", true, {{"a.mha", meta("BinaryDataByteOrderMSB = False\n" + local, little)}}),
      files_of("mha zlib", false,
               {{"a.mha", meta("CompressedData = True\nCompressedDataSize = " +
                                   std::to_string(zlib_stream(little).size()) + "\n" + local,
                               zlib_stream(little))}}),
      files_of("mha text", false, {{"a.mha", meta("BinaryData = False\n" + local, text_of_samples())}}),
      files_of("mhd big", true,
               {{"a.raw", big}, {"a.mhd", meta("BinaryDataByteOrderMSB = True\n" + beside)}}),
      files_of("mhd with the voxels at the end", true,
               {{"a.raw", "unknown header" + little}, {"a.mhd", meta("HeaderSize = -1\n" + beside)}}),
      files_of("mhd zlib beside", false,
               {{"a.raw", zlib_stream(little)}, {"a.mhd", meta("CompressedData = True\n" + beside)}}),
  };
}

std::vector<Format> other_formats() {
  Nifti pair;
  pair.magic = "ni1";
  pair.offset = 0;
  return {
      files_of("nii little", true, {{"a.nii", Nifti().header() + little}}),
      files_of("nii big", true, {{"a.nii", Nifti().header(true) + big}}),
      files_of("nii gzip", false, {{"a.nii.gz", gzip(Nifti().header() + little)}}),
      files_of("nii hdr and img", true, {{"a.img", little}, {"a.hdr", pair.header().substr(0, 348)}}),
      {"dicom folder", true, [](const Folder& f) { return write_dicom_series(f.path()), f.path(); }},
      {"dicom series by one file", true,
       [](const Folder& f) { return write_dicom_series(f.path()), f / "image2.dcm"; }},
      {"tiff pages", true, [](const Folder& f) { return write_tiff(f / "a.tif", 0, nz), f / "a.tif"; }},
      {"tiff folder", true,
       [](const Folder& f) {
         const char* names[] = {"slice2.tif", "slice10.tif", "slice11.tiff"};
         for (int z = 0; z < nz; ++z) write_tiff(f / names[z], z, 1);
         return f.path();
       }},
      files_of("vtk binary", true, {{"a.vtk", vtk_header("BINARY") + big}}),
      files_of("vtk text", false, {{"a.vtk", vtk_header("ASCII") + text_of_samples()}}),
      files_of("raw by its name", true, {{"a_5x4x3_int16.raw", little}}),
  };
}

std::vector<Format> formats() {
  std::vector<Format> all = nrrd_formats();
  for (const auto& more : {meta_formats(), other_formats()}) all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// A cut TIFF may only lack what no voxel needs, such as its resolution.
bool refused_or_unharmed(const fs::path& path) {
  try {
    return read_all(*open_volume(path)) == samples<short>();
  } catch (const InputError&) {
    return true;
  }
}

}  // namespace

TEST_CASE("every format gives the same voxels, whole, by slice and backwards, and prints nothing to stdout",
          "[formats]") {
  for (const auto& format : formats()) {
    CAPTURE(format.what);
    const Folder folder;
    std::ostringstream printed;
    auto* const before = std::cout.rdbuf(printed.rdbuf());
    const auto source = open_volume(format.make(folder));
    const bool same = is_sample(*source);
    std::cout.rdbuf(before);
    CHECK(same);
    CHECK(source->concurrent() == format.concurrent);
    CHECK(printed.str().empty());
  }
}

TEST_CASE("a file with its voxels in it is refused wherever it is cut", "[formats]") {
  for (const auto& format : formats()) {
    const Folder folder;
    const auto path = format.make(folder);
    const std::string what = format.what, ending = path.extension().string();
    const bool header_only = ending == ".nhdr" || ending == ".mhd" || ending == ".hdr";
    // Text cut within its last number still ends in a number.
    const bool text = what.find("text") != std::string::npos || what.find("ascii") != std::string::npos;
    if (fs::is_directory(path) || header_only || text) continue;
    const auto whole = slurp(path);
    for (std::size_t length = 0; length < whole.size(); length += length + 130 < whole.size() ? 11 : 1) {
      write(path, whole.substr(0, length));
      CAPTURE(format.what, length, whole.size());
      if (ending == ".tif")
        CHECK(refused_or_unharmed(path));
      else
        CHECK_THROWS_AS(read_all(*open_volume(path)), InputError);
    }
  }
}

TEST_CASE("all scalar types in both orders, raw and gzip", "[formats]") {
  const struct {
    ScalarType type;
    const char *name, *meta_name;
  } types[] = {{ScalarType::int8, "int8", "MET_CHAR"},      {ScalarType::uint8, "uint8", "MET_UCHAR"},
               {ScalarType::int16, "int16", "MET_SHORT"},   {ScalarType::uint16, "uint16", "MET_USHORT"},
               {ScalarType::int32, "int32", "MET_INT"},     {ScalarType::uint32, "uint32", "MET_UINT"},
               {ScalarType::float32, "float", "MET_FLOAT"}, {ScalarType::float64, "double", "MET_DOUBLE"}};
  const Folder folder;
  for (const auto& [type, name, meta_name] : types) {
    CAPTURE(name);
    const std::string expected = samples_of(type);
    for (const bool big : {false, true})
      for (const bool packed : {false, true}) {
        const auto data = samples_of(type, big);
        const auto fields = fmt::format("type: {}\nencoding: {}\nendian: {}\n", name, packed ? "gzip" : "raw",
                                        big ? "big" : "little");
        const auto source = open_volume(write(folder / "a.nrrd", nrrd(fields, packed ? gzip(data) : data)));
        CHECK(source->grid().type == type);
        CHECK((read_all(*source) == expected));
      }
    RawDescription raw;
    raw.dims = glm::ivec3(nx, ny, nz);
    raw.type = type;
    raw.big_endian = true;
    CHECK((read_all(*open_volume(write(folder / "plain.bin", samples_of(type, true)), raw)) == expected));
    const auto header = fmt::format(
        "NDims = 3\nDimSize = 5 4 3\nElementType = {}\nBinaryDataByteOrderMSB = True\nElementDataFile = "
        "LOCAL\n",
        meta_name);
    const auto from_meta = open_volume(write(folder / "a.mha", header + samples_of(type, true)));
    CHECK(from_meta->grid().type == type);
    CHECK((read_all(*from_meta) == expected));
  }
}

TEST_CASE("DICOM slices of different rescaling become floats of the same meaning", "[formats]") {
  const Folder folder;
  const char* slopes[] = {"1", "0.5", "0.25"};
  for (int z = 0; z < nz; ++z) {
    Dicom slice;
    slice.number = z + 1;
    slice.slope = std::string(slopes[z]);
    slice.position = "0\\0\\" + std::to_string(z);
    slice.pixels = slice_of_samples(z);
    write(folder / (fmt::format("s{}", z)), slice.bytes());
  }
  const auto source = open_volume(folder.path());
  REQUIRE(source->grid().type == ScalarType::float32);
  const auto bytes = read_all(*source);
  const auto* values = reinterpret_cast<const float*>(bytes.data());
  CHECK(values[3] == float(sample<short>(3, 0, 0)));
  CHECK(values[20 + 3] == float(sample<short>(3, 0, 1)) * 0.5F);
  CHECK(values[40 + 3] == float(sample<short>(3, 0, 2)) * 0.25F);
}
