// How command lines may go on: as the program says, and as the shells that are there get it by their scripts.
#include <algorithm>
#include <iostream>
#include <sstream>

#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// The script, in a folder with a few files.
class Completion {
 public:
  explicit Completion(const std::string& shell) : script_(folder_ / "ringsplat." + shell) {
    const Ended printed = succeeded(run_program({"--completion", shell}));
    write_text(script_, printed.out);
    fs::create_directory(folder_ / "pictures");
    write_text(folder_ / "head scan.nrrd", "");
  }
  const std::string& script() const { return script_; }

  /// What bash offers for the last of these words, as it splits them.
  Words bash(const Words& words) const {
    const std::string line = "COMP_WORDS=(" + command_of(RINGSPLAT_PROGRAM, words) +
                             "); COMP_CWORD=" + std::to_string(words.size()) +
                             "; _ringsplat; printf '%s\\n' \"${COMPREPLY[@]}\"";
    return offered("bash --norc -c ", line);
  }

  /// What zsh offers: without a terminal its own functions only say what they are asked for.
  Words zsh(const Words& words) const {
    const std::string line =
        "words=(" + command_of(RINGSPLAT_PROGRAM, words) + "); CURRENT=" + std::to_string(words.size() + 1) +
        "; _describe() { print -l -- \"${(@P)2}\" }; _files() { print _files $@ }; compset() { }; _ringsplat";
    return offered("zsh -f -c ", line, "compdef() { }; ");
  }

  std::vector<std::string> fish(const std::string& line) const {
    return offered("fish --no-config -c ", "complete -C " + quoted(quoted(RINGSPLAT_PROGRAM) + " " + line));
  }

 private:
  std::vector<std::string> offered(const std::string& shell, const std::string& line,
                                   const std::string& before = {}) const {
    const Ended ended = run_command(shell + quoted("cd " + quoted(folder_.path().string()) + "; " + before +
                                                   "source " + quoted(script_) + "; " + line));
    CHECK(ended.err.empty());
    std::vector<std::string> all;
    std::istringstream lines(ended.out);
    for (std::string offer; std::getline(lines, offer);)
      if (!offer.empty()) all.push_back(offer);
    return all;
  }

  TemporaryFolder folder_;
  std::string script_;
};

bool has(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

TEST_CASE("bash completes subcommands, options and the words of a choice") {
  const Completion completion("bash");
  CHECK(completion.bash({"ren"}) == Words{"render"});
  CHECK(completion.bash({""}).size() == 7);
  CHECK(has(completion.bash({"--ver"}), "--version"));
  CHECK(completion.bash({"render", "--azi"}) == Words{"--azimuth"});
  CHECK(completion.bash({"compare", "--azi"}).empty());
  CHECK(has(completion.bash({"--verbose", "serve", "--p"}), "--port"));
  CHECK(completion.bash({"render", "--quality", "d"}) == Words{"draft"});
  CHECK(completion.bash({"render", "--quality", "="}) == Words{"paper", "draft", "normal", "best"});
  CHECK(completion.bash({"render", "--quality", "=", "n"}) == Words{"normal"});
  CHECK(completion.bash({"render", "--gps", ""}) == Words{"auto"});
  CHECK(completion.bash({"render", "--zoom", ""}).empty());
  CHECK(has(completion.bash({"render", "--tf", "mr-s"}), "mr-skin"));
  CHECK(has(completion.bash({"render", "--colours", "vi"}), "viridis"));
  CHECK(completion.bash({"synth", "she"}) == Words{"shell"});
  CHECK(completion.bash({"render", "--view", "b"}) == Words{"back", "bottom"});
  CHECK(completion.bash({"--completion", "f"}) == Words{"fish"});
}

TEST_CASE("bash completes files where they belong") {
  const Completion completion("bash");
  CHECK(completion.bash({"render", "head"}) == Words{"head scan.nrrd"});
  CHECK(has(completion.bash({"render", "--tf", ""}), "head scan.nrrd"));
  CHECK(has(completion.bash({"render", "head.nrrd", "-o", "pic"}), "pictures"));
  CHECK(has(completion.bash({"render", "--config", "h"}), "head scan.nrrd"));
}

TEST_CASE("every word that completion offers is one that the option takes") {
  const auto offers = [](const Words& words) {
    Words all = lines_with(succeeded(run_program(joined({"--complete", "render"}, words))).out, "");
    for (std::string& line : all) line = line.substr(0, line.find('\t'));
    std::erase(all, ":files");
    return all;
  };
  std::size_t taken = 0;
  for (const std::string& option : offers({"--"})) {
    if (option == "--completion" || option == "--view") continue;  // below
    for (const std::string& word : offers({option, ""})) {
      const Ended ended = run_program({"render", option, word, "no such volume.nrrd", "-o", "x.png"});
      CAPTURE(option, word, ended.err);
      const bool refused = ended.err.find("cannot be '") != std::string::npos ||
                           ended.err.find("'" + word + "'") != std::string::npos;
      CHECK_FALSE(refused);
      ++taken;
    }
  }
  CHECK(taken > 60);
  for (const std::string& side : offers({"--view", ""}))
    CHECK_THAT(run_program({"render", "--view", side, "no such volume.nrrd", "-o", "x.png"}).err,
               Contains("no such volume"));
  CHECK(offers({"--view", ""}).size() == 6);
}

TEST_CASE("the program says how a line may go on, with what words mean") {
  const auto offers = [](std::vector<std::string> words) {
    words.insert(words.begin(), "--complete");
    const Ended ended = run_program(words);
    CHECK(ended.code == 0);
    return ended.out;
  };
  CHECK(offers({"syn"}) == "synth\tWrite an analytic test volume\n");
  CHECK(offers({"compare", "--diff-s"}) == "--diff-scale\tMultiply the written difference\n");
  CHECK(offers({"render", "--quality=d"}) == "--quality=draft\n");
  CHECK(offers({"render", "--light", "1", "-0.5", ""}).empty());
  CHECK(offers({"render", "--light", "1", "-0.5", "2", ""}) == ":files\n");
  CHECK(offers({"render", "--log", ""}) == ":files\n");
  CHECK_THAT(offers({"render", "--tf", "mr-so"}), Contains("mr-soft\t") && Contains("\n:files\n"));
  CHECK(offers({}) == offers({""}));
  CHECK(offers({"nonsense", "--frobnicate", "x", "--"}) == offers({"--"}));
}

TEST_CASE("the scripts are in their shells' language") {
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    if (run_command("sh -c " + quoted("command -v " + shell)).code != 0) {
      std::cout << "skipped: there is no " << shell << "\n";
      continue;
    }
    const Completion completion(shell);
    const Ended checked = run_command(shell + " -n " + quoted(completion.script()));
    CAPTURE(shell, checked.err);
    CHECK(checked.code == 0);
    CHECK(checked.err.empty());
  }
}

TEST_CASE("zsh completes what bash does") {
  if (run_command("sh -c 'command -v zsh'").code != 0) {
    std::cout << "skipped: there is no zsh\n";
    return;
  }
  const Completion completion("zsh");
  CHECK(completion.zsh({"syn"}) == Words{"synth:Write an analytic test volume"});
  CHECK(completion.zsh({"render", "--azi"}) ==
        Words{"--azimuth:Degrees the viewer walks around to the right: 0 is in front"});
  CHECK(completion.zsh({"render", "--quality=d"}) == Words{"--quality=draft"});
  CHECK(completion.zsh({"render", "--gps", ""}) == Words{"auto"});
  CHECK(completion.zsh({"render", ""}) == Words{"_files"});
  CHECK(completion.zsh({"render", "--zoom", ""}).empty());
}

TEST_CASE("fish completes what bash does") {
  if (run_command("sh -c 'command -v fish'").code != 0) {
    std::cout << "skipped: there is no fish\n";
    return;
  }
  const Completion completion("fish");
  CHECK(completion.fish("syn") == Words{"synth\tWrite an analytic test volume"});
  CHECK(completion.fish("render --azi") ==
        Words{"--azimuth\tDegrees the viewer walks around to the right: 0 is in front"});
  CHECK(completion.fish("render --quality d") == Words{"draft"});
  CHECK(completion.fish("render --quality=d") == Words{"--quality=draft"});
  CHECK(completion.fish("render --zoom ").empty());
  CHECK(has(completion.fish("render --config=he"), "--config=head scan.nrrd"));
  CHECK(has(completion.fish("render he"), "head scan.nrrd"));
}

TEST_CASE("a shell that nobody knows is refused") {
  const Ended refused = run_program({"--completion", "csh"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("--completion cannot be 'csh'") && Contains("bash|zsh|fish"));
}
