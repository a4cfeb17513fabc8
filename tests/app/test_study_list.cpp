#include "ringsplat/base/error.hpp"
#include "study/study_list.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

const std::string least = "views = [\"20 10\"]\n[scene.a]\nsynth = \"ball\"\n[setting.b]\nradius = 2.0\n";

const KernelOptions& kernel_of(const StudyList::Setting& setting) {
  return std::get<Splats>(setting.options.frame.how).kernel;
}

}  // namespace

TEST_CASE("the default study list can be run") {
  const StudyList list = parse_study_list(default_study_list, "the default list");
  CHECK(list.scenes.size() == 3);
  CHECK(list.settings.size() == 22);
  CHECK(list.views.size() == 4);
  CHECK(list.settings.front().name == "radius-1.2");
  CHECK(std::get<Splats>(list.settings.front().options.frame.how).kernel_radius == 1.2);
  CHECK_FALSE(list.settings[5].options.frame.shown.opacity_correction);
  CHECK(kernel_of(list.settings[13]) == KernelOptions{.qee_bits = 10, .normalisation = Normalisation::exact});
  CHECK(list.settings[16].options.frame.how == Method(Sheets{.slabs = 3}));
  CHECK(list.settings[17].options.frame.how == Method(Sheets{.light_points = 1}));
  CHECK(list.settings.back().name == "best");
  CHECK(list.scenes.front().dims == glm::ivec3(64));
  CHECK(list.views[3].elevation == 35.0);
  CHECK((list.width == 256 && list.height == 256 && list.repetitions == 5));
}

TEST_CASE("a setting says how kernels are drawn") {
  const StudyList list = parse_study_list(
      least + "kernel = \"texture\"\nphases = 16\nnormalisation = \"exact\"\n[setting.c]\nqee_bits = 10\n",
      "a list");
  CHECK(kernel_of(list.settings[0]) ==
        KernelOptions{.method = KernelMethod::texture, .phases = 16, .normalisation = Normalisation::exact});
  CHECK(kernel_of(list.settings[1]) == KernelOptions{.qee_bits = 10});
}

TEST_CASE("a setting may be sheets, by engine or by quality") {
  const StudyList list = parse_study_list(
      least + "[setting.c]\nengine = \"sheets\"\nslabs = 3\nlight_points = 1\nphong = true\n" +
          "image_plane = \"slices\"\nsamples = 1.5\n[setting.d]\nquality = \"draft\"\n" +
          "[setting.e]\nquality = \"normal\"\nimage_plane = \"screen\"\n",
      "a list");
  REQUIRE(list.settings.size() == 4);
  CHECK(list.settings[0].options.frame.how == Method(Splats{.kernel_radius = 2, .kernel = {}}));
  CHECK(
      list.settings[1].options.frame.how ==
      Method(Sheets{.image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 3, .light_points = 1}));
  CHECK(list.settings[2].options.frame.how ==
        Method(Sheets{.image_plane = ImagePlane::slices, .slabs = 2, .light_points = 1}));
  CHECK(list.settings[3].options.frame.how == Method(Sheets{.slabs = 2}));
}

TEST_CASE("a sweep adds views a step apart, both ends included") {
  const StudyList list = parse_study_list("sweep = \"0:90:1\"\n" + least, "a list");
  REQUIRE(list.views.size() == 92);
  CHECK(list.views[90].azimuth == 90.0);
}

TEST_CASE("a list that says something else is refused by section and key") {
  const std::pair<std::string, std::string> wrong[] = {
      {"speed = 3\n" + least, "speed"},
      {"repetitions = 0\n" + least, "repetitions"},
      {"repetitions = \"many\"\n" + least, "many"},
      {"truths = [\"gut\"]\n" + least, "gut"},
      {"views = [\"20\"]\n" + least, "azimuth and elevation"},
      {"sweep = \"0:90:0\"\n" + least, "FROM:TO:STEP"},
      {least + "colour = 1\n", "setting.b.colour"},
      {least + "kernel = \"sprite\"\n", "sprite"},
      {least + "phases = 0\n", "phases"},
      {least + "engine = \"rays\"\n", "splats|sheets"},
      {least + "quality = \"good\"\n", "paper|draft|normal|best"},
      {least + "engine = \"sheets\"\n", "setting b: a kernel"},
      {least + "slabs = 2\n", "--slabs has no effect on splats"},
      {least + "[setting.c]\nengine = \"sheets\"\nslabs = 5\n", "1 to 4"},
      {least + "[setting.c]\nengine = \"sheets\"\nquality = \"paper\"\n", "contradict"},
      {least + "[setting.c]\nengine = \"sheets\"\nlight_points = 1\n", "phong = true"},
      {least + "[setting.c]\nimage_plane = \"slices\"\nsamples = 3\n", "samples"},
      {least + "[setting.c]\nimage_plane = \"slices\"\nsamples = 1.5\n", "--samples cannot be 1.5"},
      {least + "[setting.c]\nsamples = 2\n", "no effect on the screen"},
      {least + "normalisation = \"some\"\n", "constant|exact"},
      {least + "kernel = \"texture\"\nqee_bits = 10\n", "--qee-bits"},
      {"[scene.a]\nsynth = \"ball\"\n[setting.b]\nradius = 2.0\n", "at least one"},
      {"views = [\"0 0\"]\n[scene.a]\ntf = \"grey\"\n[setting.b]\nradius = 2.0\n", "either synth or volume"},
      {"views = [\"0 0\"]\n[scene.a]\nsynth = \"cow\"\n[setting.b]\nradius = 2.0\n", "cow"},
  };
  for (const auto& [text, named] : wrong) {
    INFO(text);
    try {
      static_cast<void>(parse_study_list(text, "my.toml"));
      FAIL("was not refused");
    } catch (const InputError& e) {
      CHECK(std::string(e.what()).find(named) != std::string::npos);
    }
  }
}
