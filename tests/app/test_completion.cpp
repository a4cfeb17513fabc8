// The scripts with which shells complete command lines, run in the shells that are there.
#include <algorithm>
#include <iostream>
#include <sstream>

#include "app/program_runner.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// The script, in a folder with a few files.
class Completion {
 public:
  explicit Completion(const std::string& shell) : script_(folder_ / "ringsplat." + shell) {
    const Ended printed = run_program({"--completion", shell});
    REQUIRE(printed.code == 0);
    write_text(script_, printed.out);
    fs::create_directory(folder_ / "pictures");
    write_text(folder_ / "head scan.nrrd", "");
  }
  const std::string& script() const { return script_; }

  /// What bash offers for the last of these words, as it splits them.
  std::vector<std::string> bash(const std::vector<std::string>& words) const {
    std::string line = "source " + quoted(script_) + "; COMP_WORDS=(";
    for (const auto& word : words) line += quoted(word) + " ";
    line += "); COMP_CWORD=" + std::to_string(words.size() - 1) +
            "; _ringsplat; printf '%s\\n' \"${COMPREPLY[@]}\"";
    const Ended ended =
        run_command("bash --norc -c " + quoted("cd " + quoted(folder_.path().string()) + "; " + line));
    CHECK(ended.err.empty());
    std::vector<std::string> offered;
    std::istringstream lines(ended.out);
    for (std::string offer; std::getline(lines, offer);)
      if (!offer.empty()) offered.push_back(offer);
    return offered;
  }

 private:
  TemporaryFolder folder_;
  std::string script_;
};

using Words = std::vector<std::string>;

bool has(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

TEST_CASE("bash completes subcommands, options and the words of a choice") {
  const Completion completion("bash");
  CHECK(completion.bash({"ringsplat", "ren"}) == Words{"render"});
  CHECK(completion.bash({"ringsplat", ""}).size() == 7);
  CHECK(has(completion.bash({"ringsplat", "--ver"}), "--version"));
  CHECK(completion.bash({"ringsplat", "render", "--azi"}) == Words{"--azimuth"});
  CHECK(completion.bash({"ringsplat", "compare", "--azi"}).empty());
  CHECK(has(completion.bash({"ringsplat", "--verbose", "serve", "--p"}), "--port"));
  CHECK(completion.bash({"ringsplat", "render", "--quality", "d"}) == Words{"draft"});
  CHECK(completion.bash({"ringsplat", "render", "--quality", "="}) ==
        Words{"paper", "draft", "normal", "best"});
  CHECK(completion.bash({"ringsplat", "render", "--quality", "=", "n"}) == Words{"normal"});
  CHECK(completion.bash({"ringsplat", "render", "--gps", ""}) == Words{"auto"});
  CHECK(completion.bash({"ringsplat", "render", "--zoom", ""}).empty());
  CHECK(has(completion.bash({"ringsplat", "render", "--tf", "mr-s"}), "mr-skin"));
  CHECK(has(completion.bash({"ringsplat", "render", "--colours", "vi"}), "viridis"));
  CHECK(completion.bash({"ringsplat", "synth", "she"}) == Words{"shell"});
  CHECK(completion.bash({"ringsplat", "render", "--view", "b"}) == Words{"back", "bottom"});
  CHECK(completion.bash({"ringsplat", "--completion", "f"}) == Words{"fish"});
}

TEST_CASE("bash completes files and folders where they belong") {
  const Completion completion("bash");
  CHECK(completion.bash({"ringsplat", "render", "head"}) == Words{"head scan.nrrd"});
  CHECK(has(completion.bash({"ringsplat", "render", "--tf", ""}), "head scan.nrrd"));
  CHECK(has(completion.bash({"ringsplat", "render", "head.nrrd", "-o", "pic"}), "pictures"));
  CHECK(completion.bash({"ringsplat", "study", "--keep-images", ""}) == Words{"pictures"});
  CHECK(has(completion.bash({"ringsplat", "render", "--config", "h"}), "head scan.nrrd"));
}

TEST_CASE("every word that completion offers is one that the option takes") {
  const Completion completion("bash");
  const Words files = completion.bash({"ringsplat", "render", "--config", ""});
  std::size_t taken = 0;
  for (const std::string& option : completion.bash({"ringsplat", "render", "--"})) {
    if (option == "--completion" || option == "--view") continue;  // below
    for (const std::string& word : completion.bash({"ringsplat", "render", option, ""})) {
      if (has(files, word)) continue;
      const Ended ended = run_program({"render", option, word, "no such volume.nrrd", "-o", "x.png"});
      CAPTURE(option, word, ended.err);
      const bool refused = ended.err.find("cannot be '") != std::string::npos ||
                           ended.err.find("'" + word + "'") != std::string::npos;
      CHECK_FALSE(refused);
      ++taken;
    }
  }
  CHECK(taken > 60);
  for (const std::string& side : completion.bash({"ringsplat", "render", "--view", ""}))
    CHECK_THAT(run_program({"render", "--view", side, "no such volume.nrrd", "-o", "x.png"}).err,
               Contains("no such volume"));
  CHECK(completion.bash({"ringsplat", "render", "--view", ""}).size() == 6);
}

TEST_CASE("the scripts of all shells have every option, and are in their shells' language") {
  const std::string help = run_program({"render", "--help-all"}).out;
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    const Completion completion(shell);
    const std::string script = read_text(completion.script());
    for (const std::string option : {"opaque-threshold", "quality", "completion", "keep-images", "truth"})
      CHECK_THAT(script, Contains(option));
    if (run_command("sh -c " + quoted("command -v " + shell)).code != 0) {
      std::cout << "skipped: there is no " << shell << "\n";
      continue;
    }
    const Ended checked = run_command(shell + " -n " + quoted(completion.script()));
    CAPTURE(shell, checked.err);
    CHECK(checked.code == 0);
    CHECK(checked.err.empty());
  }
}

TEST_CASE("fish completes what bash does") {
  if (run_command("sh -c 'command -v fish'").code != 0) {
    std::cout << "skipped: there is no fish\n";
    return;
  }
  const Completion completion("fish");
  const auto offered = [&](const std::string& line) {
    return run_command("fish --no-config -c " +
                       quoted("source " + quoted(completion.script()) + "; complete -C " + quoted(line)))
        .out;
  };
  CHECK_THAT(offered("ringsplat ren"), Contains("render"));
  CHECK_THAT(offered("ringsplat render --azi"), Contains("--azimuth"));
  CHECK_THAT(offered("ringsplat render --quality d"), Contains("draft"));
  CHECK_THAT(offered("ringsplat synth she"), Contains("shell"));
}

TEST_CASE("a shell that nobody knows is refused") {
  const Ended refused = run_program({"--completion", "csh"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("--completion cannot be 'csh'") && Contains("bash|zsh|fish"));
}
