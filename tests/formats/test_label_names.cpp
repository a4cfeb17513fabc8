#include "formats/nrrd/header.hpp"

#include "formats/files.hpp"
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
