#include <fmt/format.h>

#include "formats/bad_files.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"

using namespace files;

namespace {

std::string header(const std::string& fields, const std::string& data_file) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n" + fields +
         "ElementDataFile = " + data_file;
}

/// One file a slice, named a4.raw, a6.raw, a8.raw.
void write_slices(const Folder& folder, const std::string& before = {}, bool big_endian = false) {
  const auto all = samples<short>(big_endian);
  for (int z = 0; z < nz; ++z)
    write(folder / fmt::format("a{}.raw", 4 + 2 * z), before + all.substr(std::size_t(z) * 40, 40));
}

/// A header beside the slice files, some of which may be changed.
Bad sliced(
    const char* what, const char* message, const std::string& fields, const std::string& data_file,
    std::function<void(const Folder&)> change = [](const Folder&) {}) {
  return {what, message, [=](const Folder& f) {
            write_slices(f);
            change(f);
            return write(f / "a.mhd", header(fields, data_file));
          }};
}

}  // namespace

TEST_CASE("MetaImage slices in files of their own are read, each by whoever wants it", "[meta]") {
  for (const char* data_file :
       {"LIST\na4.raw\na6.raw\na8.raw\n", "LIST 2\r\na4.raw\r\n\r\na6.raw\r\na8.raw",
        "LIST 2D\na4.raw\na6.raw\na8.raw\n", "a%d.raw 4 8 2\n", "a%d.raw 4 8", "a%01d.raw 4 8 2"}) {
    CAPTURE(data_file);
    const Folder folder;
    write_slices(folder);
    const auto source = open_volume(write(folder / "a.mhd", header("", data_file)));
    CHECK(source->concurrent());
    CHECK(is_sample(*source));
  }
}

TEST_CASE("MetaImage slice files may have headers, big numbers first, blanks in their names", "[meta]") {
  for (const char* size : {"3", "-1"}) {
    const Folder folder;
    write_slices(folder, "xyz", true);
    const auto fields = fmt::format("HeaderSize = {}\nBinaryDataByteOrderMSB = True\n", size);
    const auto source = open_volume(write(folder / "a.mhd", header(fields, "a%d.raw 4 8 2")));
    CHECK((read_all(*source) == samples<short>()));
  }
  const Folder folder;
  for (int z = 0; z < nz; ++z) write(folder / fmt::format("my scan {:03}.raw", z), slice_of_samples(z));
  const auto source = open_volume(write(folder / "a.mhd", header("", "my scan %03d.raw 0 2 1")));
  CHECK((read_all(*source) == samples<short>()));
}

TEST_CASE("a MetaImage list of one file with three dimensions is that file", "[meta]") {
  const Folder folder;
  write(folder / "all.raw", samples<short>());
  const auto source = open_volume(write(folder / "a.mhd", header("", "LIST 3\nall.raw\n")));
  CHECK((read_all(*source) == samples<short>()));
}

TEST_CASE("a MetaImage field may have the older of its names", "[meta]") {
  const Folder folder;
  const auto grid =
      open_volume(
          write(folder / "a.mha", header("Position = 1 2 3\nRotation = 0 1 0 -1 0 0 0 0 1\nElementSize = 2 "
                                         "3 4\nElementByteOrderMSB = False\nComment = a: b\n",
                                         "LOCAL\n") +
                                      samples<short>()))
          ->grid();
  CHECK(grid.origin == glm::dvec3(1, 2, 3));
  CHECK(grid.spacing == glm::dvec3(2, 3, 4));
  CHECK(grid.direction[0] == glm::dvec3(0, 1, 0));
}

TEST_CASE("MetaImage slice files that are missing, short or not as many are refused", "[meta][bad]") {
  const auto remove = [](const Folder& f) { fs::remove(f / "a6.raw"); };
  const auto cut = [](const Folder& f) { fs::resize_file(f / "a8.raw", 39); };
  check_all({
      sliced("list, missing", "a6.raw", "", "LIST\na4.raw\na6.raw\na8.raw\n", remove),
      sliced("list, short", "a8.raw: the header promises 40 bytes of voxels, the file holds 39", "",
             "LIST\na4.raw\na6.raw\na8.raw\n", cut),
      sliced("pattern, short", "a8.raw: the header promises 40 bytes", "", "a%d.raw 4 8 2\n", cut),
      sliced("list, header beyond the file", "promises 40 bytes", "HeaderSize = 5\n",
             "LIST\na4.raw\na6.raw\na8.raw\n"),
      sliced("list, too few", "names 2 files, DimSize asks for 3", "", "LIST\na4.raw\na6.raw\n"),
      sliced("list, none", "names 0 files", "", "LIST"),
      sliced("list, too many", "names 4 files", "", "LIST\na4.raw\na6.raw\na8.raw\na4.raw\n"),
      sliced("list of lines", "2 or 3 dimensions", "", "LIST 1\na4.raw\n"),
      sliced("list of two numbers", "cannot be read", "", "LIST 2 3\na4.raw\na6.raw\na8.raw\n"),
      sliced("a name like a list's", "LISTING: No such file", "", "LISTING\na4.raw\na6.raw\na8.raw\n"),
      sliced("list of a folder", "not a regular file", "", "LIST\na4.raw\n.\na8.raw\n"),
      sliced("list, compressed", "several files of compressed", "CompressedData = True\n",
             "LIST\na4.raw\na6.raw\na8.raw\n"),
      sliced("list of text", "several files of text", "BinaryData = False\n",
             "LIST\na4.raw\na6.raw\na8.raw\n"),
      sliced("pattern, too few", "names 2 files, DimSize asks for 3", "", "a%d.raw 4 6 2\n"),
      sliced("pattern, too many", "names 4 files", "", "a%d.raw 4 10 2\n"),
      sliced("pattern, step of nothing", "steps of 0", "", "a%d.raw 4 8 0\n"),
      sliced("pattern, infinite step", "'inf' where a whole number belongs", "", "a%d.raw 4 8 inf\n"),
      sliced("pattern, huge end", "where a whole number belongs", "", "a%d.raw 4 99999999999999 2\n"),
      sliced("pattern, backwards", "names 0 files", "", "a%d.raw 8 4 2\n"),
      sliced("pattern, negative step", "'-2' where", "", "a%d.raw 8 4 -2\n"),
      sliced("pattern for printf", "no pattern of file names", "", "%s%s%n\n"),
      sliced("pattern with two numbers", "no pattern of file names", "", "a%d%d.raw 4 8 2\n"),
      sliced("pattern of endless width", "no pattern of file names", "", "a%0999999999d.raw 4 8 2\n"),
      sliced("pattern that ends in its percent", "no pattern of file names", "", "a%\n"),
      sliced("name with a control character", "control characters", "", "a\x1d.raw\n"),
  });
}

TEST_CASE("MetaImage headers that contradict themselves are refused", "[meta][bad]") {
  const auto voxels = samples<short>();
  const auto with = [&](const std::string& fields) { return header(fields, "LOCAL\n") + voxels; };
  const auto plain = [&](const std::string& n, const std::string& sizes, const std::string& type) {
    return "NDims = " + n + "\nDimSize = " + sizes + "\nElementType = " + type +
           "\nElementDataFile = LOCAL\n" + voxels;
  };
  check_all({
      file("no key", "line 5, 'MET_SHORT', is not", "a.mha", with("MET_SHORT\n")),
      file("twice", "DimSize is given twice", "a.mha", with("DimSize = 5 4 3\n")),
      file("no end", "no line ElementDataFile", "a.mha",
           "NDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n"),
      file("endless", "no line ElementDataFile", "a.mha",
           "NDims = 3\nComment = " + std::string(2 << 20, 'x')),
      file("no type", "ElementType is missing", "a.mha",
           "NDims = 3\nDimSize = 5 4 3\nElementDataFile = LOCAL\n"),
      file("no dimensions", "NDims is missing", "a.mha",
           "DimSize = 5 4 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"),
      file("no sizes", "DimSize is missing", "a.mha",
           "NDims = 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"),
      file("dimensions that are none", "NDims is '3x'", "a.mha", plain("3x", "5 4 3", "MET_SHORT")),
      file("too few sizes", "DimSize has 2 numbers, 3 are needed", "a.mha", plain("3", "5 4", "MET_SHORT")),
      file("a size that is none", "'4.5' is not a number", "a.mha", plain("3", "5 4.5 3", "MET_SHORT")),
      file("a size beyond int", "DimSize is 5000000000", "a.mha", plain("3", "5000000000 1 1", "MET_SHORT")),
      file("a size beyond 64 bits", "'99999999999999999999' is not", "a.mha",
           plain("3", "99999999999999999999 1 1", "MET_SHORT")),
      file("several volumes, cut short", "promises 160 bytes", "a.mha", plain("4", "5 4 1 4", "MET_SHORT")),
      file("several volumes that overflow", "overflow 64 bits", "a.mha",
           plain("4", "2000000000 2000000000 1 2000000000", "MET_SHORT")),
      file("too many channels", "rows of 5 voxels of 2147483647", "a.mha",
           with("ElementNumberOfChannels = 2147483647\n")),
      file("channels beyond int", "ElementNumberOfChannels is 4294967297", "a.mha",
           with("ElementNumberOfChannels = 4294967297\n")),
      file("unknown type", "voxels of type 'MET_QUATERNION'", "a.mha", plain("3", "5 4 3", "MET_QUATERNION")),
      file("no image", "ObjectType is 'Mesh'", "a.mha",
           "ObjectType = Mesh\n" + plain("3", "5 4 3", "MET_SHORT")),
      file("neither true nor false", "BinaryData is 'maybe'", "a.mha", with("BinaryData = maybe\n")),
      file("negative channels", "ElementNumberOfChannels is '-1'", "a.mha",
           with("ElementNumberOfChannels = -1\n")),
      file("negative header", "HeaderSize is '-2'", "a.mha", with("HeaderSize = -2\n")),
      file("negative compressed size", "CompressedDataSize is '-1'", "a.mha",
           with("CompressedDataSize = -1\n")),
      file("endless spacing", "is not a number", "a.mha", with("ElementSpacing = 1 1 1e999\n")),
      file("infinite spacing", "spacing 1 1 inf", "a.mha", with("ElementSpacing = 1 1 inf\n")),
      file("an origin that is no number", "origin is not finite", "a.mha", with("Offset = 1 nan 1\n")),
      file("a small matrix", "TransformMatrix has 4 numbers, 9 are needed", "a.mha",
           with("TransformMatrix = 1 0 0 1\n")),
      file("a singular matrix", "singular", "a.mha", with("TransformMatrix = 1 0 0 1 0 0 0 0 1\n")),
  });
}

TEST_CASE("MetaImage text that is no number of its type is refused", "[meta][bad]") {
  const auto with = [](const std::string& type, const std::string& words) {
    return "NDims = 3\nDimSize = 2 2 1\nBinaryData = False\nElementType = " + type +
           "\nElementDataFile = LOCAL\n" + words;
  };
  check_all({
      file("too few", "promises more numbers than the 3 that the file holds", "a.mha",
           with("MET_SHORT", "10 20 30\n")),
      file("a word", "voxel 2, 'three', is not a number of type int16", "a.mha",
           with("MET_SHORT", "1 2 three 4")),
      file("too large", "'300'", "a.mha", with("MET_UCHAR", "1 2 300 4")),
      file("negative", "'-1'", "a.mha", with("MET_UCHAR", "1 2 -1 4")),
      file("a fraction", "'1.5'", "a.mha", with("MET_INT", "1 1.5 2 3")),
      file("endless", "xxx...", "a.mha", with("MET_INT", "1 2 3 " + std::string(100'000, 'x'))),
  });
  const Folder folder;
  const auto source = open_volume(write(folder / "a.mha", with("MET_DOUBLE", "1e3 -0.5 +2 .25")));
  const double expected[] = {1000, -0.5, 2, 0.25};
  CHECK(read_all(*source) == std::string(reinterpret_cast<const char*>(expected), sizeof expected));
}
