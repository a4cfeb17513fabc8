#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "support/catch.hpp"
#include "volume/bad_files.hpp"
#include "volume/captured_log.hpp"
#include "volume/files.hpp"

using namespace files;

namespace {

/// Writes pages of 4 x 3 pixels, with a description in the first and a resolution in pixels a unit.
fs::path write_pages(const fs::path& path, int pages, const std::string& description, float resolution = 0) {
  OIIO::ImageSpec spec(4, 3, 1, OIIO::TypeDesc::UINT8);
  const std::string pixels(12, 'p');
  auto out = OIIO::ImageOutput::create(path.string());
  for (int i = 0; i < pages; ++i) {
    spec.extra_attribs.clear();
    if (i == 0) spec.attribute("ImageDescription", description);
    if (resolution > 0) spec.attribute("XResolution", resolution);
    if (resolution > 0) spec.attribute("PixelAspectRatio", 2.0F);
    REQUIRE(out->open(path.string(), spec,
                      i == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage));
    REQUIRE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  }
  out->close();
  return path;
}

std::string image_j(const std::string& lines) {
  return "ImageJ=1.53t\n" + lines + "loop=false\nmin=0.0\nmax=255.0\n";
}

std::string ome(const std::string& pixels, const std::string& inside = {}) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><!-- a > b --><OME "
         "xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\"><Pixels "
         "ID=\"Pixels:0\" "
         "Type=\"uint8\" SizeX=\"4\" SizeY=\"3\" " +
         pixels + ">" + inside + "</Pixels></Image></OME>";
}

Bad pages(const char* what, const char* message, int count, const std::string& description) {
  return {what, message, [=](const Folder& f) { return write_pages(f / "a.tif", count, description); }};
}

std::string file_uuid(const std::string& name) {
  return "<TiffData IFD=\"0\"><UUID FileName=\"" + name + "\">urn:uuid:1</UUID></TiffData>";
}

std::string warnings_of(const fs::path& path, const RawDescription& raw = {}) {
  const CapturedLog log;
  open_volume(path, raw);
  return log.text();
}

}  // namespace

TEST_CASE("pages that are channels or time points are not taken for slices", "[tiff][bad]") {
  check_all({
      pages("ImageJ channels", "6 pages are 2 channels, 1 time points and 3 slices (by its ImageJ)", 6,
            image_j("images=6\nchannels=2\nslices=3\nhyperstack=true\nmode=composite\n")),
      pages("ImageJ time points", "1 channels, 3 time points and 2 slices", 6,
            image_j("images=6\nslices=2\nframes=3\nhyperstack=true\n")),
      pages("ImageJ slices in one page", "it has 300 slices (by its ImageJ), and has 1 pages", 1,
            image_j("images=300\nslices=300\n")),
      pages("ImageJ, images only", "it has 5 slices", 4, image_j("images=5\n")),
      pages("OME channels", "6 pages are 2 channels, 1 time points and 3 slices (by its OME-XML)", 6,
            ome("SizeC=\"2\" SizeZ=\"3\" SizeT=\"1\" DimensionOrder=\"XYCZT\"")),
      pages("OME time points", "1 channels, 3 time points and 2 slices", 6,
            ome("SizeC='1' SizeZ='2' SizeT='3'")),
      pages("OME slices elsewhere", "it has 9 slices", 3, ome("SizeC=\"1\" SizeZ=\"9\" SizeT=\"1\"")),
      pages("OME without a size", "SizeC, SizeT or SizeZ is missing", 3, ome("SizeC=\"1\" SizeZ=\"3\"")),
      pages("OME of several files", "it is one of 2 files", 3,
            ome("SizeC=\"1\" SizeZ=\"3\" SizeT=\"1\"", file_uuid("a.ome.tif") + file_uuid("b.ome.tif"))),
      pages("OME in another file", "another file, all.companion.ome", 3,
            "<OME><BinaryOnly MetadataFile=\"all.companion.ome\" UUID=\"urn:uuid:2\"/></OME>"),
      pages("OME of several images", "it holds 2 images", 2,
            "<ome:OME xmlns:ome='x'><ome:Image><ome:Pixels SizeC='1' SizeZ='1' SizeT='1'/></ome:Image>"
            "<ome:Image><ome:Pixels SizeC='1' SizeZ='1' SizeT='1'/></ome:Image></ome:OME>"),
      pages("OME cut short", "holds 0 images", 2, "<OME><Image><Pix"),
  });
}

TEST_CASE("a microscope's single stack is read, and its voxels' size is told", "[tiff]") {
  const Folder folder;
  const auto j =
      write_pages(folder / "j.tif", 3, image_j("images=3\nslices=3\nunit=\\u00B5m\nspacing=1.5\n"), 4);
  CHECK(says(warnings_of(j),
             "voxels of 0.25 x 0.125 x 1.5 um (by its ImageJ) are taken for 1 x 1 x 1: give --spacing "
             "0.25 0.125 1.5\n"));
  CHECK(warnings_of(j).empty());  // warns only once
  CHECK(open_volume(j)->grid().dims == glm::ivec3(4, 3, 3));
  CHECK(open_volume(j)->grid().spacing == glm::dvec3(1));
  const auto o =
      write_pages(folder / "o.ome.tif", 2,
                  ome("SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\" PhysicalSizeX=\"0.2\" PhysicalSizeY=\"0.2\" "
                      "PhysicalSizeZ=\"2\" PhysicalSizeXUnit=\"\xC2\xB5m\"",
                      file_uuid("its old name.ome.tif")));
  CHECK(says(
      warnings_of(o),
      "voxels of 0.2 x 0.2 x 2 um (by its OME-XML) are taken for 1 x 1 x 1: give --spacing 0.2 0.2 2\n"));
}

TEST_CASE("nothing is told of a voxel size that is given, is 1 or is a printer's", "[tiff]") {
  const Folder folder;
  const auto sized = write_pages(folder / "j.tif", 2, image_j("images=2\nslices=2\nunit=mm\nspacing=3\n"), 4);
  RawDescription raw;
  raw.spacing = glm::dvec3(0.25, 0.125, 3);
  CHECK(warnings_of(sized, raw).empty());
  CHECK(warnings_of(write_pages(folder / "one.tif", 2, image_j("images=2\nslices=2\n"), 72)).empty());
  CHECK(warnings_of(write_pages(folder / "photo.tif", 2, "a photograph", 300)).empty());
}

TEST_CASE("a folder of single slices by ImageJ is a stack", "[tiff]") {
  const Folder folder;
  for (int z = 0; z < 3; ++z) write_pages(folder / fmt::format("s{}.tif", z), 1, image_j(""));
  CHECK(open_volume(folder.path())->grid().dims.z == 3);
}
