// How a volume's files are told apart from others and from earlier versions of themselves.
#include <OpenImageIO/imageio.h>

#include <chrono>

#include "formats/files.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "volume/synth.hpp"

using namespace files;

namespace {

/// Changes the time of last change, however coarse the file system's clock.
void touch(const fs::path& path) {
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(2));
}

void write_page(const fs::path& path, int side, int value) {
  auto out = OIIO::ImageOutput::create(path.string());
  out->open(path.string(), OIIO::ImageSpec(side, side, 1, OIIO::TypeDesc::UINT8));
  out->write_image(OIIO::TypeDesc::UINT8,
                   std::vector<std::uint8_t>(std::size_t(side * side), std::uint8_t(value)).data());
  out->close();
}

void write_pages(const fs::path& folder, int pages = 3) {
  fs::create_directories(folder);
  for (int z = 0; z < pages; ++z) write_page(folder / ("page" + std::to_string(z) + ".tif"), 8, z);
}

/// The fields in which two volumes' facts differ.
std::vector<std::string> differing_fields(const fs::path& a, const fs::path& b,
                                          const RawDescription& raw = {}) {
  const Facts left = open_volume(a, raw)->facts(), right = open_volume(b, raw)->facts();
  std::vector<std::string> fields;
  for (std::size_t i = 0; i < std::max(left.size(), right.size()); ++i)
    if (i >= left.size() || i >= right.size() || left[i] != right[i])
      fields.push_back(i < left.size() ? left[i].field : right[i].field);
  return fields;
}

std::string complaint_of_reading(VolumeSource& source) {
  return message_of([&] { static_cast<void>(read_all(source)); });
}

using Fields = std::vector<std::string>;

}  // namespace

TEST_CASE("every source that all processes read says what it reads") {
  const Folder folder;
  const auto raw = write(folder / "a_5x4x3_uint8.raw", samples<std::uint8_t>());
  const auto nrrd =
      write(folder / "a.nrrd",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 4 3\nencoding: raw\n\n" + samples<std::uint8_t>());
  const auto meta =
      write(folder / "a.mha",
            "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\nElementDataFile = "
            "LOCAL\n" +
                samples<std::uint8_t>());
  for (const char* slice : {"s0", "s1", "s2"}) write(folder / slice, std::string(20, '7'));
  const auto list = write(folder / "list.mhd",
                          "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\n"
                          "ElementDataFile = LIST\ns0\ns1\ns2\n");
  const auto nifti = write(folder / "a.nii", Nifti{}.header() + samples<short>());
  write_pages(folder / "pages");
  fs::create_directory(folder / "series");
  write_dicom_series(folder / "series");
  for (const auto& path : {raw, nrrd, meta, list, nifti, folder / "pages", folder / "series"}) {
    INFO(path);
    const auto source = open_volume(path);
    const Facts facts = source->facts();
    REQUIRE(source->concurrent());
    const auto has = [&](const std::string& field) {
      return std::any_of(facts.begin(), facts.end(), [&](const Fact& f) { return f.field.find(field) == 0; });
    };
    CHECK(has("encoding"));
    CHECK(has("file size"));
    CHECK(has("hash of the first bytes"));
    CHECK(has("hash of the last bytes"));
    CHECK(source->facts() == facts);
    RawDescription respaced;
    respaced.spacing = glm::dvec3(2);
    CHECK(open_volume(path, respaced)->facts() == facts);
  }
  CHECK(synth_source("ball", open_volume(raw)->grid())->facts() !=
        synth_source("point", open_volume(raw)->grid())->facts());
}

TEST_CASE("only the first and last bytes of the voxels are looked at, whatever lies around them") {
  const Folder folder;
  const std::size_t side = 64, bytes = side * side * side;
  RawDescription raw;
  raw.dims = glm::ivec3(64);
  raw.type = ScalarType::uint8;
  raw.offset = 16;
  const auto file = [&](const std::string& name, std::size_t at) {
    std::string text(16 + bytes + 16, 'v');
    text[at] = 'w';
    return write(folder / name, text);
  };
  const auto plain = file("plain.raw", 0);
  CHECK(differing_fields(plain, file("header.raw", 15), raw).empty());
  CHECK(differing_fields(plain, file("tail.raw", 16 + bytes), raw).empty());
  CHECK(differing_fields(plain, file("middle.raw", 16 + bytes / 2), raw).empty());
  CHECK(differing_fields(plain, file("first.raw", 16), raw) == Fields{"hash of the first bytes"});
  CHECK(differing_fields(plain, file("early.raw", 16 + 65535), raw) == Fields{"hash of the first bytes"});
  CHECK(differing_fields(plain, file("late.raw", 16 + bytes - 65536), raw) ==
        Fields{"hash of the last bytes"});
  CHECK(differing_fields(plain, file("last.raw", 16 + bytes - 1), raw) == Fields{"hash of the last bytes"});
}

TEST_CASE("encoding, offset, byte order and size of a file are facts") {
  const Folder folder;
  const std::string head = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 5 4 3\n";
  const auto little = write(folder / "a.nrrd", head + "encoding: raw\nendian: little\n\n" + samples<short>());
  const auto big = write(folder / "c.nrrd", head + "encoding: raw\nendian: big\n#ab\n\n" + samples<short>());
  CHECK(differing_fields(little, big) == Fields{"byte order", "offset", "file size"});
  const auto zipped =
      write(folder / "d.nrrd", head + "encoding: gzip\nendian: little\n\n" + gzip(samples<short>()));
  CHECK(differing_fields(little, zipped).front() == "encoding");
}

TEST_CASE("a folder of slices is known by its files' number, names, sizes and bytes") {
  const Folder folder;
  for (const char* name : {"a", "b"}) write_pages(folder / name);
  const auto fields = [&] { return differing_fields(folder / "a", folder / "b"); };
  CHECK(fields().empty());
  write_page(folder / "b" / "page1.tif", 8, 77);
  CHECK(fields() == Fields{"hash of the first bytes of page1.tif", "hash of the last bytes of page1.tif"});
  write_page(folder / "b" / "page1.tif", 8, 1);
  fs::rename(folder / "b" / "page1.tif", folder / "b" / "page1b.tif");
  CHECK(fields().front() == "file 2");
  write_page(folder / "b" / "page9.tif", 8, 9);
  CHECK(fields().front() == "number of files");
}

TEST_CASE("a file that changes after it was opened is refused, not read as something else") {
  const Folder folder;
  const auto path = folder / "a_5x4x3_uint8.raw";
  const auto fresh = [&] { return open_volume(write(path, samples<std::uint8_t>())); };
  auto source = fresh();
  CHECK(complaint_of_reading(*source).empty());
  fs::resize_file(path, 30);
  CHECK(says(complaint_of_reading(*source), "has changed since it was opened: 30 bytes instead of 60"));
  source = fresh();
  write(path, std::string(60, 'x'));
  touch(path);
  CHECK(says(complaint_of_reading(*source), "has changed since it was opened: other bytes"));
  source = fresh();
  write(path, std::string(90, 'x'));
  CHECK(says(complaint_of_reading(*source), "has changed since it was opened: 90 bytes instead of 60"));
  source = fresh();
  fs::remove(path);
  CHECK(complaint_of_reading(*source).empty());
}

TEST_CASE("a compressed file that becomes shorter after it was opened is refused") {
  const Folder folder;
  const auto path =
      write(folder / "a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5 4 3\nencoding: gzip\n\n" +
                                   gzip(samples<std::uint8_t>()));
  const auto source = open_volume(path);
  fs::resize_file(path, fs::file_size(path) - 20);
  CHECK(says(complaint_of_reading(*source), "a.nrrd"));
}

TEST_CASE("a page that is cut, replaced or gone after the stack was opened is refused") {
  const Folder folder;
  const auto page = folder / "pages" / "page1.tif";
  const auto fresh = [&] {
    write_pages(folder / "pages");
    return open_volume(folder / "pages");
  };
  auto source = fresh();
  CHECK(complaint_of_reading(*source).empty());
  source = fresh();
  fs::resize_file(page, 20);
  CHECK(says(complaint_of_reading(*source), "page1.tif has changed since it was opened"));
  source = fresh();
  write_page(page, 64, 1);
  CHECK(says(complaint_of_reading(*source), "page1.tif has changed since it was opened"));
  source = fresh();
  fs::remove(page);
  CHECK(says(complaint_of_reading(*source), "cannot open " + page.string()));
}

TEST_CASE("a slice that is larger when it is read than when the series was opened is refused") {
  const Folder folder;
  write_dicom_series(folder.path());
  const auto source = open_volume(folder.path());
  Dicom large;
  large.columns = large.rows = 512;
  large.number = 2;
  large.position = "-10\\-20\\-27";
  large.pixels = std::string(std::size_t(512 * 512) * 2, '\1');
  write(folder / "image2.dcm", large.bytes());
  CHECK(says(complaint_of_reading(*source), "image2.dcm has changed since it was opened"));
}

TEST_CASE("a volume that is decoded as a whole is refused when its file is another by then") {
  const Folder folder;
  const auto header = [](const std::string& sizes) {
    return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " + sizes + "\nencoding: ascii\n\n";
  };
  std::string numbers, many;
  for (int i = 0; i < 60; ++i) numbers += "1 ";
  for (int i = 0; i < 60'000; ++i) many += "1 ";
  const auto path = write(folder / "a.nrrd", header("5 4 3") + numbers);
  const auto source = open_volume(path);
  write(path, header("50 40 30") + many);
  CHECK(says(complaint_of_reading(*source), "a.nrrd has changed since it was opened"));
}
