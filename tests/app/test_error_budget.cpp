// An error budget's choice, from given measurements and from the program's own.
#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "app/workshop.hpp"
#include "images/image_io.hpp"
#include "net/agree.hpp"
#include "study/calibration.hpp"
#include "study/error_budget.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"
#include "truth/certified.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;
using namespace ringsplat::app;
using app_test::Ended;
using app_test::joined;
using app_test::lines_with;
using app_test::read_text;
using app_test::run_program;
using app_test::succeeded;
using app_test::TemporaryFolder;
using app_test::Words;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

MeasuredShortcuts measured(int slabs, double seconds, double rmse_high) {
  return {{0, Sheets{.slabs = slabs}}, seconds, 0.9 * rmse_high, rmse_high};
}

/// Holds the volume and its pictures in a folder that is removed with it.
class Workshop {
 public:
  explicit Workshop(const std::string& volume = "gaussians", const std::string& dims = "24") {
    REQUIRE(run_program({"synth", volume, "--dims", dims, "-o", this->volume()}).code == 0);
  }
  std::string operator/(const std::string& name) const { return folder_ / name; }
  std::string volume() const { return folder_ / "volume.nrrd"; }

  Ended render(const Words& more, int ranks = 0) const {
    Words all{"render", volume(), "-o", folder_ / "x.exr", "--stats", stats()};
    const auto given = [&more](const std::string& word) { return std::ranges::count(more, word) > 0; };
    Words usual{"--size", "64x48", "--tf", "grey", "--shading", "none"};
    if (!given("--path")) usual = joined(usual, {"--azimuth", "20", "--elevation", "10"});
    for (std::size_t k = 0; k < usual.size(); k += 2)
      if (!given(usual[k])) all.insert(all.end(), {usual[k], usual[k + 1]});
    return run_program(joined(all, more), ranks);
  }
  std::string stats() const { return folder_ / "stats.json"; }
  json frame() const { return json::parse(read_text(stats())).at(0); }

 private:
  TemporaryFolder folder_;
};

/// Drops progress from stderr; slow machines print it there.
std::string without_progress(const std::string& err) {
  std::string rest;
  for (const std::string& line : lines_with(err, ""))
    if (!line.ends_with(" s so far") && !line.ends_with(" s left")) rest += line + "\n";
  return rest;
}

}  // namespace

TEST_CASE("a crew measures what each would alone, and all hear of what ends one", "[threads]") {
  truth::Scene scene = read_whole(*synth_source("gaussians", test::make_grid({12, 12, 12}))).scene;
  scene.frame.shown.width = scene.frame.shown.height = 24;
  scene.frame.shown.transfer_function = test::ramp(0, 255, 0.3);
  const auto measure_in = [&](TruthKind truth, const truth::Poll& poll, const Crew& crew) {
    Image image(24, 24);
    truth::Scene own = scene;
    own.poll = poll;
    const std::string said = to_text(measure(image, own, {.truth = truth, .pixels = 200}, crew));
    return said.substr(0, said.find(" in "));
  };
  for (const TruthKind truth : {TruthKind::method, TruthKind::field, TruthKind::certified}) {
    const std::string alone = measure_in(truth, {}, {});
    for (const bool fails : {false, true}) {
      const auto thrown = test::run_as_processes(3, [&](Collectives& all) {
        const bool ends = fails && all.process() == 1;
        const auto poll = [&](double) {
          if (ends) throw InputError("enough");
        };
        const auto exchange = [&](const std::function<Bytes()>& work) {
          Bytes mine;
          agree_after(all, [&] { mine = work(); });
          if (mine.size() > 80 * sizeof(truth::PixelBounds)) throw RunError("more than a share");
          return all.all_gather(mine);
        };
        const auto together = measure_in(truth, poll, {std::size_t(all.process()), 3, exchange});
        if (together != alone) throw RunError(together + " instead of " + alone);
      });
      for (const std::string& error : thrown)
        CHECK_THAT(error, Catch::Matchers::Equals(fails ? "enough (on rank 1)" : ""));
    }
  }
}

TEST_CASE("the cheapest within the budget is chosen, by the upper end of its interval") {
  const std::vector table{measured(4, 4.0, 0.01), measured(3, 3.0, 0.5), measured(2, 2.0, 1.0),
                          measured(1, 1.0, 2.0)};
  CHECK(cheapest_within(table, 10) == 3);
  CHECK(cheapest_within(table, 2.0) == 3);
  CHECK(cheapest_within(table, 1.9) == 2);  // its measured error alone, 1.8, would pass
  CHECK(cheapest_within(table, 0.99) == 1);
  CHECK(cheapest_within(table, 0.01) == 0);
  CHECK_FALSE(cheapest_within(table, 0.009).has_value());
  CHECK_FALSE(cheapest_within({}, 1).has_value());
  CHECK(most_exact(table) == 0);
}

TEST_CASE("what takes the same time up to its measurement is chosen by its error") {
  const std::vector table{measured(4, 1.02, 0.01), measured(3, 1.0, 0.5), measured(2, 1.04, 0.001)};
  CHECK(cheapest_within(table, 1) == 0);
  CHECK(most_exact(table) == 2);
  CHECK(most_exact(std::vector{measured(4, 2, 0.1), measured(3, 1, 0.1)}) == 1);
}

TEST_CASE("only what the user left open is to be chosen") {
  FrameSpec frame;
  frame.how = Sheets{.slabs = 2, .light_points = 1};
  frame.shown.opaque_threshold = 0.25;
  ErrorBudgetOptions options;
  options.fixed = {"--slabs", "--light-points", "--opaque-threshold", "--image-plane", "--undersample"};
  CHECK(candidates(frame, options) == std::vector{Shortcuts{0.25, frame.as<Sheets>()}});
  options.fixed.erase("--opaque-threshold");
  CHECK(candidates(frame, options).size() == 4);
}

TEST_CASE("a fixed image plane or level is the only one") {
  FrameSpec frame;
  frame.how = Sheets{.image_plane = ImagePlane::slices, .plane_samples = 2};
  ErrorBudgetOptions options;
  options.fixed.insert("--image-plane");
  for (const Shortcuts& s : candidates(frame, options)) {
    CHECK(s.how.image_plane == ImagePlane::slices);
    CHECK(s.how.plane_samples == 2);
  }
  options.fixed.insert("--undersample");
  frame.shown.reduction.factor = 2;
  for (const Shortcuts& s : candidates(frame, options)) {
    CHECK(s.undersample == 2);
    FrameSpec other;
    other.how = Sheets{};
    CHECK(with(other, s).shown.reduction.factor == 2);
  }
}

TEST_CASE("sheets are chosen among by slabs, light points and planes") {
  FrameSpec frame;
  frame.how = Sheets{};
  ErrorBudgetOptions options;
  const auto all = candidates(frame, options);
  CHECK(all.front() == Shortcuts{0, Sheets{}});
  CHECK(all.size() == 13);
  CHECK(all.back() ==
        Shortcuts{
            1.0 / 128,
            Sheets{.image_plane = ImagePlane::slices, .plane_samples = 1, .slabs = 1, .light_points = 1}, 4});
  const auto most = [](const std::vector<Shortcuts>& some) {
    int slabs = 0;
    for (const Shortcuts& s : some) slabs = std::max(slabs, s.how.slabs);
    return slabs;
  };
  CHECK(most(all) == 3);
  options.to_field = true;
  CHECK(most(candidates(frame, options)) == 4);  // nearer to the field, though not to the method asked for
  options.fixed.insert("--slabs");
  CHECK(most(candidates(frame, options)) == 3);
  options.fixed.insert({"--light-points", "--image-plane", "--undersample", "--opaque-threshold"});
  CHECK(candidates(frame, options).size() == 1);
  // Light points mean nothing where nothing is lit.
  ErrorBudgetOptions unlit;
  frame.shown.shading = Shading::none;
  for (const Shortcuts& s : candidates(frame, unlit)) CHECK(s.how.light_points == 2);
}

TEST_CASE("a setting's text is the options that make it, and each setting has its own") {
  CHECK(to_text({0.25, {.image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 3}}) ==
        "--opaque-threshold 0.25 --slabs 3 --light-points 2 --image-plane slices --samples 1.5");
  CHECK(to_text({0, {.light_points = 1}, 2}) ==
        "--opaque-threshold 0 --slabs 3 --light-points 1 --undersample 2");
  FrameSpec frame;
  frame.how = Sheets{};
  frame.shown.transfer_function = test::constant_opacity(0.5);
  const auto all = candidates(frame, {});
  std::set<std::string> texts;
  for (const Shortcuts& s : all) {
    texts.insert(to_text(s));
    CHECK_NOTHROW(check(with(frame, s)));
  }
  CHECK(texts.size() == all.size());
}

TEST_CASE("a budget is kept, and a smaller one is never met by a larger error", "[mpi]") {
  const Workshop w;
  Ended ended;
  for (const double budget : {5.0, 0.6, 0.3, 0.1, 0.06}) {
    ended = w.render({"--max-error", std::to_string(budget)});
    INFO(budget << ": " << ended.out << ended.err);
    REQUIRE(ended.code == 0);
    CHECK(without_progress(ended.err) == "");
    const json error = w.frame().at("error");
    CHECK(error.at("truth") == "method");
    CHECK(error.at("rmse").get<double>() <= budget);
    CHECK(error.at("rmse").get<double>() > 0);
  }
  // The tightest leaves no coarser plane.
  CHECK(w.frame().at("settings").at("image_plane") == "screen");
  CHECK(w.frame().at("settings").at("undersample") == 1);
}

TEST_CASE("a budget against the field is another one than against the method", "[mpi]") {
  const Workshop w;
  const Words method{"--max-error", "2", "--image-plane", "screen", "--opaque-threshold", "0"};
  succeeded(w.render(method));
  CHECK(w.frame().at("error").at("truth") == "method");
  Words field = joined(method, {"--error", "field"});
  succeeded(w.render(field));
  CHECK(w.frame().at("error").at("truth") == "field");
  CHECK(w.frame().at("error").at("rmse").get<double>() <= 2);
}

TEST_CASE("a budget that cannot be kept ends the run before a picture, with one that can be", "[mpi]") {
  const Workshop w;
  for (const int ranks : {0, 3}) {
    const Ended ended = w.render({"--max-error", "1e-9"}, ranks);
    CHECK(ended.code == 2);
    REQUIRE(lines_with(ended.err, "error:").size() == 1);
    CHECK_THAT(ended.err, Catch::Matchers::Contains("cannot keep --max-error 1e-09") &&
                              Catch::Matchers::Contains("hint:"));
    CHECK_FALSE(fs::exists(w / "x.exr"));
  }
  // With the slices' plane fixed, that is to blame.
  const Ended fixed = w.render({"--max-error", "0.0001", "--image-plane", "slices"});
  CHECK(fixed.code == 2);
  CHECK_THAT(fixed.err, Catch::Matchers::Contains("leave out --image-plane"));
  // What the hint allows is kept.
  const std::string allow = "allow --max-error ";
  REQUIRE_THAT(fixed.err, Catch::Matchers::Contains(allow));
  std::string budget;
  std::istringstream(fixed.err.substr(fixed.err.find(allow) + allow.size())) >> budget;
  INFO(fixed.err);
  CHECK(w.render({"--max-error", budget, "--image-plane", "slices"}).code == 0);
}

TEST_CASE("what the user gives is kept, and the error is against what the user asked for", "[mpi]") {
  const Workshop w;
  REQUIRE(w.render({"--max-error", "5", "--slabs", "1", "--opaque-threshold", "0", "--image-plane", "screen",
                    "--undersample", "1"})
              .code == 0);
  const json settings = w.frame().at("settings");
  CHECK(settings.at("slabs") == 1);
  CHECK(settings.at("opaque_threshold") == 0);
  // The truth has as many slabs.
  CHECK(w.frame().at("error").at("rmse").get<double>() < 0.5);
}

TEST_CASE("ranks agree on a budget's choice, for all pictures", "[mpi]") {
  const Workshop w("shell");
  succeeded(w.render(
      {"--max-error", "1", "--tf", "mr-surface", "--shading", "phong", "--orbit", "3", "--gps", "2"}, 3));
  const json frames = json::parse(read_text(w.stats()));
  REQUIRE(frames.size() == 3);
  CHECK(frames[0].at("layout").at("ranks") == 3);
  for (const json& frame : frames) {
    CHECK(frame.at("settings").at("slabs") == frames[0].at("settings").at("slabs"));
    CHECK(frame.at("error").at("rmse").get<double>() <= 1);
  }
}

TEST_CASE("a calibration measures a small volume's views whole, whatever the seed", "[mpi]") {
  const Workshop w("shell");
  std::vector<std::string> chosen;
  for (const char* seed : {"1", "2"}) {
    const Ended ended = succeeded(w.render(
        {"--max-error", "9", "--error", "field", "--zoom", "0.2", "--error-pixels", "400", "--error-seed",
         seed, "--image-plane", "screen", "--undersample", "1", "--slabs", "1", "--opaque-threshold", "0"}));
    const auto lines = lines_with(ended.out, "95 %: up to");
    REQUIRE(lines.size() == 1);
    chosen.push_back(lines[0].substr(0, lines[0].find(", ")));
  }
  CHECK(chosen[0] == chosen[1]);
  std::smatch numbers;
  const std::regex equal(R"(: ([0-9.e-]+)/255 rms \(95 %: up to ([0-9.e-]+)\))");
  REQUIRE(std::regex_search(chosen[0], numbers, equal));
  CHECK(std::stod(numbers[1]) > 0);
  CHECK(numbers[1] == numbers[2]);
}

/// The last is larger than those that are measured, the straightest and the most oblique.
std::string path_in(const Workshop& w) {
  app_test::write_text(w / "path.csv", "0 0 0 0.4\n20 0 0 0.4\n10 0 0 1.5\n");
  return w / "path.csv";
}

TEST_CASE("a picture over the budget is drawn again, more exactly", "[mpi]") {
  // Every second voxel is drawn in a quarter of the time, also beside other work, and errs too much from
  // near.
  const Workshop w("marschner-lobb", "192");
  for (const int ranks : {0, 2}) {
    const Ended ended =
        succeeded(w.render({"--path", path_in(w), "--max-error", "3", "--size", "320x240", "--error-pixels",
                            "1000", "--image-plane", "slices", "--slabs", "1", "--opaque-threshold", "0"},
                           ranks));
    INFO(ended.out);
    CHECK(without_progress(ended.err) == "");
    CHECK(lines_with(ended.out, "drawn again with").size() == 1);
    const json frames = json::parse(read_text(w.stats()));
    REQUIRE(frames.size() == 3);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(frames[k].at("frame") == k);
      CHECK(frames[k].at("error").at("rmse").get<double>() <= 3);
      CHECK(fs::exists(w / ("x-000" + std::to_string(k) + ".exr")));
    }
    CHECK(frames[0].at("settings").at("undersample") == 2);
    CHECK(frames[2].at("settings").at("undersample") == 1);
  }
}

TEST_CASE("a picture that breaks the budget however it is drawn is named, and the run ends with 1", "[mpi]") {
  const Workshop w;
  for (const int ranks : {0, 2}) {
    const Ended ended = w.render({"--path", path_in(w), "--max-error", "3", "--error", "field",
                                  "--undersample", "4", "--slabs", "1", "--image-plane", "slices"},
                                 ranks);
    INFO(ended.out << ended.err);
    CHECK(ended.code == 1);
    const auto warnings = lines_with(ended.err, "warning:");
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front(), Catch::Matchers::Contains("x-0002.exr breaks --max-error 3") &&
                                     Catch::Matchers::Contains("hint: leave out --undersample"));
    const json frames = json::parse(read_text(w.stats()));
    CHECK(frames.at(2).at("error").at("rmse").get<double>() > 3);
    CHECK(frames.at(1).at("error").at("rmse").get<double>() <= 3);
  }
}

TEST_CASE("a budget is kept at views between the axes", "[mpi]") {
  const Workshop w("shell");
  for (const char* budget : {"1.2", "2", "4"}) {
    const Ended ended = succeeded(w.render({"--max-error", budget, "--error", "field", "--azimuth", "43",
                                            "--elevation", "35", "--tf", "mr-surface", "--shading", "phong"},
                                           2));
    CHECK(lines_with(ended.out, "drawn again").empty());
    CHECK(w.frame().at("error").at("rmse").get<double>() <= std::stod(budget));
  }
}

TEST_CASE("what errs more than its setting should is drawn with one that is as much better") {
  const auto slabs = [](const std::optional<Shortcuts>& s) { return s->how.slabs; };
  const std::vector table{measured(4, 4.0, 0.01), measured(3, 3.0, 0.5), measured(2, 2.0, 1.0),
                          measured(1, 1.0, 2.0)};
  CHECK(slabs(more_exact(table, table[3].shortcuts, 3, 2, false)) == 2);  // 1.0 becomes 1.5
  CHECK(slabs(more_exact(table, table[3].shortcuts, 6, 2, false)) == 3);  // 1.0 becomes 3, 0.5 1.5
  CHECK(slabs(more_exact(table, table[3].shortcuts, 3, 2, true)) == 4);
  CHECK(slabs(more_exact(table, table[3].shortcuts, 2000, 2, false)) == 4);
  CHECK_FALSE(more_exact(table, table[0].shortcuts, 3, 2, false).has_value());
  CHECK_FALSE(more_exact(table, {0, {}, 2}, 3, 2, false).has_value());
}
