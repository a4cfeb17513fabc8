// What nibabel writes is in tests/files.
#include <limits>

#include "formats/bad_files.hpp"
#include "formats/mgh.hpp"

using namespace files;

TEST_CASE("FreeSurfer's volumes without a place are coronal", "[mgh]") {
  const Folder folder;
  Mgh nowhere;
  nowhere.has_place = false;
  const auto source = open_volume(write(folder / "a.mgz", gzip(nowhere.header() + samples<short>(true))));
  CHECK_FALSE(source->concurrent());
  CHECK(source->grid().spacing == glm::dvec3(1));
  CHECK(source->grid().origin == glm::dvec3(-2.5, 1.5, 2));
  CHECK(source->grid().direction == glm::dmat3(1, 0, 0, 0, 0, -1, 0, -1, 0));
  CHECK((read_all(*source) == samples<short>()));
  CHECK(open_volume(write(folder / "a.mgh", Mgh().header() + samples<short>(true)))->concurrent());
}

TEST_CASE("FreeSurfer's volumes that are damaged are refused", "[bad]") {
  const auto with = [](auto&& change) {
    Mgh mgh;
    change(mgh);
    return mgh.header() + samples<short>(true);
  };
  check_all({
      file("prose", "its data ends at byte 5", "a.mgh", "hello"),
      file("no gzip", "its data ends at byte 5", "a.mgz", "hello"),
      file("gzip cut short", "cut short or damaged", "a.mgz", gzip(with([](Mgh&) {})).substr(0, 100)),
      file("cut short", "promises 120 bytes of voxels, the file holds 119", "a.mgh",
           with([](Mgh&) {}).substr(0, 284 + 119)),
      file("version", "its version is 2, not 1", "a.mgh", with([](Mgh& mgh) { mgh.version = 2; })),
      file("type", "voxels of type 6 cannot be rendered", "a.mgh", with([](Mgh& mgh) { mgh.type = 6; })),
      file("no frames", "it has 0 frames", "a.mgh", with([](Mgh& mgh) { mgh.sizes[3] = 0; })),
      file("no rows", "5 x 0 x 3", "a.mgh", with([](Mgh& mgh) { mgh.sizes[1] = 0; })),
      file("huge", "overflow 64 bits", "a.mgh", with([](Mgh& mgh) {
             mgh.sizes = {2000000000, 2000000000, 2000000000, 1};
           })),
      file("many frames", "overflow 64 bits", "a.mgh", with([](Mgh& mgh) {
             mgh.sizes = {2000000, 2000000, 2000000, 2000000000};
           })),
      file("no numbers", "the origin is not finite", "a.mgh",
           with([](Mgh& mgh) { mgh.place[12] = std::numeric_limits<float>::quiet_NaN(); })),
      file("one axis twice", "direction matrix is singular", "a.mgh",
           with([](Mgh& mgh) { mgh.place[8] = 0, mgh.place[6] = 1; })),
      file("spacing", "spacing 0 2 3", "a.mgh", with([](Mgh& mgh) { mgh.place[0] = 0; })),
  });
}
