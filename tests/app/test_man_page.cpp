// The manual page has all that --help has, in correct roff, and the rules that it lists hold.
#include <sstream>

#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "options/contradictions.hpp"
#include "options/option_tables.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using namespace ringsplat::app;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The page's part about a subcommand, or about the program when `name` is empty.
std::string section_of(const std::string& page, const std::string& name) {
  const auto begin = page.find(name.empty() ? "\n.SH OPTIONS\n" : "\n.SH RINGSPLAT " + name + "\n");
  REQUIRE(begin != std::string::npos);
  return page.substr(begin, page.find("\n.SH ", begin + 1) - begin);
}

/// A line as roff prints it.
std::string printed(std::string line) {
  for (const auto& [escape, text] : std::vector<std::pair<std::string, std::string>>{
           {"\\fB", ""}, {"\\fI", ""}, {"\\fR", ""}, {"\\&", ""}, {"\\-", "-"}, {"\\e", "\\"}})
    for (auto at = line.find(escape); at != std::string::npos; at = line.find(escape, at + text.size()))
      line.replace(at, escape.size(), text);
  return line;
}

std::string upper(std::string word) {
  for (char& c : word) c = char(std::toupper(c));
  return word;
}

/// "--size WxH [512x512]" and the help of it, for each option and argument that --help lists.
struct Told {
  std::string usage, help;
};
std::vector<Told> told_in(const std::string& help) {
  std::vector<Told> all;
  constexpr std::size_t column = 34;
  for (const std::string& line : lines_of(help.substr(0, help.find("\nExamples:")))) {
    const bool goes_on = line.starts_with(std::string(column, ' '));
    if (goes_on && !all.empty()) all.back().help += line.substr(column);
    if (goes_on || !line.starts_with("  ")) continue;
    const auto end = std::min(line.size(), column);
    const auto last = line.size() > column && line[column - 1] == ' ' ? line.find_last_not_of(' ', end - 1)
                                                                      : line.size() - 1;
    all.push_back({line.substr(2, last - 1), last < end ? line.substr(end) : ""});
  }
  return all;
}

}  // namespace

TEST_CASE("the manual page has each subcommand and each option of --help-all, with its words") {
  const std::string page = said({"--man"});
  std::size_t options = 0;
  for (const std::string name : {"", "render", "info", "compare", "synth", "reference"}) {
    const std::string section = section_of(page, upper(name));
    const std::vector<std::string> lines = lines_of(section);
    std::string help = name.empty() ? said({"--help"}) : said({name, "--help-all"});
    help = help.substr(0, help.find("\nSubcommands:"));
    for (const Told& told : told_in(help)) {
      INFO(name << ": " << told.usage << ": " << told.help);
      // A positional argument is shown by its value's name, and "-o,--output" with a blank.
      const auto dash = told.usage.find('-');
      std::string usage = dash == 0 ? told.usage : told.usage.substr(told.usage.find(' ') + 1);
      if (const auto comma = usage.find(",--"); comma != std::string::npos) usage.insert(comma + 1, " ");
      const auto found = std::find_if(lines.begin(), lines.end(),
                                      [&](const std::string& line) { return printed(line) == usage; });
      REQUIRE(found != lines.end());
      REQUIRE(found + 1 != lines.end());
      CHECK(*(found - 1) == ".TP");
      CHECK(printed(*(found + 1)).starts_with(told.help));
      ++options;
    }
  }
  CHECK(options > 130);
}

TEST_CASE("no line of the manual page is taken for a request by mistake, and dashes can be copied") {
  const std::vector<std::string> requests{".TH", ".SH", ".SS", ".TP", ".PP",
                                          ".nf", ".fi", ".br", ".nh", ".ad"};
  for (const std::string& line : lines_of(said({"--man"}))) {
    INFO(line);
    CHECK_FALSE(line.empty());
    CHECK_FALSE(line.starts_with("'"));
    if (line.starts_with("."))
      CHECK(std::find(requests.begin(), requests.end(), line.substr(0, 3)) != requests.end());
    for (auto at = line.find('-'); at != std::string::npos; at = line.find('-', at + 1)) {
      REQUIRE(at > 0);
      CHECK(line[at - 1] == '\\');
    }
  }
}

TEST_CASE("a help that begins with a dot is text in the manual page") {
  CHECK_THAT(section_of(said({"--man"}), "SYNTH"), Contains("\n\\&.nrrd, .nhdr, .mhd or .raw"));
}

TEST_CASE("the manual page tells which options exclude and which need each other") {
  const std::string page = said({"--man"});
  const std::string render = printed(section_of(page, "RENDER")), info = printed(section_of(page, "INFO"));
  CHECK_THAT(render, Contains("kernel in voxels. Needs --engine splats or --quality paper"));
  CHECK_THAT(render, Contains("light from everywhere. Not with --mode mip, --mode attenuated"));
  CHECK_THAT(render, Contains("Pixels of the image.\n"));
  CHECK_THAT(render, Contains("the viewer climbs: 90 looks straight down, -90 up. Not with --matrix, --eye, "
                              "--view, --path, --slice.\n"));
  CHECK_THAT(info, Contains("90 looks straight down, -90 up. Not with --matrix, --eye, --view, --path, "
                            "--slice. Needs --ranks.\n"));
  CHECK_THAT(info, Contains("not picked. Needs --undersample. Needs --ranks."));
  CHECK_THAT(info, Contains("that --tf knows by name. Not with VOLUME, --gps, --ranks."));
}

TEST_CASE("groff finds nothing wrong with the manual page") {
  if (run_command("groff --version").code != 0) {
    WARN("skipped: there is no groff");
    return;
  }
  const Ended page = succeeded(run_program({"--man"}));
  const Ended shown = run_command("groff -man -Tascii -P-cbou -ww -rLL=300n", page.out);
  CHECK(shown.code == 0);
  CHECK(shown.err.empty());
  CHECK_THAT(shown.out, Contains("RINGSPLAT REFERENCE") && Contains("-o, --output FILE (required)") &&
                            Contains("mpirun -n 6 ringsplat render head.nrrd -o head.png --gps 4"));
}

TEST_CASE("--man needs no subcommand, and a file cannot ask for it") {
  CHECK(run_program({"render", "--man"}).out == run_program({"--man"}).out);
  const TemporaryFolder folder;
  write_text(folder / "man.toml", "man = true\n");
  const Ended ended = run_program({"info", "--presets", "--config", folder / "man.toml"});
  CHECK(ended.code == 2);
  CHECK(ended.out.empty());
}

TEST_CASE("every rule is about options that a subcommand has") {
  std::vector<OptionList> lists;
  for (const Subcommand& subcommand : subcommands()) subcommand.add_options(lists.emplace_back());
  for (const Rule& rule : rules())
    for (const Which& which : rule.options) {
      INFO((which.option.empty() ? "every option" : which.option) << ": " << rule.way_out);
      const auto applies = [&](const OptionList& one) {
        const auto there = [&](const Which& other) { return has(one, other); };
        const bool any = std::any_of(rule.others.begin(), rule.others.end(), there);
        return has(one, which) && (rule.others.empty() || any);
      };
      CHECK(std::any_of(lists.begin(), lists.end(), applies));
      for (const Which& other : rule.others) {
        INFO(other.option);
        CHECK(
            std::any_of(lists.begin(), lists.end(), [&](const OptionList& one) { return has(one, other); }));
      }
    }
}
