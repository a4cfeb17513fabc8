#include "layering/layering.hpp"

#include <algorithm>
#include <fstream>

#include "support/catch.hpp"

namespace fs = std::filesystem;
using layering::house_rules;
using layering::violations;

namespace {

/// A small source tree that keeps the rules, in a folder of its own that goes when the test ends.
class PlantedTree {
 public:
  PlantedTree() : root_(fs::path(RINGSPLAT_TEST_SCRATCH) / "planted-tree") {
    fs::remove_all(root_);
    write("include/ringsplat/base/error.hpp", "#pragma once\n#include <string>\n");
    write("include/ringsplat/net/message.hpp", "#pragma once\n#include \"ringsplat/base/error.hpp\"\n");
    write("include/ringsplat/mpi/communicator.hpp", "#pragma once\n#include <mpi.h>\n");
    write("include/ringsplat/mpi/session.hpp", "#pragma once\n");
    write("src/net/queue.hpp", "#pragma once\n");
    write("src/net/message.cpp", "#include \"net/queue.hpp\"\n#include \"ringsplat/net/message.hpp\"\n");
    write("src/mpi/transport.cpp", "#include <mpi.h>\n#include \"ringsplat/net/message.hpp\"\n");
    write("src/app/main.cpp", "#include \"ringsplat/mpi/session.hpp\"\n");
    write("src/CMakeLists.txt", "ringsplat_room(base LIBRARIES fmt::fmt)\nringsplat_room(net USES base)\n");
  }
  ~PlantedTree() { fs::remove_all(root_); }
  PlantedTree(const PlantedTree&) = delete;
  PlantedTree& operator=(const PlantedTree&) = delete;

  void write(const std::string& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  std::vector<std::string> found() const { return violations(root_, house_rules()); }

 private:
  fs::path root_;
};

}  // namespace

TEST_CASE("the source tree keeps the rules of its rooms") {
  std::string all;
  for (const auto& line : violations(RINGSPLAT_SOURCE_DIR, house_rules())) all += line + "\n";
  INFO(all);
  CHECK(all.empty());
}

TEST_CASE("a tree without a fault passes") {
  const PlantedTree tree;
  CHECK(tree.found() == std::vector<std::string>{});
}

TEST_CASE("a planted fault is found, with its file and line") {
  struct Fault {
    std::string file, text, message;
  };
  const auto fault = GENERATE(values<Fault>({
      {"src/net/bad.cpp", "\n#include \"ringsplat/volume/grid.hpp\"\n",
       "src/net/bad.cpp:2: net may not use volume (ringsplat/volume/grid.hpp)"},
      {"include/ringsplat/base/bad.hpp", "#include \"ringsplat/net/message.hpp\"\n",
       "include/ringsplat/base/bad.hpp:1: base may not use net (ringsplat/net/message.hpp)"},
      {"src/truth/bad.cpp", "#include <ringsplat/session/render.hpp>\n",
       "src/truth/bad.cpp:1: truth may not use session (ringsplat/session/render.hpp)"},
      {"src/truth/bad.cpp", "#include \"frame/frame_geometry.hpp\"\n",
       "src/truth/bad.cpp:1: truth may not use frame (frame/frame_geometry.hpp)"},
      {"src/net/bad.cpp", "  #  include <mpi.h>\n", "src/net/bad.cpp:1: includes mpi.h, which only mpi may"},
      {"src/app/bad.cpp", "#include <OpenImageIO/imageio.h>\n",
       "src/app/bad.cpp:1: includes OpenImageIO/imageio.h, which only images may"},
      {"src/app/bad.cpp", "#include \"mpi.h\"\n", "src/app/bad.cpp:1: includes mpi.h, which only mpi may"},
      {"src/app/bad.cpp", "#include \"ringsplat/mpi/communicator.hpp\"\n",
       "src/app/bad.cpp:1: includes mpi.h by way of ringsplat/mpi/communicator.hpp"},
      {"src/base/bad.cpp", "#include \"net/queue.hpp\"\n",
       "src/base/bad.cpp:1: base may not use net (net/queue.hpp)"},
      {"src/net/bad.cpp", "#include \"queue.hpp\"\n",
       "src/net/bad.cpp:1: \"queue.hpp\" is no header of a room"},
      {"include/ringsplat/net/bad.hpp", "#include \"net/queue.hpp\"\n",
       "include/ringsplat/net/bad.hpp:1: a public header includes the private net/queue.hpp"},
      {"src/attic/bad.cpp", "\n",
       "src/attic/bad.cpp:1: is in no room; the rooms are listed in tests/layering/layering.cpp"},
      {"src/bad.cpp", "\n",
       "src/bad.cpp:1: is in no room; the rooms are listed in tests/layering/layering.cpp"},
      {"src/app/bad.cpp", "#include \"ringsplat/attic/old.hpp\"\n",
       "src/app/bad.cpp:1: includes ringsplat/attic/old.hpp, which is in no room"},
      {"src/CMakeLists.txt", "\nringsplat_room(mpi USES base net\n  node LIBRARIES MPI::MPI_CXX)\n",
       "src/CMakeLists.txt:2: mpi may not be linked with node"},
  }));
  PlantedTree tree;
  tree.write(fault.file, fault.text);
  const auto found = tree.found();
  INFO(fault.message);
  CHECK(std::count(found.begin(), found.end(), fault.message) == 1);
}

TEST_CASE("a folder without sources is not a tree without a fault") {
  CHECK_THROWS_AS(violations(fs::path(RINGSPLAT_TEST_SCRATCH) / "nowhere", house_rules()),
                  std::runtime_error);
}
