// Options under the names that they had before.
#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;
using ringsplat::app::CommandLine;

namespace {

CommandLine parse(const Words& words) { return parsed(joined({"render", "a.nrrd", "-o", "a.png"}, words)); }

int bundle_of(const CommandLine& line) {
  INFO(line.error);
  return std::get<ringsplat::app::RenderOptions>(line.command).run.bundle.value_or(0);
}

}  // namespace

TEST_CASE("--slab is --bundle, which a note says once") {
  const TemporaryFolder folder;
  write_text(folder / "slab.toml", "slab = 3\n");
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"--slab", "3"}, {"--slab=3"}, {"--config", folder / "slab.toml"}}) {
    const CommandLine line = parse(words);
    CHECK(bundle_of(line) == 3);
    REQUIRE(line.notes.size() == 1);
    CHECK_THAT(line.notes.front(), Contains("--slab is now called --bundle"));
  }
  const CommandLine both = parse({"--config", folder / "slab.toml", "--slab", "4"});
  CHECK(bundle_of(both) == 4);
  CHECK(both.notes.size() == 1);
  CHECK(parse({"--bundle", "3", "--slabs", "2"}).notes.empty());
}

TEST_CASE("the program says a former name on stderr and shows it in no help") {
  const Ended ended = run_program({"info", "--presets", "--slab", "2"});
  CHECK(ended.code == 0);
  CHECK_THAT(ended.err, Contains("--slab is now called --bundle"));
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"render", "--help-all"}, {"--man"}, {"--complete", "render", "--"}}) {
    std::string shown = run_program(words).out;
    std::erase(shown, '\\');  // the manual page has one before each dash
    CHECK_THAT(shown, Contains("--bundle"));
    for (const char* former : {"--slab ", "--slabfR", "--slab\t", "--slab\n"})
      CHECK_THAT(shown, !Contains(former));
  }
}
