// Ranks with different files, options or builds end with one line that names the rank and the difference,
// exit code 2 and no picture.
#include <functional>
#include <map>
#include <utility>

#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

Words render(const std::string& volume, const Words& more = {}) {
  return joined({"render", volume, "-o", "out.png", "--size", "32"}, more);
}

std::string voxels(std::size_t bytes) {
  std::string text(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) text[i] = char((i * 7 + i / 64) % 120);
  return text;
}

std::string nrrd(const std::string& sizes, std::size_t bytes, const std::string& fields = {},
                 const std::string& type = "uint8") {
  return "NRRD0004\ntype: " + type + "\ndimension: 3\nsizes: " + sizes + "\nencoding: raw\n" + fields + "\n" +
         voxels(bytes);
}

std::string with_byte(std::string text, std::size_t at) {
  text[at] = char(text[at] + 1);
  return text;
}

/// A little-endian TIFF file of one page of 8-bit grey pixels in one strip (TIFF 6.0, section 2).
std::string tiff_page(int side, char grey) {
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += char(value >> (8 * i) & 255U);
    return text;
  };
  const std::uint32_t pixels = std::uint32_t(side * side), at = 8;
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> entries{{256, side}, {257, side}, {258, 8},
                                                                     {259, 1},    {262, 1},    {273, at},
                                                                     {277, 1},    {278, side}, {279, pixels}};
  std::string file = "II*" + std::string(1, '\0') + number(at + pixels, 4) + std::string(pixels, grey);
  file += number(std::uint32_t(entries.size()), 2);
  for (const auto& [tag, value] : entries)
    file += number(tag, 2) + number(4, 2) + number(1, 4) + number(value, 4);
  return file + number(0, 4);
}

/// Two machines, n0 and n1, with files of their own.
class Machines {
 public:
  Machines() {
    for (const char* name : {"n0", "n1"}) fs::create_directory(folder_ / name);
  }
  fs::path n(int k) const { return folder_.path() / (k == 0 ? "n0" : "n1"); }
  void write(const std::string& name, const std::string& on_n0, const std::string& on_n1) const {
    write_text(n(0) / name, on_n0);
    write_text(n(1) / name, on_n1);
  }
  /// Rank 0 on n0, ranks 1 and 2 on n1.
  Ended run(const Words& on_n0, const Words& on_n1) const {
    return run_groups({{1, n(0), on_n0}, {2, n(1), on_n1}});
  }
  Ended run(const Words& arguments) const { return run(arguments, arguments); }
  bool has_picture() const { return fs::exists(n(0) / "out.png") || fs::exists(n(1) / "out.png"); }

 private:
  TemporaryFolder folder_;
};

void check_differs(const Ended& ended, const Machines& machines, const std::vector<std::string>& fragments) {
  INFO("stderr: " << ended.err);
  CHECK(ended.code == 2);
  CHECK(ended.out.empty());
  const auto errors = lines_with(ended.err, "error:");
  CHECK(errors.size() == 1);
  if (errors.size() != 1) return;
  for (const auto& fragment : fragments) CHECK_THAT(errors.front(), Catch::Matchers::Contains(fragment));
  CHECK_THAT(errors.front(), Catch::Matchers::Contains("; hint: "));
  CHECK_FALSE(machines.has_picture());
}

void check_rendered(const Ended& ended, const Machines& machines) {
  INFO("stderr: " << ended.err);
  CHECK(ended.code == 0);
  CHECK(fs::exists(machines.n(0) / "out.png"));
}

}  // namespace

TEST_CASE("ranks that see other volumes than rank 0 are refused by name and field", "[mpi]") {
  constexpr std::size_t bytes = 48 * 48 * 48;
  const std::string plain = nrrd("48 48 48", bytes);
  const std::vector<std::pair<std::string, std::string>> cases{
      {nrrd("96 96 96", 8 * bytes), "dimensions 96 x 96 x 96, rank 0 has 48 x 48 x 48"},
      {nrrd("24 24 48", 24 * 24 * 48), "dimensions 24 x 24 x 48, rank 0 has 48 x 48 x 48"},
      {with_byte(plain, plain.size() - 1), "hash of the last bytes"}};
  for (const auto& [other, fragment] : cases) {
    const Machines machines;
    machines.write("a.nrrd", plain, other);
    check_differs(machines.run(render("a.nrrd")), machines,
                  {"rank 1 sees another volume at a.nrrd: ", fragment, "(1 more rank differs)"});
  }
}

TEST_CASE(
    "a rank that sees another page of a stack is refused by the page's name, one with a copy renders it",
    "[mpi]") {
  const Machines machines;
  for (int k = 0; k < 2; ++k) {
    fs::create_directory(machines.n(k) / "stack");
    for (int page = 0; page < 6; ++page)
      write_text(machines.n(k) / "stack" / (std::string("p").append(1, char('0' + page)).append(".tif")),
                 tiff_page(16, char(20 * page + (page == 4 ? k : 0))));
  }
  check_differs(machines.run(render("stack")), machines,
                {"rank 1 sees another volume at stack: hash of the first bytes of p4.tif"});
  fs::remove(machines.n(1) / "stack" / "p5.tif");
  check_differs(machines.run(render("stack")), machines, {"dimensions 16 x 16 x 5, rank 0 has 16 x 16 x 6"});
  for (int k = 0; k < 2; ++k) {
    fs::remove(machines.n(k) / "stack" / "p5.tif");
    fs::remove(machines.n(k) / "stack" / "p4.tif");
  }
  check_rendered(machines.run(render("stack")), machines);
}

TEST_CASE("a rank without the file is refused, unless only rank 0 reads it", "[mpi]") {
  const Machines machines;
  write_text(machines.n(0) / "a.nrrd", nrrd("24 24 24", 24 * 24 * 24));
  check_differs(machines.run(render("a.nrrd")), machines, {"cannot open a.nrrd", "on rank 1"});
  REQUIRE(run_program({"synth", "ball", "-o", machines.n(0) / "packed.nrrd", "--dims", "24"}).code == 0);
  check_rendered(machines.run(render("packed.nrrd")), machines);
}

TEST_CASE("ranks that were told other things than rank 0 are refused by the option's name", "[mpi]") {
  const Machines machines;
  machines.write("a.nrrd", nrrd("24 24 24", 24 * 24 * 24), nrrd("24 24 24", 24 * 24 * 24));
  machines.write("set.toml", "zoom = 2\n", "zoom = 3\n");
  const std::vector<std::pair<std::pair<Words, Words>, std::string>> cases{
      {{{"--gps", "2"}, {"--gps", "1"}}, "--gps 1, rank 0 has 2"},
      {{{}, {"--stats", "s.json"}}, "--stats s.json, rank 0 has (none)"},
      {{{"--config", "set.toml"}, {"--config", "set.toml"}}, "--zoom 3, rank 0 has 2"}};
  for (const auto& [options, fragment] : cases)
    check_differs(machines.run(render("a.nrrd", options.first), render("a.nrrd", options.second)), machines,
                  {"rank 1 was started with other options: " + fragment});
  check_differs(machines.run(render("a.nrrd"), render("b.nrrd")), machines,
                {"VOLUME b.nrrd, rank 0 has a.nrrd"});
  check_differs(machines.run(render("a.nrrd"), {"info", "a.nrrd"}), machines,
                {"subcommand info, rank 0 has render"});
  check_differs(machines.run({"--version"}, render("a.nrrd")), machines,
                {"subcommand render, rank 0 has (none)"});
}

TEST_CASE("ranks may be told the same in other words, and one may be verbose", "[mpi]") {
  const Machines machines;
  machines.write("a.nrrd", nrrd("24 24 24", 24 * 24 * 24), nrrd("24 24 24", 24 * 24 * 24));
  write_text(machines.n(1) / "set.toml", "zoom = 2.0\nsize = 32\n");
  check_rendered(machines.run(render("a.nrrd", {"--zoom", "2", "--azimuth", "0", "--verbose"}),
                              {"render", "a.nrrd", "-o", "out.png", "--config", "set.toml"}),
                 machines);
}

TEST_CASE("what settled is what was given, in a file or by default, as one text for one value") {
  const auto value = [](const Words& words, const std::string& field) {
    const auto line = parsed(joined({"render", "a.nrrd", "-o", "007"}, words));
    CHECK(line.error.empty());
    for (const auto& fact : line.options)
      if (fact.field == field) return fact.value;
    return std::string("missing");
  };
  CHECK(value({}, "VOLUME") == "a.nrrd");
  CHECK(value({}, "--output") == "007");
  CHECK(value({}, "--zoom") == "1");
  CHECK(value({"--zoom", "1.50"}, "--zoom") == "1.5");
  CHECK(value({"--zoom=+15e-1"}, "--zoom") == "1.5");
  CHECK(value({"--error", "method", "--error-seed", "18446744073709551615"}, "--error-seed") ==
        "18446744073709551615");
  CHECK(value({}, "--gps") == "(none)");
  CHECK(value({"--gps", "auto"}, "--gps") == "auto");
  CHECK(value({}, "--annotate") == "false");
  CHECK(value({"--annotate"}, "--annotate") == "true");
  CHECK(value({}, "--light") == "-0.4 0.6 0.7");
  CHECK(value({"--light", "0", "0", "1"}, "--light") == "0 0 1");
  CHECK(value({}, "--verbose") == "missing");
  CHECK(value({}, "--config") == "missing");
}

TEST_CASE("ranks of another build are refused with both builds", "[mpi]") {
  using ringsplat::app::build_id;
  CHECK(build_id().size() < 128);

  const Machines machines;
  machines.write("a.nrrd", nrrd("24 24 24", 24 * 24 * 24), nrrd("24 24 24", 24 * 24 * 24));
  check_differs(run_groups({{1, machines.n(0), render("a.nrrd")},
                            {1, machines.n(0), render("a.nrrd")},
                            {1, machines.n(1), render("a.nrrd", {"--new-option"}), RINGSPLAT_OTHER_BUILD}}),
                machines,
                {"rank 2 runs another build: ringsplat 9.9.9 with wire format", "rank 0 runs " + build_id()});
  check_differs(run_groups({{1, machines.n(0), render("a.nrrd"), RINGSPLAT_OTHER_BUILD},
                            {2, machines.n(1), render("a.nrrd")}}),
                machines, {"rank 1 runs another build: " + build_id() + ", rank 0 runs ringsplat 9.9.9"});
}
