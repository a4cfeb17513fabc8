#include "formats/files.hpp"
#include "formats/label_notes.hpp"
#include "support/catch.hpp"

using namespace files;

namespace {

const std::string fields = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n";

}  // namespace

TEST_CASE("A segmentation's names and colours are found by their values, wherever they stand in the header") {
  const Folder folder;
  const auto file =
      write(folder / "a.seg.nrrd", fields +
                                       "Segment1_Name:=left kidney\nSegment0_LabelValue:=1\n"
                                       "Segment0_Name:=li\aver\r\nSegment1_LabelValue:=7\n"
                                       "Segment0_Color:=0.5 0.25 1.5\n"
                                       "Segment2_Name:=without a value\nSegment3_LabelValue:=9\n\n"
                                       "Segment4_Name:=data\nSegment4_LabelValue:=4\n");
  const auto names = detail::label_notes(file);
  REQUIRE(names.size() == 2);
  CHECK(names.at(1).name == "li\\x07ver");
  CHECK(names.at(1).colour == glm::dvec3(0.5, 0.25, 1));
  CHECK(names.at(7).name == "left kidney");
  CHECK_FALSE(names.at(7).colour);
}

TEST_CASE("An OME-Zarr image's labels have their colours and names, its levels' too") {
  const Folder folder;
  const auto image = folder / "cells";
  std::filesystem::create_directories(image / "0");
  write(image / ".zgroup", R"({"zarr_format": 2})");
  write(image / ".zattrs", R"({"multiscales": [{}], "image-label": {
    "colors": [{"label-value": 1, "rgba": [255, 51, 0, 128]}, {"label-value": 3, "rgba": [0, 300, 0, 255]}, {"label-value": 5}],
    "properties": [{"label-value": 1, "class": "nucleus"}, {"label-value": 2, "name": "cell\u0007", "area": 12}]}})");
  write(image / "0" / ".zarray", R"({"zarr_format": 2})");
  for (const auto& path : {image, image / "0"}) {
    const auto notes = detail::label_notes(path);
    REQUIRE(notes.size() == 3);
    CHECK(notes.at(1).name == "nucleus");
    CHECK(notes.at(1).colour == glm::dvec3(1, 0.2, 0));
    CHECK(notes.at(2).name == "cell\\x07");
    CHECK_FALSE(notes.at(2).colour);
    CHECK(notes.at(3).colour == glm::dvec3(0, 1, 0));
  }
  write(image / ".zattrs", R"({"image-label": {"colors": [{"rgba": [1, 2, 3]}]}})");
  CHECK(detail::label_notes(image).empty());
}

TEST_CASE("Other files have no names of labels") {
  const Folder folder;
  CHECK(detail::label_notes(folder / "missing.nrrd").empty());
  CHECK(detail::label_notes(folder.path()).empty());
  CHECK(detail::label_notes(write(folder / "plain.nrrd", fields + "\n1")).empty());
  CHECK(
      detail::label_notes(write(folder / "other.mhd", "Segment0_Name:=a\nSegment0_LabelValue:=1\n")).empty());
  CHECK(
      detail::label_notes(write(folder / "long.nrrd", "NRRD0004\nSegment0_Name:=" + std::string(100000, 'a') +
                                                          "\nSegment0_LabelValue:=1\n\n"))
          .empty());
}
