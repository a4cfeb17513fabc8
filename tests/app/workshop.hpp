#pragma once
// What tests of the program share: a volume with its pictures, and runs that must succeed or be refused.
#include "app/program_runner.hpp"
#include "support/catch.hpp"

namespace ringsplat::app_test {

using Words = std::vector<std::string>;

inline Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Requires that a program has done what it was asked for, and says what it has written to stderr if not.
inline Ended succeeded(Ended ended) {
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  return ended;
}

/// Checks that a program has refused what it was asked for, and what it says of it.
inline void check_refused(const Ended& ended, const std::string& said) {
  INFO(ended.err);
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Catch::Matchers::Contains(said));
}

/// True when two pictures have the same bits.
inline bool same_pictures(const std::string& a, const std::string& b) {
  return run_program({"compare", a, b, "--fail-above", "0"}).code == 0;
}

/// A folder with a volume that `synth` makes, and the options that all pictures of it have.
class Workshop {
 public:
  Workshop(const std::string& shape, const std::string& dims, Words usual = {}, const Words& more = {})
      : usual_(std::move(usual)) {
    succeeded(run_program(joined({"synth", shape, "-o", volume(), "--dims", dims}, more)));
  }
  const fs::path& path() const { return folder_.path(); }
  std::string operator/(const std::string& name) const { return folder_ / name; }
  std::string volume() const { return folder_ / "volume.nrrd"; }
  /// What draws a picture of the folder.
  Words words(const std::string& picture, const Words& more = {}) const {
    return joined(joined({"render", volume(), "-o", folder_ / picture}, usual_), more);
  }
  Ended run(const std::string& picture, const Words& more = {}, int ranks = 0) const {
    return run_program(words(picture, more), ranks);
  }
  /// Draws a picture, which must succeed.
  Ended render(const std::string& picture, const Words& more = {}, int ranks = 0) const {
    return succeeded(run(picture, more, ranks));
  }

 private:
  TemporaryFolder folder_;
  Words usual_;
};

}  // namespace ringsplat::app_test
