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

std::string vtk_header(const std::string& kind) {
  return "# vtk DataFile Version 3.0\ntest\n" + kind +
         "\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nSPACING 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 60\n"
         "SCALARS values short 1\nLOOKUP_TABLE default\n";
}

const std::string little = samples<short>(), big = samples<short>(true);

std::vector<Format> nrrd_formats() {
  return {
      {"nrrd raw little", true,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: short\nencoding: raw\nendian: little\n", little));
       }},
      {"nrrd raw big", true,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: int16\nencoding: raw\nendian: big\n", big));
       }},
      {"nrrd gzip little", false,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: short\nencoding: gzip\nendian: little\n", gzip(little)));
       }},
      {"nrrd gzip big", false,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: short\nencoding: gz\nendian: big\n", gzip(big)));
       }},
      {"nrrd gzip of two members", false,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: short\nencoding: gzip\nendian: little\n",
                                         gzip(little.substr(0, 50)) + gzip(little.substr(50))));
       }},
      {"nrrd ascii", false,
       [](const Folder& f) {
         return write(f / "a.nrrd", nrrd("type: short\nencoding: ascii\n", text_of_samples()));
       }},
      {"nhdr detached raw with a byte skip", true,
       [](const Folder& f) {
         write(f / "data.bin", "junk" + little);
         return write(
             f / "a.nhdr",
             nrrd("type: short\nencoding: raw\nendian: little\nbyte skip: 4\ndata file: data.bin\n"));
       }},
      {"nhdr detached raw at the end, after a line", true,
       [](const Folder& f) {
         write(f / "data.bin", "a line\nmore junk" + big);
         return write(f / "a.nhdr", nrrd("type: short\nencoding: raw\nendian: big\nline skip: 1\nbyte skip: "
                                         "-1\ndata file: data.bin\n"));
       }},
      {"nhdr detached gzip with a byte skip in the decoded data", false,
       [](const Folder& f) {
         write(f / "data.raw.gz", gzip("xyz" + little));
         return write(f / "a.nhdr", nrrd("type: short\nencoding: gzip\nendian: little\nbyte skip: 3\n"
                                         "data file: data.raw.gz\n"));
       }},
      {"nhdr with one file a slice", true,
       [](const Folder& f) {
         for (int z = 0; z < nz; ++z)
           write(f / fmt::format("s{}.bin", z), little.substr(std::size_t(z) * 40, 40));
         return write(f / "a.nhdr",
                      nrrd("type: short\nencoding: raw\nendian: little\ndata file: s%d.bin 0 2 1 2\n"));
       }},
      {"nhdr with a list of compressed rows, each behind a line", false,
       [](const Folder& f) {
         std::string list;
         for (int row = 0; row < ny * nz; ++row) {
           const auto name = fmt::format("r{}.gz", row);
           write(f / name, "a line\n" + gzip(little.substr(std::size_t(row) * 10, 10)));
           list += name + "\n";
         }
         return write(f / "a.nhdr", nrrd("type: short\nencoding: gzip\nendian: little\nline skip: 1\n"
                                         "data file: LIST 1\n" +
                                         list));
       }},
      {"nrrd hex", false,
       [](const Folder& f) {
         std::string digits;
         for (const char c : big)
           digits += fmt::format("{}{:02X}", c % 8 == 0 ? "\n" : "", static_cast<unsigned char>(c));
         return write(f / "a.nrrd", nrrd("type: short\nencoding: hex\nendian: big\n", digits));
       }},
  };
}

std::vector<Format> meta_formats() {
  return {
      {"mha little", true,
       [](const Folder& f) {
         return write(
             f / "a.mha",
             meta("BinaryData = True\nBinaryDataByteOrderMSB = False\nElementDataFile = LOCAL\n", little));
       }},
      {"mha zlib", false,
       [](const Folder& f) {
         const auto packed = zlib_stream(little);
         return write(f / "a.mha", meta("BinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
                                        "True\nCompressedDataSize = " +
                                            std::to_string(packed.size()) + "\nElementDataFile = LOCAL\n",
                                        packed));
       }},
      {"mha text", false,
       [](const Folder& f) {
         return write(f / "a.mha", meta("BinaryData = False\nElementDataFile = LOCAL\n", text_of_samples()));
       }},
      {"mhd big", true,
       [](const Folder& f) {
         write(f / "a.raw", big);
         return write(f / "a.mhd",
                      meta("BinaryData = True\nBinaryDataByteOrderMSB = True\nElementDataFile = a.raw\n"));
       }},
      {"mhd with a header to skip", true,
       [](const Folder& f) {
         write(f / "a.raw", "0123456" + little);
         return write(f / "a.mhd", meta("BinaryData = True\nHeaderSize = 7\nElementDataFile = a.raw\n"));
       }},
      {"mhd with the voxels at the end", true,
       [](const Folder& f) {
         write(f / "a.raw", "unknown header" + little);
         return write(f / "a.mhd", meta("BinaryData = True\nHeaderSize = -1\nElementDataFile = a.raw\n"));
       }},
      {"mhd zlib beside", false,
       [](const Folder& f) {
         write(f / "a.zraw", zlib_stream(little));
         return write(f / "a.mhd",
                      meta("BinaryData = True\nCompressedData = True\nElementDataFile = a.zraw\n"));
       }},
  };
}

std::vector<Format> other_formats() {
  return {
      {"nii little", true, [](const Folder& f) { return write(f / "a.nii", Nifti().header() + little); }},
      {"nii big", true, [](const Folder& f) { return write(f / "a.nii", Nifti().header(true) + big); }},
      {"nii gzip", false,
       [](const Folder& f) { return write(f / "a.nii.gz", gzip(Nifti().header() + little)); }},
      {"nii hdr and img", true,
       [](const Folder& f) {
         Nifti pair;
         pair.magic = "ni1";
         pair.offset = 0;
         write(f / "a.img", little);
         return write(f / "a.hdr", pair.header().substr(0, 348));
       }},
      {"dicom folder", true,
       [](const Folder& f) {
         write_dicom_series(f.path());
         return f.path();
       }},
      {"dicom series by one file", true,
       [](const Folder& f) {
         write_dicom_series(f.path());
         return f / "image2.dcm";
       }},
      {"tiff pages", true,
       [](const Folder& f) {
         write_tiff(f / "a.tif", 0, nz);
         return f / "a.tif";
       }},
      {"tiff folder", true,
       [](const Folder& f) {
         const char* names[] = {"slice2.tif", "slice10.tif", "slice11.tiff"};
         for (int z = 0; z < nz; ++z) write_tiff(f / names[z], z, 1);
         return f.path();
       }},
      {"vtk binary", true, [](const Folder& f) { return write(f / "a.vtk", vtk_header("BINARY") + big); }},
      {"vtk text", false,
       [](const Folder& f) { return write(f / "a.vtk", vtk_header("ASCII") + text_of_samples()); }},
      {"raw by its name", true, [](const Folder& f) { return write(f / "a_5x4x3_int16.raw", little); }},
  };
}

const std::vector<Format>& formats() {
  static const std::vector<Format> list = [] {
    std::vector<Format> all = nrrd_formats();
    for (const auto& more : {meta_formats(), other_formats()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return list;
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

TEST_CASE("every format gives the same voxels, whole, by slice and backwards", "[formats]") {
  const auto expected = samples<short>();
  for (const auto& format : formats()) {
    CAPTURE(format.what);
    const Folder folder;
    const auto source = open_volume(format.make(folder));
    CHECK(source->grid().dims == glm::ivec3(nx, ny, nz));
    CHECK(source->grid().type == ScalarType::int16);
    CHECK(source->concurrent() == format.concurrent);
    CHECK((read_all(*source) == expected));
    const auto slice_bytes = std::size_t(nx * ny) * sizeof(short);
    for (const int z : {0, 2, 1, 1, 0})
      CHECK((read_slice(*source, z) == expected.substr(std::size_t(z) * slice_bytes, slice_bytes)));
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

TEST_CASE("no reader prints anything to stdout", "[formats]") {
  std::ostringstream captured;
  auto* const before = std::cout.rdbuf(captured.rdbuf());
  for (const auto& format : formats()) {
    const Folder folder;
    const auto source = open_volume(format.make(folder));
    read_all(*source);
  }
  std::cout.rdbuf(before);
  CHECK(captured.str().empty());
}

TEST_CASE("all scalar types in both orders, raw and gzip", "[formats]") {
  const auto round = [](auto zero, ScalarType type, const char* name, const char* meta_name) {
    using T = decltype(zero);
    CAPTURE(name);
    const Folder folder;
    for (const bool big : {false, true})
      for (const bool packed : {false, true}) {
        const auto data = samples<T>(big);
        const auto path = write(folder / "a.nrrd", nrrd(std::string("type: ") + name +
                                                            "\nencoding: " + (packed ? "gzip" : "raw") +
                                                            "\nendian: " + (big ? "big" : "little") + "\n",
                                                        packed ? gzip(data) : data));
        const auto source = open_volume(path);
        CHECK(source->grid().type == type);
        CHECK((read_all(*source) == samples<T>()));
      }
    RawDescription raw;
    raw.dims = glm::ivec3(nx, ny, nz);
    raw.type = type;
    raw.big_endian = true;
    const auto source = open_volume(write(folder / "plain.bin", samples<T>(true)), raw);
    CHECK((read_all(*source) == samples<T>()));
    const auto mha =
        write(folder / "a.mha",
              std::string("ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = ") + meta_name +
                  "\nBinaryData = True\nBinaryDataByteOrderMSB = True\n"
                  "ElementDataFile = LOCAL\n" +
                  samples<T>(true));
    const auto from_meta = open_volume(mha);
    CHECK(from_meta->grid().type == type);
    CHECK((read_all(*from_meta) == samples<T>()));
  };
  round(std::int8_t{}, ScalarType::int8, "int8", "MET_CHAR");
  round(std::uint8_t{}, ScalarType::uint8, "uint8", "MET_UCHAR");
  round(std::int16_t{}, ScalarType::int16, "int16", "MET_SHORT");
  round(std::uint16_t{}, ScalarType::uint16, "uint16", "MET_USHORT");
  round(std::int32_t{}, ScalarType::int32, "int32", "MET_INT");
  round(std::uint32_t{}, ScalarType::uint32, "uint32", "MET_UINT");
  round(float{}, ScalarType::float32, "float", "MET_FLOAT");
  round(double{}, ScalarType::float64, "double", "MET_DOUBLE");
}

TEST_CASE("a 2D image is one slice", "[formats]") {
  const Folder folder;
  const auto source = open_volume(write(folder / "a.nrrd",
                                        "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 3 2\n"
                                        "spacings: 2 5\nencoding: raw\n\nabcdef"));
  CHECK(source->grid().dims == glm::ivec3(3, 2, 1));
  CHECK(source->grid().spacing == glm::dvec3(2, 5, 1));
  CHECK(read_all(*source) == "abcdef");
}

TEST_CASE("NIfTI slope and intercept are applied", "[formats]") {
  const Folder folder;
  Nifti scaled;
  scaled.slope = 0.5F;
  scaled.intercept = -3;
  const auto source = open_volume(write(folder / "a.nii", scaled.header() + samples<short>()));
  REQUIRE(source->grid().type == ScalarType::float32);
  CHECK(source->concurrent());
  const auto bytes = read_slice(*source, 1);
  const auto* values = reinterpret_cast<const float*>(bytes.data());
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) CHECK(values[y * nx + x] == float(sample<short>(x, y, 1)) * 0.5F - 3);
}

TEST_CASE("DICOM slope and intercept are applied", "[formats]") {
  const Folder folder;
  Dicom slice;
  slice.slope = std::string("2");
  slice.intercept = std::string("-1024");
  write_dicom_series(folder.path(), slice);
  const auto source = open_volume(folder.path());
  const auto bytes = read_all(*source);
  std::size_t at = 0;
  visit_type(source->grid().type, [&](auto type) {
    using T = decltype(type);
    const auto* values = reinterpret_cast<const T*>(bytes.data());
    for (int z = 0; z < nz; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) CHECK(double(values[at++]) == 2.0 * sample<short>(x, y, z) - 1024);
  });
}

TEST_CASE("DICOM slices of different rescaling become floats of the same meaning", "[formats]") {
  const Folder folder;
  const char* slopes[] = {"1", "0.5", "0.25"};
  for (int z = 0; z < nz; ++z) {
    Dicom slice;
    slice.number = z + 1;
    slice.slope = std::string(slopes[z]);
    slice.position = "0\\0\\" + std::to_string(z);
    slice.pixels = samples<short>().substr(std::size_t(z) * 40, 40);
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

TEST_CASE("of several DICOM series the longest is taken, or the one whose file is named", "[formats]") {
  const Folder folder;
  write_dicom_series(folder.path());
  Dicom other;
  other.series = "1.2.3.4.6";
  other.pixels = samples<short>().substr(0, 40);
  write(folder / "other.dcm", other.bytes());
  CHECK(open_volume(folder.path())->grid().dims.z == nz);
  CHECK(open_volume(folder / "other.dcm")->grid().dims.z == 1);
}
