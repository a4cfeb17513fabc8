#include <fstream>
#include <random>

#include "ringsplat/classify/transfer_function.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;

namespace {

std::string map_text(const std::string& fields) { return "[{" + fields + "}]"; }
const std::string colours = R"("RGBPoints":[0,0,0,0,1,1,1,1])";
const std::string opacities = R"("Points":[0,0,0.5,0,1,1,0.5,0])";

std::string refusal(const std::string& text) {
  return message_of([&] { parse_transfer_function(text, "map.json"); });
}

}  // namespace

TEST_CASE("a colour map as ParaView 5.11 exports it is read") {
  const auto tf = parse_transfer_function(R"([
	{
		"ColorSpace" : "RGB",
		"Creator" : "someone",
		"DefaultMap" : true,
		"Name" : "Muscle and Bone",
		"NanColor" : [ 1, 1, 0 ],
		"Points" : [ -3024, 0, 0.5, 0, -155.41, 0, 0.5, 0, 217.64, 0.68, 0.5, 0, 3071, 0.8, 0.5, 0 ],
		"RGBPoints" : [ -3024, 0, 0, 0, -155.407, 0.55, 0.25, 0.15, 217.641, 0.88, 0.6, 0.29, 3071, 1, 0.94, 0.95 ]
	}
])",
                                          "preset.json");
  REQUIRE(tf.name == "Muscle and Bone");
  REQUIRE(tf.nan_srgb == glm::dvec3(1, 1, 0));
  REQUIRE(tf.colours.size() == 4);
  REQUIRE(tf.colours[1] == TransferFunction::ColourPoint{-155.407, {0.55, 0.25, 0.15}});
  REQUIRE(tf.opacities.size() == 4);
  REQUIRE(tf.opacities[2] == TransferFunction::OpacityPoint{217.64, 0.68});
}

TEST_CASE("one object without a list is read too, and what may be left out has defaults") {
  const auto tf =
      parse_transfer_function("{" + colours + "," + opacities + R"(,"NanColor":null})", "map.json");
  REQUIRE(tf.name == "unnamed");
  REQUIRE(tf.nan_srgb == glm::dvec3(1, 0, 0));
  REQUIRE(tf.evaluate(0.25).opacity == 0.25);
}

TEST_CASE("writing and reading back gives the same transfer function, bit for bit") {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> share(0, 1), step(0, 1e3);
  for (int trial = 0; trial < 50; ++trial) {
    TransferFunction tf;
    tf.name = trial % 2 ? "with \"quotes\" and ü" : "plain";
    tf.nan_srgb = {share(random), share(random), share(random)};
    double value = -1e4 * share(random);
    for (int i = 0; i < 2 + trial % 7; ++i) {
      if (i % 3 != 1) value += step(random);  // some jumps
      tf.colours.push_back({value, {share(random), share(random), share(random)}});
      tf.opacities.push_back({value / 3, share(random)});
    }
    REQUIRE(parse_transfer_function(to_paraview_json(tf), "again") == tf);
  }
}

TEST_CASE("midpoints and sharpness are sampled, other colour spaces too") {
  const auto step =
      parse_transfer_function(map_text(colours + R"(,"Points":[0,0,0.25,1,1,1,0.5,0])"), "map.json");
  REQUIRE(step.evaluate(0.2).opacity == 0.0);
  REQUIRE(step.evaluate(0.3).opacity == 1.0);

  const auto hsv = parse_transfer_function(
      map_text(R"("ColorSpace":"HSV","RGBPoints":[0,1,0,0,1,0,0,1],)" + opacities), "map.json");
  REQUIRE(hsv.evaluate(0.5).colour.y == Approx(1.0));
  REQUIRE(hsv.evaluate(0.5).colour.x == Approx(0.0).margin(1e-9));
  const auto wrapped = parse_transfer_function(
      map_text(R"("ColorSpace":"HSV","HSVWrap":1,"RGBPoints":[0,1,0,0,1,0,0,1],)" + opacities), "map.json");
  REQUIRE(wrapped.evaluate(0.5).colour.y == Approx(0.0).margin(1e-9));
  const auto lab =
      parse_transfer_function(map_text(R"("ColorSpace":"Lab",)" + colours + "," + opacities), "map.json");
  REQUIRE(lab.evaluate(0.5).colour.x == Approx(0.18418).epsilon(2e-3));
}

TEST_CASE("what is wrong with a colour map is named with its field") {
  const std::string whole = colours + "," + opacities;
  const std::pair<std::string, const char*> wrong[] = {
      {"", "map.json is not JSON"},
      {"hello", "map.json is not JSON: parse error at line 1"},
      {R"([{"RGBPoints":[NaN]}])", "is not JSON"},
      {R"([{"RGBPoints":[1e999,0,0,0,1,1,1,1]}])", "is not JSON"},
      {std::string(100000, '['), "is not JSON"},
      {"[]", "holds 0 colour maps"},
      {"[{},{}]", "holds 2 colour maps"},
      {"7", "holds no colour map"},
      {"[[]]", "holds no colour map"},
      {map_text(opacities), "map.json has no RGBPoints"},
      {map_text(R"("IndexedColors":[1,0,0])"), "indexed colours"},
      {map_text(R"("RGBPoints":5,)" + opacities), "RGBPoints: is not a list"},
      {map_text(R"("RGBPoints":[0,0,0,0,1,1,1],)" + opacities), "7 numbers are not a multiple of 4"},
      {map_text(R"("RGBPoints":[0,0,0,0],)" + opacities), "RGBPoints has 1 point"},
      {map_text(colours + R"(,"Points":[0,0,0.5,0])"), "Points has 1 point"},
      {map_text(colours + R"(,"Points":[])"), "Points has 0 points"},
      {map_text(R"("RGBPoints":[1,0,0,0,0,1,1,1],)" + opacities), "point 2 at 0 comes after"},
      {map_text(R"("RGBPoints":[0,0,0,"x",1,1,1,1],)" + opacities), "entry 4 is not a number: \"x\""},
      {map_text(R"("RGBPoints":[0,0,0,null,1,1,1,1],)" + opacities), "entry 4 is not a number"},
      {map_text(R"("RGBPoints":[0,0,0,0,1,1,1.5,1],)" + opacities), "colour of point 2 is outside"},
      {map_text(colours + R"(,"Points":[0,-0.5,0.5,0,1,1,0.5,0])"), "opacity -0.5 of point 1"},
      {map_text(colours + R"(,"Points":[0,0,1.5,0,1,1,0.5,0])"), "midpoint or sharpness 1.5"},
      {map_text(whole + R"(,"NanColor":[1,0])"), "NanColor"},
      {map_text(whole + R"(,"NanColor":[1,0,0,1,0,0])"), "NanColor"},
      {map_text(whole + R"(,"ColorSpace":"Step")"), "ColorSpace: \"Step\""},
      {map_text(whole + R"(,"Name":5)"), "Name: is not a text"}};
  for (const auto& [text, message] : wrong) {
    const std::string said = refusal(text);
    CAPTURE(message, said);
    CHECK(says(said, message));
    CHECK(said.find('\n') == std::string::npos);
  }
}

TEST_CASE("files: read, missing, a folder") {
  const support::TemporaryFolder folder;
  std::ofstream(folder / "map.json") << map_text(colours + "," + opacities);
  REQUIRE(read_transfer_function(folder / "map.json").evaluate(0.5).opacity == 0.5);
  REQUIRE(says(message_of([&] { read_transfer_function(folder / "none.json"); }), "none.json"));
  REQUIRE(says(message_of([&] { read_transfer_function(folder.path()); }), "is a folder"));
  std::ofstream(folder / "binary.json", std::ios::binary) << std::string(1000, '\0') << "\xff\xfe";
  REQUIRE(
      says(message_of([&] { read_transfer_function(folder / "binary.json"); }), "binary.json is not JSON"));
}

TEST_CASE("a map without opacity points gets a ramp over its colours, and says so") {
  for (const std::string& map : {map_text(colours), map_text(colours + R"(,"Points":null)")}) {
    bool ramp = false;
    const TransferFunction tf = parse_transfer_function(map, "map.json", &ramp);
    CHECK(ramp);
    CHECK(tf.evaluate(0).opacity == 0);
    CHECK(tf.evaluate(0.25).opacity == Approx(0.25));
    CHECK(tf.evaluate(1).opacity == 1);
  }
  bool ramp = true;
  parse_transfer_function(map_text(colours + "," + opacities), "map.json", &ramp);
  CHECK_FALSE(ramp);
}
