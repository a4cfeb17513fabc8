#pragma once
// An AMReX plotfile made at run time, text by text.
#include <fmt/format.h>

#include "formats/files.hpp"

namespace files {

/// The sample volume in two boxes along x, each in a file, and twice the sample before it.
struct Plotfile {
  bool big_endian = false, wide = false;
  std::string header, cells;  ///< may be changed before it is written
  std::string fabs[2];

  explicit Plotfile(bool big = false, bool is_wide = false) : big_endian(big), wide(is_wide) {
    header =
        "HyperCLaw-V1.1\n2\nrho\nTemp\n3\n0.5\n1\n10 20 30 \n15 28 39 \n2 \n((1,-2,3) (5,1,5) (0,0,0)) "
        "((2,-4,6) "
        "(11,3,11) (0,0,0)) \n7 14 \n1 2 3 \n0.5 1 1.5 \n0\n0\n0 2 0.5\n7\n10 12\n20 28\n30 39\n12 15\n20 "
        "28\n30 39\n"
        "Level_0/Cell\n";
    cells =
        "1\n1\n2\n0\n(2 0\n((1,-2,3) (2,1,5) (0,0,0))\n((3,-2,3) (5,1,5) (0,0,0))\n)\n2\nFabOnDisk: "
        "Cell_D_00000 0\n"
        "FabOnDisk: Cell_D_00001 5\n\n2,2\n0,0,\n0,0,\n";
    fabs[0] = fab("((1,-2,3) (2,1,5) (0,0,0))", 0, 2);
    fabs[1] = "other" + fab("((3,-2,3) (5,1,5) (0,0,0))", 2, 5);
  }
  static const char* reals(bool big_endian, bool wide) {
    return wide         ? big_endian ? "((8, (64 11 52 0 1 12 0 1023)),(8, (1 2 3 4 5 6 7 8)))"
                                     : "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))"
           : big_endian ? "((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))"
                        : "((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1)))";
  }
  std::string value(double number) const {
    return wide ? bytes_of(number, big_endian) : bytes_of(float(number), big_endian);
  }
  /// Of the sample's columns from `begin` to `end`.
  std::string fab(const std::string& box, int begin, int end) const {
    std::string bytes = fmt::format("FAB {}{} 2\n", reals(big_endian, wide), box);
    for (const double factor : {2, 1})
      for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
          for (int x = begin; x < end; ++x) bytes += value(factor * sample<double>(x, y, z));
    return bytes;
  }
  fs::path write_to(const fs::path& folder) const {
    fs::create_directories(folder / "Level_0");
    write(folder / "Header", header);
    write(folder / "Level_0/Cell_H", cells);
    for (int i = 0; i < 2; ++i) write(folder / fmt::format("Level_0/Cell_D_0000{}", i), fabs[i]);
    return folder;
  }
};

}  // namespace files
