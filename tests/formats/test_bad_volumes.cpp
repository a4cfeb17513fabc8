#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/stat.h>

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

std::string scalar_field(const char* type, const char* encoding = "raw") {
  return fmt::format("type: {}\ndimension: 3\nencoding: {}\nendian: little\n", type, encoding);
}

std::vector<Bad> bad_nrrd_headers() {
  const auto packed = gzip(samples<std::uint8_t>());
  const std::string bytes = scalar_field("uint8"), zipped = scalar_field("uint8", "gzip");
  const auto nrrd_file = [](const char* what, const char* message, const std::string& fields,
                            const std::string& data = std::string(60, 'v')) {
    return file(what, message, "a.nrrd", nrrd(fields, data));
  };
  return {
      file("empty file", "not a readable NRRD", "a.nrrd", ""),
      file("not an NRRD", "NRRD", "a.nrrd", "this is prose, not a volume\n"),
      file("random bytes", "NRRD", "a.nrrd", std::string("\x80\x81\x00\x01\xff", 5)),
      nrrd_file("truncated raw", "promises 60 bytes", bytes + "sizes: 5 4 3\n", "short"),
      file("a list of too few files", "names 1 data files", "a.nrrd",
           "NRRD0004\n" + bytes + "sizes: 5 4 2\ndata file: LIST\ns0.raw"),
      nrrd_file("2 GB in 1 KB", "promises 2147483648 bytes", bytes + "sizes: 2048 1024 1024\n"),
      nrrd_file("2 GB in 1 KB of gzip", "cannot hold", zipped + "sizes: 2048 1024 1024\n", packed),
      nrrd_file("sizes that overflow 64 bits", "too large",
                scalar_field("float") + "sizes: 2000000000 2000000000 2000000000\n"),
      nrrd_file("sizes that overflow one number", "voxels along axis 0",
                bytes + "sizes: 99999999999999999999999 2 2\n"),
      nrrd_file("an axis beyond int", "voxels along axis 0", bytes + "sizes: 5000000000 1 1\n"),
      nrrd_file("zero dimension", "axis 1 size is zero", bytes + "sizes: 5 0 3\n"),
      nrrd_file("negative dimension", "not a readable NRRD", bytes + "sizes: 5 -4 3\n"),
      nrrd_file("unknown type", "quaternion", scalar_field("quaternion") + "sizes: 5 4 3\n"),
      nrrd_file("64-bit integers", "int32, uint32 or float32", scalar_field("int64") + "sizes: 5 4 3\n",
                std::string(480, 'v')),
      nrrd_file("no endianness for 16 bits", "endian",
                "type: short\ndimension: 3\nencoding: raw\nsizes: 5 4 3\n", std::string(120, 'v')),
      nrrd_file("unknown encoding", "encoding", scalar_field("uint8", "zstd") + "sizes: 5 4 3\n"),
      nrrd_file("bzip2", "bz", scalar_field("uint8", "bzip2") + "sizes: 5 4 3\n"),
      nrrd_file("truncated text", "promises", scalar_field("uint8", "ascii") + "sizes: 5 4 3\n", "1 2 3\n"),
      nrrd_file("zero spacing", "spacing (0) invalid", bytes + "sizes: 5 4 3\nspacings: 1 0 1\n"),
      nrrd_file("singular directions", "direction matrix is singular",
                bytes + "sizes: 5 4 3\nspace: left-posterior-superior\n"
                        "space directions: (1,0,0) (1,0,0) (0,0,1)\nspace origin: (0,0,0)\n"),
      nrrd_file("truncated gzip", "cut short or damaged", zipped + "sizes: 5 4 3\n", packed.substr(0, 30)),
      nrrd_file("gzip of too few bytes", "cut short or damaged", zipped + "sizes: 5 4 4\n", packed),
      nrrd_file("no gzip at all", "cut short or damaged", zipped + "sizes: 5 4 3\n"),
      nrrd_file("damaged gzip", "cut short or damaged", zipped + "sizes: 5 4 3\n",
                packed.substr(0, 20) + std::string(packed.size() - 20, '\xff')),
  };
}

std::vector<Bad> bad_nrrd_files() {
  const auto detached = [](const char* what, const char* message, const std::string& fields) {
    return Bad{what, message, [=](const Folder& f) {
                 for (const char* name : {"s0.raw", "s1.raw", "s2.raw"}) write(f / name, "short");
                 return write(f / "a.nhdr", nrrd(scalar_field("uint8") + fields, ""));
               }};
  };
  return {
      detached("missing data file", "nowhere.raw", "sizes: 5 4 3\ndata file: nowhere.raw\n"),
      detached("a number of 4000 digits in the names of data files", "pattern of its data files",
               "sizes: 5 4 3\ndata file: s%4000d.raw 0 2 1\n"),
      detached("two patterns in the names of data files", "pattern of its data files",
               "sizes: 5 4 3\ndata file: s%d-%d.raw 0 2 1\n"),
      detached("6 GB in three data files of a few bytes", "promises 2000000000 bytes",
               "sizes: 50000 40000 3\ndata file: s%d.raw 0 2 1\n"),
      detached("6 GB in a list of data files", "promises 3000000000 bytes",
               "sizes: 50000 60000 2\ndata file: LIST\ns0.raw\ns1.raw"),
  };
}

std::vector<Bad> bad_metas() {
  const std::string end = "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  const auto bytes = [&](const char* what, const char* message, const std::string& fields,
                         const std::string& data = "short") {
    return file(what, message, "a.mha", meta(fields + end, data));
  };
  return {
      file("meta, empty", "MetaImage", "a.mha", ""),
      file("meta, prose", "no readable MetaImage header", "a.mha", "hello\n"),
      bytes("meta, truncated", "promises 60 bytes", "DimSize = 5 4 3\n"),
      bytes("meta, zero dimension", "DimSize is 0 along axis 1", "DimSize = 5 0 3\n"),
      bytes("meta, negative dimension", "DimSize is -4", "DimSize = 5 -4 3\n"),
      file("meta, negative number of dimensions", "NDims is '-3'", "a.mha",
           "NDims = -3\nDimSize = 1 1 1\n" + end),
      file("meta, too many dimensions", "NDims is '99'", "a.mha", "NDims = 99\nDimSize = 1 1 1\n" + end),
      bytes("meta, huge", "overflow 64 bits", "DimSize = 2000000000 2000000000 2000000000\n"),
      file("meta, no such data", "nowhere.raw", "a.mhd",
           meta("DimSize = 5 4 3\nElementType = MET_UCHAR\nElementDataFile = nowhere.raw\n")),
      bytes("meta, channels cut short", "promises 180 bytes",
            "DimSize = 5 4 3\nElementNumberOfChannels = 3\n", std::string(179, 'v')),
      file("meta, 64-bit", "int32, uint32 or float32", "a.mha",
           meta("DimSize = 5 4 3\nElementType = MET_LONG_LONG\nElementDataFile = LOCAL\n",
                std::string(480, 'v'))),
      bytes("meta, damaged zlib", "cut short or damaged", "DimSize = 5 4 3\nCompressedData = True\n",
            "no zlib stream"),
  };
}

std::vector<Bad> bad_vtks() {
  const auto with = [](const char* kind, const char* dims, const std::string& data) {
    return fmt::format(
        "# vtk DataFile Version 3.0\nt\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS {}\nSPACING 1 1 1\n"
        "ORIGIN 0 0 0\nPOINT_DATA 24\nSCALARS v short 1\nLOOKUP_TABLE default\n{}",
        kind, dims, data);
  };
  return {
      file("vtk, prose", "VTK", "a.vtk", "hello\n"),
      file("vtk, text cut short", "promises more numbers than the 5 that the file holds", "a.vtk",
           with("ASCII", "4 3 2", "1 2 30000 4 50" + std::string(50, ' '))),
      file("vtk, truncated", "promises", "a.vtk", with("BINARY", "500 400 300", "xx")),
      file("vtk, zero dimension", "dimensions 5 x 0 x 3", "a.vtk", with("BINARY", "5 0 3", "")),
  };
}

/// What NIfTI-1 has in common with NIfTI-2 is checked there.
std::vector<Bad> bad_niftis() {
  Nifti rgb, unknown, huge;
  unknown.datatype = 77;
  rgb.datatype = 128, rgb.bits = 24;
  huge.dims[1] = huge.dims[2] = huge.dims[3] = 32767;
  const auto whole = gzip(Nifti().header() + samples<short>());
  return {
      file("nifti, empty", "NIfTI", "a.nii", ""),
      file("nifti, prose", "NIfTI", "a.nii", "hello"),
      file("nifti, header cut short", "NIfTI", "a.nii", Nifti().header().substr(0, 200)),
      file("nifti, truncated", "promises 120 bytes", "a.nii", Nifti().header() + "short"),
      file("nifti, unknown type", "unknown datatype 77", "a.nii", unknown.header() + samples<short>()),
      file("nifti, colours cut short", "promises 180 bytes", "a.nii", rgb.header() + std::string(179, 'v')),
      file("nifti, huge", "promises", "a.nii", huge.header() + samples<short>()),
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

/// The folder, with files of one letter.
Bad folder_of(const char* what, const char* message, const std::vector<std::string>& names) {
  return {what, message, [=](const Folder& f) {
            for (const auto& name : names) write(f / name, "x");
            return f.path();
          }};
}

Bad images(const char* what, const char* message, const char* first, const char* second) {
  return {what, message, [=](const Folder& f) {
            write_image(f / first, 4, 4, 1, OIIO::TypeDesc::UINT16);
            write_image(f / second, 4, 5, 1, OIIO::TypeDesc::UINT16);
            return f.path();
          }};
}

std::vector<Bad> bad_folders() {
  return {
      {"missing file", "No such file", [](const Folder& f) { return f / "none.nrrd"; }},
      {"missing folder", "No such file", [](const Folder& f) { return f / "none/a.nrrd"; }},
      folder_of("empty folder", "holds no DICOM, TIFF or PNG", {}),
      folder_of("folder of text", "holds no DICOM, TIFF or PNG", {"readme.txt"}),
      {"a folder named like a volume", "holds no DICOM, TIFF or PNG",
       [](const Folder& f) { return fs::create_directory(f / "a.nrrd"), f / "a.nrrd"; }},
      folder_of("a folder of pictures",
                "holds pictures (2 files, .jpg); hint: slices are read from DICOM, TIFF and PNG",
                {"1.jpg", "2.JPG"}),
      folder_of("PNG files that are none", "1.PNG is not a readable image file", {"1.PNG", "2.png"}),
      images("PNG files of two sizes", "all slices must have one size", "1.png", "2.png"),
      {"PNG, cut short", "1.png",
       [](const Folder& f) {
         const auto bytes = slurp(write_image(f / "1.png", 64, 64, 1, OIIO::TypeDesc::UINT16));
         write(f / "1.png", bytes.substr(0, bytes.size() - 30));
         return f.path();
       }},
      folder_of("a folder of volumes", "holds volume files (2); hint: name one of them, as ",
                {"b.nii.gz", "c.mha"}),
      folder_of("a folder of broken images",
                "holds no image that can be read; of 2 the first: ", {"a.dcm", "b.dcm"}),
      {"a named pipe", "not a regular file",
       [](const Folder& f) { return ::mkfifo((f / "a.nrrd").c_str(), 0600), f / "a.nrrd"; }},
      {"a link to nowhere", "No such file",
       [](const Folder& f) { return fs::create_symlink(f / "nowhere", f / "a.nrrd"), f / "a.nrrd"; }},
  };
}

/// A slice, some of whose bytes are missing at the end.
Bad dicom(const char* what, const char* message, const std::function<void(Dicom&)>& change,
          std::size_t missing = 0) {
  return {what, message, [=](const Folder& f) {
            Dicom slice;
            slice.pixels = slice_of_samples(0);
            change(slice);
            const auto bytes = slice.bytes();
            return write(f / "a.dcm", bytes.substr(0, bytes.size() - missing));
          }};
}

std::vector<Bad> bad_dicoms() {
  return {
      dicom(
          "dicom, truncated pixels", "cut short or damaged at byte", [](Dicom&) {}, 30),
      dicom(
          "dicom, cut before the pixels", "cut short or damaged at byte", [](Dicom&) {}, 60),
      dicom("dicom, colours", "3 values per pixel",
            [](Dicom& d) { d.samples = 3, d.pixels = samples<short>(); }),
      dicom("dicom, no rows", "0 rows", [](Dicom& d) { d.rows = 0, d.pixels.clear(); }),
      dicom("dicom, fewer pixels than it says", "promises 40 bytes", [](Dicom& d) { d.pixels.resize(20); }),
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
           slice.pixels = slice_of_samples(0);
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
      images("tiff, two sizes", "all slices must have one size", "a.tif", "b.tif"),
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
  check_all(bad_nrrd_files());
}
TEST_CASE("bad MetaImage and VTK files are clear errors", "[bad]") {
  check_all(bad_metas());
  check_all(bad_vtks());
}
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
