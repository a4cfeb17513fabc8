#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <limits>
#include <map>

#include "formats/bad_files.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;

namespace {

std::string nrrd(const std::string& fields, const std::string& data = std::string(60, 'v')) {
  return "NRRD0004\n" + fields + "\n" + data;
}

std::string meta(const std::string& fields, const std::string& data = {}) {
  return "ObjectType = Image\nNDims = 3\n" + fields + data;
}

fs::path write_image(const fs::path& path, int width, int height, int channels, OIIO::TypeDesc type) {
  auto out = OIIO::ImageOutput::create(path.string());
  const std::vector<char> pixels(std::size_t(width * height * channels) * 8);
  out->open(path.string(), OIIO::ImageSpec(width, height, channels, type));
  out->write_image(type, pixels.data());
  out->close();
  return path;
}

std::string scalar_field(const char* type) {
  return std::string("type: ") + type + "\ndimension: 3\nencoding: raw\nendian: little\n";
}

std::vector<Bad> bad_nrrd_headers() {
  const auto packed = gzip(samples<std::uint8_t>());
  return {
      file("empty file", "not a readable NRRD", "a.nrrd", ""),
      file("not an NRRD", "NRRD", "a.nrrd", "this is prose, not a volume\n"),
      file("random bytes", "NRRD", "a.nrrd", std::string("\x80\x81\x00\x01\xff", 5)),
      file("only the magic", "NRRD", "a.nrrd", "NRRD0004\n"),
      file("truncated raw", "promises 60 bytes", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 5 4 3\n", "short")),
      file("a list of too few files", "names 1 data files", "a.nrrd",
           "NRRD0004\n" + scalar_field("uint8") + "sizes: 5 4 2\ndata file: LIST\ns0.raw"),
      file("2 GB in 1 KB", "promises 2147483648 bytes", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 2048 1024 1024\n", std::string(1000, 'v'))),
      file("2 GB in 1 KB of gzip", "cannot hold", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: gzip\nsizes: 2048 1024 1024\n", packed)),
      file("sizes that overflow 64 bits", "too large", "a.nrrd",
           nrrd(scalar_field("float") + "sizes: 2000000000 2000000000 2000000000\n")),
      file("sizes that overflow one number", "voxels along axis 0", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 99999999999999999999999 2 2\n")),
      file("an axis beyond int", "voxels along axis 0", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 5000000000 1 1\n")),
      file("zero dimension", "axis 1 size is zero", "a.nrrd", nrrd(scalar_field("uint8") + "sizes: 5 0 3\n")),
      file("negative dimension", "not a readable NRRD", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 5 -4 3\n")),
      file("fewer sizes than dimensions", "dimension is 3", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 5 4\n")),
      file("unknown type", "quaternion", "a.nrrd", nrrd(scalar_field("quaternion") + "sizes: 5 4 3\n")),
      file("64-bit integers", "int32, uint32 or float32", "a.nrrd",
           nrrd(scalar_field("int64") + "sizes: 5 4 3\n", std::string(480, 'v'))),
      file("four dimensions, cut short", "promises 120 bytes", "a.nrrd",
           nrrd("type: uint8\ndimension: 4\nencoding: raw\nsizes: 5 4 3 2\n", std::string(119, 'v'))),
      file("vectors", "vector of 3 numbers", "a.nrrd",
           nrrd("type: uint8\ndimension: 4\nencoding: raw\nsizes: 3 5 4 3\nkinds: vector domain domain "
                "domain\n",
                std::string(180, 'v'))),
      file("no endianness for 16 bits", "endian", "a.nrrd",
           nrrd("type: short\ndimension: 3\nencoding: raw\nsizes: 5 4 3\n", std::string(120, 'v'))),
      file("unknown encoding", "encoding", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: zstd\nsizes: 5 4 3\n")),
      file("bzip2", "bz", "a.nrrd", nrrd("type: uint8\ndimension: 3\nencoding: bzip2\nsizes: 5 4 3\n")),
  };
}

std::vector<Bad> bad_nrrd_voxels() {
  const auto packed = gzip(samples<std::uint8_t>());
  return {
      file("truncated text", "promises", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: ascii\nsizes: 5 4 3\n", "1 2 3\n")),
      file("missing data file", "nowhere.raw", "a.nhdr",
           nrrd(scalar_field("uint8") + "sizes: 5 4 3\ndata file: nowhere.raw\n", "")),
      file("a number of 4000 digits in the names of data files", "pattern of its data files", "a.nhdr",
           nrrd(scalar_field("uint8") + "sizes: 5 4 3\ndata file: s%4000d.raw 0 2 1\n", "")),
      file("two patterns in the names of data files", "pattern of its data files", "a.nhdr",
           nrrd(scalar_field("uint8") + "sizes: 5 4 3\ndata file: s%d-%d.raw 0 2 1\n", "")),
      {"6 GB in three data files of a few bytes", "promises 2000000000 bytes",
       [](const Folder& f) {
         for (const char* name : {"s0.raw", "s1.raw", "s2.raw"}) write(f / name, "short");
         return write(f / "a.nhdr",
                      nrrd(scalar_field("uint8") + "sizes: 50000 40000 3\ndata file: s%d.raw 0 2 1\n", ""));
       }},
      {"6 GB in a list of data files", "promises 3000000000 bytes",
       [](const Folder& f) {
         for (const char* name : {"s0.raw", "s1.raw"}) write(f / name, "short");
         return write(
             f / "a.nhdr",
             nrrd(scalar_field("uint8") + "sizes: 50000 60000 2\ndata file: LIST\ns0.raw\ns1.raw", ""));
       }},
      file("zero spacing", "spacing (0) invalid", "a.nrrd",
           nrrd(scalar_field("uint8") + "sizes: 5 4 3\nspacings: 1 0 1\n")),
      file(
          "singular directions", "direction matrix is singular", "a.nrrd",
          nrrd(scalar_field("uint8") + "sizes: 5 4 3\nspace: left-posterior-superior\n"
                                       "space directions: (1,0,0) (1,0,0) (0,0,1)\nspace origin: (0,0,0)\n")),
      file("truncated gzip", "cut short or damaged", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: gzip\nsizes: 5 4 3\n", packed.substr(0, 30))),
      file("gzip of too few bytes", "cut short or damaged", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: gzip\nsizes: 5 4 4\n", packed)),
      file("no gzip at all", "cut short or damaged", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: gzip\nsizes: 5 4 3\n")),
      file("damaged gzip", "cut short or damaged", "a.nrrd",
           nrrd("type: uint8\ndimension: 3\nencoding: gzip\nsizes: 5 4 3\n",
                packed.substr(0, 20) + std::string(packed.size() - 20, '\xff'))),
  };
}

std::vector<Bad> bad_metas_and_vtks() {
  return {
      file("meta, empty", "MetaImage", "a.mha", ""),
      file("meta, prose", "no readable MetaImage header", "a.mha", "hello\n"),
      file("meta, truncated", "promises 60 bytes", "a.mha",
           meta("DimSize = 5 4 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "short")),
      file("meta, zero dimension", "DimSize is 0 along axis 1", "a.mha",
           meta("DimSize = 5 0 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "short")),
      file("meta, negative dimension", "DimSize is -4", "a.mha",
           meta("DimSize = 5 -4 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "short")),
      file("meta, negative number of dimensions", "NDims is '-3'", "a.mha",
           "ObjectType = Image\nNDims = -3\nDimSize = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = "
           "LOCAL\n"),
      file("meta, too many dimensions", "NDims is '99'", "a.mha",
           "ObjectType = Image\nNDims = 99\nDimSize = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = "
           "LOCAL\n"),
      file("meta, huge", "overflow 64 bits", "a.mha",
           meta("DimSize = 2000000000 2000000000 2000000000\nElementType = MET_UCHAR\nElementDataFile = "
                "LOCAL\n",
                "short")),
      file("meta, no such data", "nowhere.raw", "a.mhd",
           meta("DimSize = 5 4 3\nElementType = MET_UCHAR\nElementDataFile = nowhere.raw\n")),
      file("meta, channels cut short", "promises 180 bytes", "a.mha",
           meta("DimSize = 5 4 3\nElementNumberOfChannels = 3\nElementType = MET_UCHAR\nElementDataFile = "
                "LOCAL\n",
                std::string(179, 'v'))),
      file("meta, 64-bit", "int32, uint32 or float32", "a.mha",
           meta("DimSize = 5 4 3\nElementType = MET_LONG_LONG\nElementDataFile = LOCAL\n",
                std::string(480, 'v'))),
      file("meta, damaged zlib", "cut short or damaged", "a.mha",
           meta("DimSize = 5 4 3\nCompressedData = True\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
                "no zlib stream")),
      file("vtk, prose", "VTK", "a.vtk", "hello\n"),
      file(
          "vtk, text cut short", "promises more numbers than the 5 that the file holds", "a.vtk",
          "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 1 1\n"
          "ORIGIN 0 0 0\nPOINT_DATA 24\nSCALARS v short 1\nLOOKUP_TABLE default\n1 2 30000 4 50" +
              std::string(50, ' ')),
      file("vtk, truncated", "promises", "a.vtk",
           "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 500 400 "
           "300\nSPACING 1 1 1\n"
           "ORIGIN 0 0 0\nPOINT_DATA 60000000\nSCALARS v short 1\nLOOKUP_TABLE default\nxx"),
      file("vtk, zero dimension", "dimensions 5 x 0 x 3", "a.vtk",
           "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 0 3\nSPACING 1 1 "
           "1\n"
           "ORIGIN 0 0 0\nPOINT_DATA 0\nSCALARS v short 1\nLOOKUP_TABLE default\n"),
  };
}

std::vector<Bad> bad_niftis() {
  Nifti zero, four, rgb, wide, huge, infinite, unknown, none;
  infinite.rows[0] = -std::numeric_limits<float>::infinity();
  unknown.datatype = 77;
  none.dims[0] = 0;
  zero.dims[2] = 0;
  four.dims[0] = 4, four.dims[4] = 2;
  rgb.datatype = 128, rgb.bits = 24;
  wide.datatype = 1024, wide.bits = 64;
  huge.dims[1] = huge.dims[2] = huge.dims[3] = 32767;
  const std::string voxels(480, 'v');
  const auto whole = gzip(Nifti().header() + samples<short>());
  return {
      file("nifti, empty", "NIfTI", "a.nii", ""),
      file("nifti, prose", "NIfTI", "a.nii", "hello"),
      file("nifti, header cut short", "NIfTI", "a.nii", Nifti().header().substr(0, 200)),
      file("nifti, truncated", "promises 120 bytes", "a.nii", Nifti().header() + "short"),
      file("nifti, zero dimension", "dim[2] is 0", "a.nii", zero.header() + voxels),
      file("nifti, infinite orientation", "is not a number", "a.nii", infinite.header() + voxels),
      file("nifti, unknown type", "unknown datatype 77", "a.nii", unknown.header() + voxels),
      file("nifti, no dimensions", "dim[0] is 0", "a.nii", none.header() + voxels),
      file("nifti, 4D cut short", "promises 240 bytes", "a.nii", four.header() + voxels.substr(0, 239)),
      file("nifti, colours cut short", "promises 180 bytes", "a.nii", rgb.header() + voxels.substr(0, 179)),
      file("nifti, 64-bit", "int32, uint32 or float32", "a.nii", wide.header() + voxels),
      file("nifti, huge", "promises", "a.nii", huge.header() + voxels),
      file("nifti, truncated gzip", "cut short or damaged", "a.nii.gz", whole.substr(0, whole.size() - 40)),
      file("nifti, no gzip", "NIfTI", "a.nii.gz", "hello"),
  };
}

std::vector<Bad> bad_mrcs() {
  const auto with = [](const std::map<std::size_t, int>& words) {
    std::string file(1024 + 60, '\0');
    std::map<std::size_t, int> all{{1, nx}, {2, ny}, {3, nz}, {4, 0},
                                   {17, 1}, {18, 2}, {19, 3}, {54, 0x4444}};
    for (const auto& [word, value] : words) all[word] = value;
    for (const auto& [word, value] : all) file.replace(4 * (word - 1), 4, bytes_of(value));
    return file;
  };
  return {
      file("mrc, prose", "a.mrc: its data ends at byte 5", "a.mrc", "hello"),
      file("mrc, complex numbers", "voxels of mode 4 cannot be rendered", "a.mrc", with({{4, 4}})),
      file("mrc, cut short", "promises 120 bytes of voxels, the file holds 60", "a.mrc", with({{4, 1}})),
      file("mrc, huge", "promises", "a.mrc", with({{1, 60000}, {2, 1 << 30}})),
      file("mrc, no columns", "0 x 4 x 3", "a.mrc", with({{1, 0}})),
      file("mrc, strange axes", "its axes are 1 5 3", "a.mrc", with({{18, 5}})),
      file("mrc, one axis twice", "singular", "a.mrc", with({{18, 1}})),
      file("mrc, no angles", "the origin is not finite", "a.mrc", with({{14, 0x7fc00000}})),
      file("mrc, a header that ends before it begins", "its extended header has -4 bytes", "a.mrc",
           with({{24, -4}})),
      file("mrc, no gzip", "cut short or damaged", "a.map.gz", gzip(with({})).substr(0, 20)),
  };
}

std::vector<Bad> bad_folders() {
  return {
      {"missing file", "No such file", [](const Folder& f) { return f / "none.nrrd"; }},
      {"missing folder", "No such file", [](const Folder& f) { return f / "none/a.nrrd"; }},
      {"empty folder", "holds no DICOM, TIFF or PNG", [](const Folder& f) { return f.path(); }},
      {"folder of text", "holds no DICOM, TIFF or PNG",
       [](const Folder& f) {
         write(f / "readme.txt", "hello");
         return f.path();
       }},
      {"a folder named like a volume", "holds no DICOM, TIFF or PNG",
       [](const Folder& f) {
         fs::create_directory(f / "a.nrrd");
         return f / "a.nrrd";
       }},
      {"a folder of pictures",
       "holds pictures (2 files, .jpg); hint: slices are read from DICOM, TIFF and PNG",
       [](const Folder& f) {
         write(f / "1.jpg", "x");
         write(f / "2.JPG", "x");
         return f.path();
       }},
      {"PNG files that are none", "1.PNG is not a readable image file",
       [](const Folder& f) {
         write(f / "1.PNG", "x");
         write(f / "2.png", "x");
         return f.path();
       }},
      {"PNG files of two sizes", "all slices must have one size",
       [](const Folder& f) {
         write_image(f / "1.png", 4, 4, 1, OIIO::TypeDesc::UINT16);
         write_image(f / "2.png", 4, 5, 1, OIIO::TypeDesc::UINT16);
         return f.path();
       }},
      {"PNG, cut short", "1.png",
       [](const Folder& f) {
         const auto bytes = slurp(write_image(f / "1.png", 64, 64, 1, OIIO::TypeDesc::UINT16));
         write(f / "1.png", bytes.substr(0, bytes.size() - 30));
         return f.path();
       }},
      {"a folder of volumes", "holds volume files (2); hint: name one of them, as ",
       [](const Folder& f) {
         write(f / "b.nii.gz", "x");
         write(f / "c.mha", "x");
         return f.path();
       }},
      {"a folder of broken images", "holds no image that can be read; of 2 the first: ",
       [](const Folder& f) {
         write(f / "a.dcm", "x");
         write(f / "b.dcm", "x");
         return f.path();
       }},
      {"a named pipe", "not a regular file",
       [](const Folder& f) {
         ::mkfifo((f / "a.nrrd").c_str(), 0600);
         return f / "a.nrrd";
       }},
      {"a link to nowhere", "No such file",
       [](const Folder& f) {
         fs::create_symlink(f / "nowhere", f / "a.nrrd");
         return f / "a.nrrd";
       }},
  };
}

std::vector<Bad> bad_dicoms() {
  return {
      {"dicom, truncated pixels", "cut short or damaged at byte",
       [](const Folder& f) {
         Dicom slice;
         slice.pixels = samples<short>().substr(0, 40);
         const auto bytes = slice.bytes();
         return write(f / "a.dcm", bytes.substr(0, bytes.size() - 30)), f.path();
       }},
      {"dicom, cut before the pixels", "cut short or damaged at byte",
       [](const Folder& f) {
         Dicom slice;
         slice.pixels = samples<short>().substr(0, 40);
         const auto bytes = slice.bytes();
         return write(f / "a.dcm", bytes.substr(0, bytes.size() - 60)), f.path();
       }},
      {"dicom, colours", "3 values per pixel",
       [](const Folder& f) {
         Dicom slice;
         slice.samples = 3;
         slice.pixels = samples<short>();
         return write(f / "a.dcm", slice.bytes());
       }},
      {"dicom, no rows", "0 rows",
       [](const Folder& f) {
         Dicom slice;
         slice.rows = 0;
         return write(f / "a.dcm", slice.bytes());
       }},
      {"dicom, fewer pixels than it says", "promises 40 bytes",
       [](const Folder& f) {
         Dicom slice;
         slice.pixels = samples<short>().substr(0, 20);
         return write(f / "a.dcm", slice.bytes());
       }},
      {"dicom, two sizes", "take slices of one size",
       [](const Folder& f) {
         write_dicom_series(f.path());
         Dicom slice;
         slice.rows = 2;
         slice.number = 9;
         slice.position = "-10\\-20\\60";
         slice.pixels = samples<short>().substr(0, 20);
         return write(f / "z.dcm", slice.bytes()), f.path();
       }},
      {"dicom, all in one place", "no different positions",
       [](const Folder& f) {
         for (int z = 0; z < 2; ++z) {
           Dicom slice;
           slice.number = z + 1;
           slice.pixels = samples<short>().substr(0, 40);
           write(f / (fmt::format("s{}", z)), slice.bytes());
         }
         return f.path();
       }},
      file("dicom, prose", "holds no DICOM", "a.dcm", "hello"),
  };
}

std::vector<Bad> bad_tiffs() {
  return {
      file("tiff, prose", "TIFF", "a.tif", "hello"),
      file("tiff, empty", "TIFF", "a.tif", ""),
      {"tiff, vectors", "a vector of 5 numbers",
       [](const Folder& f) { return write_image(f / "a.tif", 4, 4, 5, OIIO::TypeDesc::UINT8); }},
      {"tiff, two sizes", "all slices must have one size",
       [](const Folder& f) {
         write_image(f / "a.tif", 4, 4, 1, OIIO::TypeDesc::UINT8);
         write_image(f / "b.tif", 4, 5, 1, OIIO::TypeDesc::UINT8);
         return f.path();
       }},
      {"tiff, cut short", "a.tif",
       [](const Folder& f) {
         const auto bytes = slurp(write_image(f / "a.tif", 64, 64, 1, OIIO::TypeDesc::UINT16));
         return write(f / "a.tif", bytes.substr(0, bytes.size() / 2));
       }},
  };
}

std::vector<Bad> bad_raws() {
  RawDescription only_dims, negative, contradiction, spacing, beyond;
  only_dims.dims = glm::ivec3(5, 4, 3);
  negative.dims = glm::ivec3(5, -4, 3);
  negative.type = ScalarType::uint8;
  contradiction.dims = glm::ivec3(5, 4, 3);
  spacing.spacing = glm::dvec3(1, -1, 1);
  beyond.dims = glm::ivec3(5, 4, 3);
  beyond.type = ScalarType::uint8;
  beyond.offset = ~std::uint64_t{0} - 10;
  const auto voxels = samples<std::uint8_t>();
  return {
      file("raw, nothing known", "dimensions and type must be known", "a.raw", voxels),
      file("raw, no type", "type must be known", "a.raw", voxels, only_dims),
      file("raw, too short", "needs 64000 bytes after an offset of 0, the file has 60",
           "a_40x40x40_uint8.raw", voxels),
      file("raw, too long", "needs 27 bytes after an offset of 0, the file has 60", "a_3x3x3_uint8.raw",
           voxels),
      file("raw, zero dimension", "5 x 0 x 3", "a_5x0x3_uint8.raw", voxels),
      file("raw, huge dimension", "too large", "a_99999999999x1x1_uint8.raw", voxels),
      file("raw, overflow", "overflow 64 bits", "a_2000000000x2000000000x2000000000_uint8.raw", voxels),
      file("raw, 64-bit", "int64", "a_5x4x3_int64.raw", voxels),
      file("raw, negative dimension", "5 x -4 x 3", "a.raw", voxels, negative),
      file("raw, offset beyond the end", "the file has 0", "a.raw", voxels, beyond),
      file("raw, negative spacing", "spacing", "a_5x4x3_uint8.raw", voxels, spacing),
      file("raw options for a NIfTI", "describes itself", "a.nii", Nifti().header() + samples<short>(),
           contradiction),
      file("bad spacing for a NIfTI", "--spacing", "a.nii", Nifti().header() + samples<short>(), spacing),
      file("unknown ending", "no ending of a known volume format", "a.xyz", voxels),
      file("no ending", "no ending of a known volume format", "volume", voxels),
  };
}

}  // namespace

TEST_CASE("bad NRRD files are clear errors", "[bad]") {
  check_all(bad_nrrd_headers());
  check_all(bad_nrrd_voxels());
}
TEST_CASE("bad MetaImage and VTK files are clear errors", "[bad]") { check_all(bad_metas_and_vtks()); }
TEST_CASE("bad MRC files are clear errors", "[bad]") { check_all(bad_mrcs()); }
TEST_CASE("bad NIfTI files are clear errors", "[bad]") { check_all(bad_niftis()); }
TEST_CASE("bad folders, DICOM and TIFF files are clear errors", "[bad]") {
  check_all(bad_folders());
  check_all(bad_dicoms());
  check_all(bad_tiffs());
}
TEST_CASE("bad raw files and contradictions are clear errors", "[bad]") { check_all(bad_raws()); }

TEST_CASE("a file that may not be read is a clear error", "[bad]") {
  if (::geteuid() == 0) return;  // root may read anything
  const Folder folder;
  const auto path = write(folder / "a_5x4x3_uint8.raw", samples<std::uint8_t>());
  ::chmod(path.c_str(), 0);
  CHECK(says(message_of([&] { open_volume(path); }), "Permission denied"));
}
