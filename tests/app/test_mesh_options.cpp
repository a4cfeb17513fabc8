#include "options/option_values.hpp"
#include "program/launch.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

RunOptions mesh_options(std::optional<glm::ivec2> mesh, std::optional<int> renderers = {}) {
  RunOptions o;
  o.topology = Topology::mesh;
  o.mesh = mesh;
  o.renderers = renderers;
  return o;
}

void refused(const RunOptions& o, bool over_mpi, int ranks, const std::string& part) {
  CHECK_THROWS_WITH(choose_layout(o, over_mpi, ranks), Catch::Matchers::Contains(part));
}

}  // namespace

TEST_CASE("a mesh's shape says how many GPs there are, and how many Renderers unless told otherwise") {
  CHECK(choose_layout(mesh_options(glm::ivec2{4, 4}), true, 20) == mesh_layout(4, 4, 4));
  CHECK(choose_layout(mesh_options(glm::ivec2{4, 4}, 8), true, 24) == mesh_layout(4, 4, 8));
  CHECK(choose_layout(mesh_options(glm::ivec2{3, 5}, 2), false, 1) == mesh_layout(3, 5, 2));
  RunOptions direct = mesh_options(glm::ivec2{2, 2});
  direct.routing = Routing::direct;
  CHECK(choose_layout(direct, true, 6) == mesh_layout(2, 2, 2, Routing::direct));
}

TEST_CASE("meshes that cannot be are refused with a way out") {
  refused(mesh_options({}), true, 6, "--mesh 4x4");
  refused(mesh_options(glm::ivec2{4, 4}, 9), true, 25, "--renderers 8 or fewer");
  refused(mesh_options(glm::ivec2{4, 4}, 0), true, 16, "--renderers is 0");
  refused(mesh_options(glm::ivec2{4, 4}), true, 16, "mpirun -n 20");
  refused(mesh_options(glm::ivec2{64, 64}), false, 1, "too many for one process");
  RunOptions colocated = mesh_options(glm::ivec2{2, 2});
  colocated.placement = Placement::colocated;
  refused(colocated, true, 4, "--roles colocated");
}

TEST_CASE("a mesh's shape is two numbers, or one for both") {
  CHECK(parse_mesh("4x3", "--mesh").x == 4);
  CHECK(parse_mesh("4x3", "--mesh").y == 3);
  CHECK(parse_mesh("5", "--mesh").y == 5);
  for (const char* bad : {"", "4x", "0x4", "4x4x4", "-1x2", "5000x2", "axb"})
    CHECK_THROWS_AS(parse_mesh(bad, "--mesh"), InputError);
}
