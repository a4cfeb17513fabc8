#include <filesystem>

#include "net/launcher.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/charge.hpp"
#include "simulate/machine.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

const std::string least =
    "name = \"small\"\npoll_interval = 1e-4\n[gp]\nvisible_voxel = 2e-6\ntransparent_voxel = 1e-7\n"
    "[renderer]\nsplat = 3e-6\n[platform]\nkind = \"torus\"\nbandwidth = 1e9\nlatency = 1e-6\n";

std::string complaint_about(const std::string& toml) {
  try {
    static_cast<void>(parse_machine(toml, "small.toml"));
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing was wrong";
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

}  // namespace

TEST_CASE("a machine is read from TOML; what it does not say costs nothing") {
  const Machine m =
      parse_machine(least + "cores = 4\n[message]\npacket_bytes = 1024\npacket = 1e-5\n", "here");
  CHECK(m.name == "small");
  CHECK(m.gp.visible_voxel == 2e-6);
  CHECK(m.gp.token == 0);
  CHECK(m.renderer.splat == 3e-6);
  CHECK(m.poll_interval == 1e-4);
  CHECK(m.platform.kind == PlatformKind::torus);
  CHECK(m.platform.cores == 4);
  CHECK(m.message.packet_bytes == 1024);
}

TEST_CASE("what a machine does not say of sheets stands in a ratio to what it says of splats") {
  const Machine said = parse_machine(least + "[sheets]\nsample = 4e-6\nlook = 0\n", "here");
  CHECK(said.sheets.sample == 4e-6);
  CHECK(said.sheets.look == 0);
  const Machine silent = parse_machine(least, "here");
  CHECK(silent.sheets.sample == Approx(0.1 * silent.renderer.splat));
  CHECK(silent.sheets.copy > 0);
  CHECK(silent.sheets.table == said.sheets.table);
}

TEST_CASE("every machine of mpi_configs can be read") {
  int machines = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(RINGSPLAT_TEST_DATA "/../../mpi_configs/machines")) {
    if (file.path().extension() != ".toml") continue;
    ++machines;
    const Machine m = read_machine(file.path().string());
    CHECK_FALSE(m.name.empty());
  }
  CHECK(machines > 0);
}

TEST_CASE("a bad machine is refused by file and field") {
  using Catch::Matchers::Contains;
  CHECK_THAT(complaint_about("name = [\n"), Contains("small.toml"));
  CHECK_THAT(complaint_about(replaced(least, "visible_voxel", "visible_voxels")),
             Contains("small.toml: gp.visible_voxels is no field"));
  CHECK_THAT(complaint_about(replaced(least, "splat = 3e-6", "splat = -1")),
             Contains("small.toml: renderer.splat is -1, not from 0"));
  CHECK_THAT(complaint_about(replaced(least, "3e-6", "\"fast\"")),
             Contains("renderer.splat is 'fast', not a number"));
  CHECK_THAT(complaint_about(replaced(least, "splat = 3e-6\n", "")), Contains("renderer.splat is missing"));
  CHECK_THAT(complaint_about(replaced(least, "name = \"small\"\n", "")), Contains("name is missing"));
  CHECK_THAT(complaint_about(replaced(least, "torus", "doughnut")), Contains("platform.kind is 'doughnut'"));
  CHECK_THAT(complaint_about(least + "cores = 1.5\n"), Contains("platform.cores is 1.5, not a whole number"));
  CHECK_THAT(complaint_about(least + "cores = 0\n"), Contains("platform.cores is 0"));
  CHECK_THAT(complaint_about(least + "latency = 1e-6\n"), Contains("platform.latency needs one value"));
  CHECK_THAT(complaint_about(replaced(least, "1e9", "nan")), Contains("platform.bandwidth is 'nan'"));
  CHECK_THROWS_AS(read_machine("there/is/no/such.toml"), InputError);
}

TEST_CASE("costs add up as the fields say") {
  Machine m;
  m.gp.visible_voxel = 10;
  m.gp.transparent_voxel = 1;
  m.gp.slice = 1000;
  m.renderer.splat = 3;
  m.renderer.pass = 20;
  m.renderer.slice = 7;
  m.renderer.composite = 0.5;
  m.message.send = 5;
  m.message.packet = 2;
  CHECK(encoding_seconds(m, 16, 4) == 1052);
  CHECK(drawing_seconds(m, 100, 16, 8) == 631);
  CHECK(sending_seconds(m, 5000) == 7);
  m.sheets.look = 2;
  m.sheets.copy = 30;
  m.sheets.place = 50;
  m.sheets.slice = 11;
  CHECK(selecting_seconds(m, 16, 4) == 1152);
  CHECK(placing_seconds(m, 16, 4) == 243);
  m.message.packet_bytes = 2048;
  CHECK(sending_seconds(m, 4096) == 9);
  CHECK(sending_seconds(m, 4097) == 11);
}

TEST_CASE("outside of a simulation charging takes no time, and debts are still paid off") {
  CHECK_FALSE(simulated());
  charge(1e9);
  Debt debt(2);
  CHECK_FALSE(debt.pay());
  debt.owe(6.5);  // 2, 2 and 2.5: no piece as small as 0.5
  int pieces = 0;
  while (debt.pay()) ++pieces;
  CHECK(pieces == 3);
}
