// What yt reads of the same plotfiles is in tests/files.
#include "formats/amrex.hpp"
#include "formats/bad_files.hpp"
#include "formats/captured_log.hpp"

using namespace files;

namespace {

Bad plotfile(const char* what, const char* message, const std::function<void(Plotfile&)>& change) {
  return {what, message, [=](const Folder& f) {
            Plotfile plot;
            change(plot);
            return plot.write_to(f / "plt00000");
          }};
}
Bad header(const char* what, const char* message, const std::string& from, const std::string& to) {
  return plotfile(what, message, [=](Plotfile& plot) { plot.header = replaced(plot.header, from, to); });
}
Bad cells(const char* what, const char* message, const std::string& from, const std::string& to) {
  return plotfile(what, message, [=](Plotfile& plot) { plot.cells = replaced(plot.cells, from, to); });
}

}  // namespace

TEST_CASE("level 0 of a plotfile is put together from its boxes", "[amrex]") {
  const Folder folder;
  for (const bool big_endian : {false, true})
    for (const bool wide : {false, true}) {
      CAPTURE(big_endian, wide);
      const auto path = Plotfile(big_endian, wide).write_to(folder / "plt00000");
      for (const char* channel : {"temp", "1"}) {
        const auto source = open_volume(path, {}, {.channel = channel});
        CHECK(source->concurrent());
        const auto& grid = source->grid();
        CHECK(grid.type == (wide ? ScalarType::float64 : ScalarType::float32));
        CHECK(grid.dims == glm::ivec3(nx, ny, nz));
        CHECK(grid.spacing == glm::dvec3(1, 2, 3));
        CHECK(grid.origin == glm::dvec3(10.5, 21, 31.5));
        CHECK(grid.direction == glm::dmat3(1));
        CHECK((read_all(*source) == (wide ? samples<double>() : samples<float>())));
        CHECK((read_slice(*source, 1) ==
               read_all(*source).substr(grid.slice_bytes(Axis::z), grid.slice_bytes(Axis::z))));
        const auto notes = source->notes();
        CHECK(notes.world == World::lattice);
        CHECK(notes.quantity == "Temp");
        CHECK(notes.channels == 2);
        REQUIRE(notes.of_channels.size() == 2);
        CHECK(notes.of_channels[0].name == "rho");
        CHECK(notes.of_channels[1].name == "Temp");
      }
    }
}

TEST_CASE("of a plotfile without a choice the first component is shown, and lines say what is not",
          "[amrex]") {
  const Folder folder;
  const auto path = Plotfile(false, true).write_to(folder / "plt00000");
  const CapturedLog log;
  const auto source = open_volume(path);
  std::string twice;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) twice += bytes_of(2 * sample<double>(x, y, z));
  CHECK((read_all(*source) == twice));
  CHECK(says(log.text(), "level 0 of 2 is shown, the coarsest"));
  CHECK(says(log.text(), "of the channels 0 (rho), 1 (Temp) the first is shown"));
}

TEST_CASE("a plotfile of one box and one component", "[amrex]") {
  const Folder folder;
  Plotfile plot;
  const std::string box = "((0,0,0) (4,3,2) (0,0,0))";
  plot.header =
      "NavierStokes-V1.1\n1\nx velocity\n3\n0\n0\n0 0 0\n1 1 1\n\n" + box + "\n0\n0.2 0.25 0.5\n0\n0\n";
  plot.cells = "1\n0\n1\n(0,0,0)\n(1 0\n" + box + "\n)\n1\nFabOnDisk: Cell_D_00000 0\n";
  plot.fabs[0] = fmt::format("FAB {}{} 1\n", Plotfile::reals(false, false), box) + samples<float>();
  const CapturedLog log;
  const auto source = open_volume(plot.write_to(folder / "plt00000"));
  CHECK((read_all(*source) == samples<float>()));
  CHECK(source->grid().spacing == glm::dvec3(0.2, 0.25, 0.5));
  CHECK(source->notes().quantity == "x velocity");
  CHECK(log.text().empty());
}

TEST_CASE("plotfiles with no such component are refused", "[bad]") {
  const Folder folder;
  const auto path = Plotfile().write_to(folder / "plt00000");
  for (const char* channel : {"2", "-1", "pressure"})
    CHECK(says(message_of([&] { open_volume(path, {}, {.channel = channel}); }), "has no such channel"));
}

TEST_CASE("plotfiles that are damaged, or hold something else, are refused", "[bad]") {
  check_all({
      plotfile("no Header's text", "Header: it ends behind line 0, before its version",
               [](Plotfile& p) { p.header.clear(); }),
      plotfile("Header cut short", "Header: it ends behind line 12, before the size of cells",
               [](Plotfile& p) { p.header.resize(p.header.find("1 2 3 \n")); }),
      header("particles", "holds a checkpoint or particles, 'Version_Two'", "HyperCLaw-V1.1", "Version_Two"),
      header("a checkpoint", "holds a checkpoint or particles", "HyperCLaw-V1.1", "CheckPointVersion_1.0"),
      header("no components", "line 2, '0', is not a number of components", "\n2\n", "\n0\n"),
      header("too many", "'2000000000', is not a number of components", "\n2\n", "\n2000000000\n"),
      header("more names than there are", "is not 3, the dimensions of a volume", "\n2\n", "\n3\n"),
      header("two dimensions", "line 5, '2', is not 3, the dimensions of a volume", "\n3\n", "\n2\n"),
      header("levels", "'2000000000', is not the finest level's number", "\n1\n10", "\n2000000000\n10"),
      header("no level", "'-1', is not the finest level's number", "\n1\n10", "\n-1\n10"),
      header("corner", "'10 20', is not the domain's corner", "10 20 30", "10 20"),
      header("no number", "'x 20 30', is not the domain's corner", "10 20 30", "x 20 30"),
      header("infinite", "is not the domain's corner", "10 20 30", "inf 20 30"),
      header("a domain of nodes", "is not boxes of cells", "(0,0,0)", "(1,1,1)"),
      header("an empty domain", "is not boxes of cells", "(1,-2,3)", "(6,-2,3)"),
      header("a huge domain", "is not boxes of cells", "(5,1,5)", "(2000000000,1,5)"),
      header("a domain of one number", "is not boxes of cells", "((1,-2,3) ", "(1 "),
      header("overflowing", "overflow 64 bits", "((1,-2,3) (5,1,5)",
             "((-500000000,-500000000,-500000000) (500000000,500000000,500000000)"),
      header("a gap", "leave a gap: they hold 60 of 75 voxels", "(5,1,5)", "(5,2,5)"),
      header("spacing", "spacing 0 2 3", "1 2 3 ", "0 2 3 "),
      header("no spacing", "'1 2', is not the size of cells", "1 2 3 ", "1 2"),
      header("spheres", "line 15, '2', is not 0, for Cartesian coordinates", "\n0\n0\n0 2", "\n2\n0\n0 2"),
      cells("Cell_H cut short", "Cell_H: it ends behind line 9, before the boxes' files",
            "FabOnDisk: Cell_D_00000 0\nFabOnDisk: Cell_D_00001 5\n\n2,2\n0,0,\n0,0,\n", ""),
      cells("boxes without headers", "line 1, '2', is not version 1, whose boxes describe themselves",
            "1\n1\n", "2\n1\n"),
      cells("components", "'3', is not Header's number of components", "1\n2\n", "1\n3\n"),
      cells("ghosts", "line 4, '1', is not 0, for boxes without ghost cells", "2\n0\n", "2\n1\n"),
      cells("ghosts along an axis", "'(0,0,1)', is not 0, for boxes", "2\n0\n", "2\n(0,0,1)\n"),
      cells("many boxes", "'(1000000000 0', is not a number of boxes up to 65536", "(2 0", "(1000000000 0"),
      cells("no boxes", "is not the number of boxes",
            "(2 0\n((1,-2,3) (2,1,5) (0,0,0))\n((3,-2,3) (5,1,5) (0,0,0))\n)\n2", "(0 0\n)\n0"),
      cells("fewer boxes", "line 7, ')', is not boxes of cells", "((3,-2,3) (5,1,5) (0,0,0))\n", ""),
      cells("another count", "line 9, '1', is not the number of boxes", ")\n2\n", ")\n1\n"),
      cells("a bad box", "line 6, '((1,-2,3) (2,1) (0,0,0))', is not boxes of cells", "(2,1,5)", "(2,1)"),
      cells("outside", "is not a box within the domain", "(5,1,5)", "(6,1,5)"),
      cells("another box than in the file",
            "where float32 or float64 values of the box 1 -2 3 1 1 5 0 0 0 2 belong", "(2,1,5)", "(1,1,5)"),
      cells("path above", "'FabOnDisk: ../Cell_D_00000 0', is not a box's file beside this one",
            "Cell_D_00000", "../Cell_D_00000"),
      cells("absolute path", "is not a box's file beside this one", "Cell_D_00000", "/etc/passwd"),
      cells("the folder above", "not a regular file", "Cell_D_00000", ".."),
      cells("no such file", "Cell_D_00009: No such file", "Cell_D_00000", "Cell_D_00009"),
      cells("no offset", "is not a box's file beside this one, and an offset", "00001 5", "00001 -5"),
      cells("offset in the middle", "at byte 9 is '", "00001 5", "00001 9"),
      cells("offset behind the end", "the file holds 0", "00001 5", "00001 18446744073709551615"),
      plotfile("no FAB", "at byte 0 is '' where", [](Plotfile& p) { p.fabs[0] = "\n" + p.fabs[0]; }),
      plotfile("cut Cell_D", "of voxels, the file holds 287", [](Plotfile& p) { p.fabs[1].pop_back(); }),
      plotfile("unknown reals", "where float32 or float64 values of the box",
               [](Plotfile& p) { p.fabs[1] = replaced(p.fabs[1], "4 3 2 1", "2 1 4 3"); }),
      plotfile("two types", "its boxes are of two types",
               [](Plotfile& p) { p.fabs[1] = Plotfile(false, true).fabs[1]; }),
      plotfile("overlap", "overlap",
               [](Plotfile& p) {
                 p.cells = replaced(p.cells, "((3,", "((2,");
                 p.fabs[1] = "other" + p.fab("((2,-2,3) (5,1,5) (0,0,0))", 1, 5);
               }),
  });
}
