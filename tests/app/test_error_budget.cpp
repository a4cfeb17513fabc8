// An error budget's choice, from given measurements and from the program's own.
#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
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

/// Holds the volume and the cache of its runs in a folder that is removed with it.
class Workshop {
 public:
  explicit Workshop(const std::string& volume = "gaussians") {
    setenv("XDG_CACHE_HOME", cache().c_str(), 1);
    REQUIRE(run_program({"synth", volume, "--dims", "24x24x24", "-o", this->volume()}).code == 0);
  }
  ~Workshop() { unsetenv("XDG_CACHE_HOME"); }
  std::string operator/(const std::string& name) const { return folder_ / name; }
  std::string volume() const { return folder_ / "volume.nrrd"; }
  std::string cache() const { return folder_ / "cache"; }
  fs::path calibration() const { return *fs::directory_iterator(cache() + "/ringsplat"); }
  std::size_t calibrations() const { return app_test::files_in(cache() + "/ringsplat"); }

  Ended render(const Words& more, int ranks = 0) const {
    Words all{"render", volume(), "-o", folder_ / "x.exr", "--stats", stats()};
    const Words usual{"--size", "64x48",     "--tf", "grey",        "--shading",
                      "none",   "--azimuth", "20",   "--elevation", "10"};
    for (std::size_t k = 0; k < usual.size(); k += 2)
      if (std::find(more.begin(), more.end(), usual[k]) == more.end())
        all.insert(all.end(), {usual[k], usual[k + 1]});
    return run_program(joined(all, more), ranks);
  }
  std::string stats() const { return folder_ / "stats.json"; }
  /// Writes into the stored calibration that the last setting with these words takes no time and errs so.
  void falsify(const std::string& words, double rmse) const {
    json stored = json::parse(read_text(calibration()));
    json& last = stored["measured"].back();
    REQUIRE_THAT(last.at("setting").get<std::string>(), Catch::Matchers::Contains(words));
    last["seconds"] = 1e-9;
    last["rmse"] = last["rmse_high"] = rmse;
    app_test::write_text(calibration(), stored.dump());
  }
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

bool calibrated(const Ended& ended) { return !lines_with(ended.out, "calibrated").empty(); }

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
  // Four kinds of slabs on the screen, three in each of three planes, and two levels in the coarsest.
  CHECK(all.size() == 4 * (4 + 3 * 3 + 2));
  CHECK(all.back() ==
        Shortcuts{
            1.0 / 32,
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
  CHECK(texts.size() == all.size());  // a stored calibration tells them apart
}

TEST_CASE("a calibration is read back for its own key and settings only") {
  const TemporaryFolder folder;
  const fs::path path = folder / "new/calibration.json";
  const KeptFile file{calibration_kind, R"({"a": 1})", path}, other{calibration_kind, R"({"a": 2})", path};
  const std::vector table{measured(4, 4.0, 0.01), measured(3, 3.0, 0.5)};
  const std::vector settings{table[0].shortcuts, table[1].shortcuts};
  CHECK_FALSE(read_calibration(file, settings).has_value());
  write_calibration(file, table);
  CHECK(app_test::files_in(path.parent_path()) == 1);
  const auto back = read_calibration(file, settings);
  REQUIRE(back.has_value());
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK((*back)[k].shortcuts == table[k].shortcuts);
    CHECK((*back)[k].seconds == table[k].seconds);
    CHECK((*back)[k].rmse == table[k].rmse);
    CHECK((*back)[k].rmse_high == table[k].rmse_high);
  }
  CHECK_FALSE(read_calibration(other, settings).has_value());
  CHECK_FALSE(read_calibration(file, {settings[1], settings[0]}).has_value());
  CHECK_FALSE(read_calibration(file, {settings[0]}).has_value());
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
    CHECK(calibrated(ended) == (budget == 5.0));  // one calibration serves every budget
  }
  CHECK(w.calibrations() == 1);
  // The tightest leaves no coarser plane.
  CHECK(w.frame().at("settings").at("image_plane") == "screen");
  CHECK(w.frame().at("settings").at("undersample") == 1);
}

TEST_CASE("a budget against the field is another one than against the method", "[mpi]") {
  const Workshop w;
  const Words method{"--max-error", "2", "--image-plane", "screen", "--opaque-threshold", "0"};
  REQUIRE(calibrated(w.render(method)));
  CHECK(w.frame().at("error").at("truth") == "method");
  Words field = joined(method, {"--error", "field"});
  const Ended ended = succeeded(w.render(field));
  CHECK(calibrated(ended));
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

TEST_CASE("ranks agree on a budget's choice and keep it from run to run", "[mpi]") {
  const Workshop w("shell");
  const auto run = [&](const char* gps, int ranks) {
    return w.render(
        {"--max-error", "1", "--tf", "mr-surface", "--shading", "phong", "--orbit", "3", "--gps", gps},
        ranks);
  };
  const Ended first = succeeded(run("2", 3));
  CHECK(calibrated(first));
  const json frames = json::parse(read_text(w.stats()));
  REQUIRE(frames.size() == 3);
  CHECK(frames[0].at("layout").at("ranks") == 3);
  for (const json& frame : frames) {
    CHECK(frame.at("settings").at("slabs") == frames[0].at("settings").at("slabs"));
    CHECK(frame.at("error").at("rmse").get<double>() <= 1);
  }
  const std::string picture = read_text(w / "x-0001.exr");
  const Ended second = succeeded(run("2", 3));
  CHECK_FALSE(calibrated(second));
  CHECK((read_text(w / "x-0001.exr") == picture));
  // Other ranks have other costs.
  CHECK(calibrated(run("1", 2)));
  CHECK(w.calibrations() == 2);
}

TEST_CASE("another volume under the same name, or other colours, are calibrated anew", "[mpi]") {
  const Workshop w;
  REQUIRE(calibrated(w.render({"--max-error", "1"})));
  CHECK(calibrated(w.render({"--max-error", "1", "--tf", "mr-soft"})));
  CHECK_FALSE(calibrated(w.render({"--max-error", "1"})));
  REQUIRE(run_program({"synth", "ball", "--dims", "24x24x24", "-o", w.volume()}).code == 0);
  CHECK(calibrated(w.render({"--max-error", "1"})));
}

TEST_CASE("a calibration that is damaged is made again, with a warning", "[mpi]") {
  const Workshop w;
  REQUIRE(w.render({"--max-error", "1"}).code == 0);
  const fs::path file = w.calibration();
  const std::string good = read_text(file);
  json wrong = json::parse(good);
  wrong["measured"][3]["seconds"] = -1;
  for (const std::string& damaged :
       {good.substr(0, good.size() / 2), std::string(), std::string("[]"), wrong.dump()}) {
    app_test::write_text(file, damaged);
    const Ended ended = w.render({"--max-error", "1"});
    INFO(ended.err);
    CHECK(ended.code == 0);
    CHECK(calibrated(ended));
    REQUIRE(lines_with(ended.err, "warning:").size() == 1);
    CHECK_THAT(ended.err, Catch::Matchers::Contains(file.string()));
    CHECK(w.calibrations() == 1);
  }
  CHECK_FALSE(calibrated(w.render({"--max-error", "1"})));
}

TEST_CASE("a calibration measures a small volume's views whole, whatever the seed", "[mpi]") {
  const Workshop w("shell");
  std::vector<json> measured;
  for (const char* seed : {"1", "2"}) {
    succeeded(w.render({"--max-error", "5", "--zoom", "0.2", "--tf", "mr-surface", "--error-pixels", "400",
                        "--error-seed", seed, "--image-plane", "screen", "--undersample", "1"}));
    measured.push_back(json::parse(read_text(w.calibration())).at("measured"));
    fs::remove(w.calibration());
  }
  REQUIRE(measured[0].size() == measured[1].size());
  for (std::size_t k = 0; k < measured[0].size(); ++k) {
    CHECK(measured[0][k].at("rmse").get<double>() > 0);
    CHECK(measured[0][k].at("rmse").get<double>() == Approx(measured[1][k].at("rmse").get<double>()));
    CHECK(measured[0][k].at("rmse_high").get<double>() == Approx(measured[0][k].at("rmse").get<double>()));
  }
}

TEST_CASE("a picture over the budget is drawn again, more exactly", "[mpi]") {
  const Workshop w;
  const std::vector<std::string> asked{"--orbit", "2", "--max-error", "0.06"};
  for (const int ranks : {0, 2}) {
    REQUIRE(w.render(asked, ranks).code == 0);
    w.falsify("--undersample 4", 0.06);  // the cheapest, and just within the budget
    const Ended ended = w.render(asked, ranks);
    INFO(ended.out << ended.err);
    CHECK(ended.code == 0);
    CHECK(without_progress(ended.err) == "");
    CHECK(lines_with(ended.out, "drawn again with").size() == 2);
    const json frames = json::parse(read_text(w.stats()));
    REQUIRE(frames.size() == 2);
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(frames[k].at("frame") == k);
      CHECK(frames[k].at("settings").at("undersample") == 1);
      CHECK(frames[k].at("error").at("rmse").get<double>() <= 0.06);
      CHECK(fs::exists(w / ("x-000" + std::to_string(k) + ".exr")));
    }
    fs::remove(w.calibration());
  }
}

TEST_CASE("a picture that breaks the budget however it is drawn is named, and the run ends with 1", "[mpi]") {
  const Workshop w;
  for (const int ranks : {0, 2}) {
    REQUIRE(w.render({"--max-error", "1"}, ranks).code == 0);
    w.falsify("--undersample 4", 1e-9);  // more exact than all others
    const Ended ended = w.render({"--max-error", "0.01"}, ranks);
    INFO(ended.out << ended.err);
    CHECK(ended.code == 1);
    const auto warnings = lines_with(ended.err, "warning:");
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front(), Catch::Matchers::Contains("x.exr breaks --max-error 0.01") &&
                                     Catch::Matchers::Contains("hint: allow --max-error"));
    CHECK(w.frame().at("error").at("rmse").get<double>() > 0.01);
    CHECK(w.frame().at("settings").at("undersample") == 4);
    fs::remove(w.calibration());
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
  CHECK_FALSE(more_exact(table, {.undersample = 2}, 3, 2, false).has_value());
}

TEST_CASE("a cache that cannot be written costs no more than the next calibration", "[mpi]") {
  const Workshop w;
  app_test::write_text(w.cache(), "in the way");
  const Ended ended = w.render({"--max-error", "1"});
  CHECK(ended.code == 0);
  CHECK(lines_with(ended.err, "warning:").size() == 1);
  CHECK(calibrated(w.render({"--max-error", "1"})));
}
