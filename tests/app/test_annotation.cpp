// What --annotate draws, where, and that it changes nothing else.
#include "app/annotation.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "images/image_io.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using app::patient_letters;
using app::round_length;
using app::visible_span;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

TransferFunction ramp(double from, double to) {
  return {.colours = {{from, glm::dvec3(0.0)}, {to, glm::dvec3(1.0)}}, .opacities = {{from, 0}, {to, 1}}};
}

ValueRange range(double low, double high) {
  ValueRange r;
  r.low = low;
  r.high = high;
  r.finite = 1;
  return r;
}

FrameSpec frame(int width, int height) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = width;
  spec.shown.height = height;
  spec.shown.camera.fit = Fit::box;
  spec.shown.transfer_function = ramp(0, 255);
  return spec;
}

Grid cube() {
  Grid grid;
  grid.dims = glm::ivec3(64);
  return grid;
}

Overlay drawn(const FrameSpec& spec, const VolumeNotes& notes = {}) {
  return app::Annotation(cube(), notes, std::nullopt).overlay(spec, range(0, 255));
}

struct Files : Workshop {
  Files() : Workshop("jack", "24x24x24", {"--size", "256", "--tf", "grey"}) {}
  StoredImage picture(const std::string& name, const Words& more) const {
    render(name, more);
    return read_image(*this / name);
  }
};

/// Pixels that differ, and how many of them the plain picture leaves transparent.
struct Changed {
  int all = 0, were_clear = 0, became_clear = 0;
};
Changed changed(const Image& plain, const Image& annotated) {
  Changed count;
  for (std::size_t at = 0; at < plain.rgba.size(); at += 4)
    if (!std::equal(&plain.rgba[at], &plain.rgba[at] + 4, &annotated.rgba[at])) {
      ++count.all;
      count.were_clear += plain.rgba[at + 3] == 0;
      count.became_clear += annotated.rgba[at + 3] < plain.rgba[at + 3];
    }
  return count;
}

}  // namespace

TEST_CASE("a round length is 1, 2 or 5 times a power of ten, and not longer than there is room") {
  CHECK(round_length(1) == 1);
  CHECK(round_length(1.99) == 1);
  CHECK(round_length(4.9) == 2);
  CHECK(round_length(9.9) == 5);
  CHECK(round_length(1000) == Approx(1000));
  CHECK(round_length(0.0034) == Approx(0.002));
  for (double most = 1e-12; most < 1e12; most *= 1.37) {
    const double length = round_length(most);
    REQUIRE(length <= most * (1 + 1e-8));
    REQUIRE(length > most / 2.51);
  }
}

TEST_CASE("a patient's direction is named by its parts, the strongest first") {
  CHECK(patient_letters({1, 0, 0}) == "L");
  CHECK(patient_letters({-1, 0, 0}) == "R");
  CHECK(patient_letters({0, 1, 0}) == "P");
  CHECK(patient_letters({0, -1, 0}) == "A");
  CHECK(patient_letters({0, 0, 1}) == "H");
  CHECK(patient_letters({0, 0, -1}) == "F");
  CHECK(patient_letters({0.8, 0.6, 0.05}) == "LP");
  CHECK(patient_letters({-0.3, -0.5, -0.81}) == "FAR");
}

TEST_CASE("the colour bar spans the values that can be seen, within the volume's") {
  const auto span = visible_span(ramp(100, 200), {0, 255});
  REQUIRE(span);
  CHECK(span->low == 100);
  CHECK(span->high == 255);
  CHECK(visible_span(ramp(100, 200), {150, 160})->low == 150);
  CHECK_FALSE(visible_span(ramp(100, 200), {0, 90}));
  TransferFunction band = ramp(0, 9);
  band.opacities = {{0, 0}, {2, 0}, {3, 1}, {4, 0}, {9, 0}};
  CHECK(visible_span(band, {0, 9})->low == 2);
  CHECK(visible_span(band, {0, 9})->high == 4);
  band.opacities = {{3, 0.5}, {4, 0}};
  CHECK(visible_span(band, {-7, 9})->low == -7);
}

TEST_CASE("the colour bars of a series keep the first volume's values, or those of --range") {
  const auto bars = [](const std::optional<DataRange>& window) {
    app::Annotation annotation(cube(), {}, std::nullopt, window);
    annotation.keep_range(range(0, 255));
    std::vector<Overlay> drawn;
    for (const double high : {255, 200, 900})
      drawn.push_back(annotation.overlay(frame(512, 512), range(0, high)));
    return drawn;
  };
  const auto same = [](const Overlay& a, const Overlay& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Patch& one, const Patch& other) {
      return one.x == other.x && one.y == other.y && one.rgba == other.rgba;
    });
  };
  const auto first = bars({}), window = bars(DataRange{50, 150});
  for (const auto& drawn : {first, window}) CHECK((same(drawn[0], drawn[1]) && same(drawn[0], drawn[2])));
  CHECK_FALSE(same(first[0], window[0]));
}

TEST_CASE("all that is drawn lies in the picture, whatever its shape, and a tiny one has nothing") {
  for (const World world : {World::lattice, World::patient, World::microscope})
    for (const auto& [width, height] : {std::pair{8, 8},
                                        {64, 64},
                                        {128, 96},
                                        {96, 300},
                                        {512, 512},
                                        {1200, 200},
                                        {200, 1200},
                                        {900, 2100}}) {
      const Overlay overlay =
          drawn(frame(width, height),
                {.world = world, .unit = "um", .quantity = "temperature in a long story (K), of all things"});
      INFO(width << 'x' << height << ' ' << overlay.size());
      for (const Patch& p : overlay) {
        CHECK((p.x >= 0 && p.y >= 0));
        CHECK((p.x + p.width <= width && p.y + p.height <= height));
        CHECK(p.rgba.size() == 4 * std::size_t(p.width) * std::size_t(p.height));
      }
      CHECK(overlay.empty() == (width == 8));
    }
}

TEST_CASE("a larger picture has larger letters, and a perspective one no scale bar", "[mpi]") {
  const auto tallest = [](const Overlay& overlay) {
    int most = 0;
    for (const Patch& p : overlay) most = std::max(most, p.height);
    return most;
  };
  CHECK(tallest(drawn(frame(2048, 2048))) > 3 * tallest(drawn(frame(512, 512))));
  FrameSpec perspective = frame(512, 512);
  perspective.shown.camera.fov = 40;
  CHECK(drawn(perspective).size() < drawn(frame(512, 512)).size());
  FrameSpec invisible = frame(512, 512);
  invisible.shown.transfer_function = ramp(300, 400);
  CHECK(drawn(invisible).size() < drawn(frame(512, 512)).size());
}

TEST_CASE("values far from zero or close together have ticks that can be told apart, and end") {
  for (const auto& [low, high] :
       {std::pair{1e9, 1e9 + 10}, {-1e-30, 1e-30}, {-1e300, 1e300}, {1.0, 1.0 + 1e-15}}) {
    FrameSpec spec = frame(512, 512);
    spec.shown.transfer_function = ramp(low - std::abs(low), high);
    const app::Annotation annotation(cube(), {}, std::nullopt);
    CHECK_FALSE(annotation.overlay(spec, range(low, high)).empty());
  }
}

TEST_CASE("values farther apart than any number have no colour bar") {
  FrameSpec wide = frame(512, 512), clear = wide;
  wide.shown.transfer_function = ramp(-1.7e308, 1.7e308);
  clear.shown.transfer_function.opacities = {{0, 0}, {1, 0}};
  const app::Annotation annotation(cube(), {}, std::nullopt);
  CHECK(annotation.overlay(wide, range(-1.7e308, 1.7e308)).size() ==
        annotation.overlay(clear, range(0, 255)).size());
}

TEST_CASE("annotations are drawn into a transparent picture, an opaque one and an .exr, and nowhere else") {
  const Files files;
  const std::vector<std::pair<std::string, Words>> cases{{"x.png", {}},
                                                         {"x.png", {"--background", "white"}},
                                                         {"x.exr", {}},
                                                         {"x.exr", {"--background", "black"}}};
  for (const auto& [file, more] : cases) {
    const Image plain = files.picture(file, more).image;
    const StoredImage annotated = files.picture(file, joined(more, {"--annotate"}));
    const Changed count = changed(plain, annotated.image);
    INFO(file << ' ' << count.all);
    CHECK(count.all > 1000);
    CHECK(count.all < 256 * 256 / 8);
    CHECK((count.were_clear > 0) == more.empty());
    CHECK(count.became_clear == 0);
    CHECK(json::parse(annotated.settings).value("annotated", false));
  }
}

TEST_CASE("what is measured of a picture is measured without its annotations", "[mpi]") {
  const Files files;
  const auto error_of = [&](const Words& more) {
    const Ended ended = files.render("x.png", joined(more, {"--error", "method", "--stats", "-"}));
    json error = json::parse(ended.out).at(0).at("error");
    error.erase("seconds");
    return error;
  };
  CHECK(error_of({"--annotate"}) == error_of({}));
}

TEST_CASE("--annotate without a font says what to install, and writes nothing", "[mpi]") {
  const Files files;
  const auto attempt = [&](const std::string& font) {
    return run_command("env " + quoted("RINGSPLAT_FONT=" + font) + " " +
                       command_of(RINGSPLAT_PROGRAM, files.words("no.png", {"--annotate"})));
  };
  const Ended missing = attempt(files / "none.ttf");
  check_refused(missing, "RINGSPLAT_FONT names");
  CHECK_THAT(missing.err, Contains("hint: name a TrueType font"));
  write_text(files / "bad.ttf", "no font at all");
  check_refused(attempt(files / "bad.ttf"), "no text can be drawn with");
  CHECK_FALSE(fs::exists(files / "no.png"));
}
