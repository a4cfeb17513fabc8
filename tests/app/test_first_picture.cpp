// What the program shows of a volume at first sight, and the options that change it.
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "images/image_io.hpp"
#include "options/transfer_function_option.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

constexpr int side = 24;

template <class T>
void write_volume(const fs::path& file, const std::vector<T>& values) {
  write_text(file, {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

double radius_of(int k) {
  const auto place = [](int i) { return (2.0 * i + 1) / side - 1; };
  return std::hypot(place(k % side), place(k / side % side), place(k / side / side));
}

/// A soft ball of 0 to 255, by voxel numbers.
std::vector<float> ball() {
  std::vector<float> values;
  for (int k = 0; k < side * side * side; ++k)
    values.push_back(float(std::max(0.0, 255 * (1 - radius_of(k) / 0.9))));
  return values;
}

struct Files {
  TemporaryFolder folder;
  std::string usual = folder / "usual_24x24x24_float32.raw", odd = folder / "odd_24x24x24_float32.raw",
              labels = folder / "labels_24x24x24_int16.raw", picture = folder / "x.exr";

  Files() {
    auto values = ball();
    write_volume(usual, values);
    values[5000] = 1e30F;
    write_volume(odd, values);
    std::vector<std::int16_t> numbers;
    for (int k = 0; k < side * side * side; ++k) {
      const int piece =
          (k % side >= 12 ? 1 : 0) + (k / side % side >= 12 ? 2 : 0) + (k / side / side >= 12 ? 4 : 0);
      static constexpr std::int16_t known[] = {2, 41, 2035, 17, 1011, 3, 77, 10};
      numbers.push_back(radius_of(k) > 0.9 ? 0 : known[piece]);
    }
    write_volume(labels, numbers);
  }
  Ended render(const std::string& volume, const Words& more = {}, int ranks = 0) const {
    return run_program(joined({"render", volume, "-o", picture, "--size", "64", "--shading", "none"}, more),
                       ranks);
  }
  Image drawn() const { return read_image(picture).image; }
};

/// The share of pixels that are not clear, and the largest opacity.
struct Seen {
  double coverage = 0, most = 0;
};
Seen seen_in(const Image& image) {
  Seen seen;
  for (std::size_t k = 3; k < image.rgba.size(); k += 4) {
    seen.coverage += image.rgba[k] > 0.01F ? 4.0 / double(image.rgba.size()) : 0;
    seen.most = std::max(seen.most, double(image.rgba[k]));
  }
  return seen;
}

ValueStatistics positive_values() {
  Histogram histogram(1, 1000, 64);
  for (auto& count : histogram.counts) count = 10;
  return describe_values(histogram);
}

}  // namespace

TEST_CASE("an outlier changes neither what is seen nor the histogram, and one line says what was chosen") {
  const Files files;
  REQUIRE(files.render(files.usual).code == 0);
  const Seen usual = seen_in(files.drawn());
  const Ended ended = succeeded(files.render(files.odd));
  CHECK(lines_with(ended.out, "--tf auto: ").size() == 1);
  CHECK_THAT(ended.out, Catch::Matchers::Contains("1 voxel far outside (up to 1e+30)"));
  const Seen odd = seen_in(files.drawn());
  CHECK(usual.coverage > 0.05);
  CHECK(std::abs(odd.coverage - usual.coverage) < 0.02);
  CHECK(odd.most > 0.5);

  const Ended told = succeeded(run_program({"info", files.odd, "--json"}));
  const json info = json::parse(told.out);
  CHECK(info.at("histogram").at("above") == 1);
  CHECK(info.at("histogram").at("high").get<double>() < 256);
  CHECK(info.at("range").at(1).get<double>() > 9e29);
  REQUIRE(info.at("quantiles").size() == 9);
  CHECK(info.at("quantiles").at(7).at("value").get<double>() < 256);
  CHECK(info.at("notes").at("fill_voxels") == 0);
  const std::string text = run_program({"info", files.odd}).out;
  CHECK_THAT(text, Catch::Matchers::Contains("quantiles") && Catch::Matchers::Contains("99.9 %"));
  CHECK(lines_with(text, "above").size() == 1);
}

TEST_CASE("the chosen transfer function and its picture are the same on any ranks", "[mpi]") {
  const Files files;
  const std::string function = files.folder / "tf.json";
  std::string first;
  std::optional<Image> picture;
  for (const int ranks : {0, 2, 5}) {
    REQUIRE(files.render(files.odd, {"--tf-out", function}, ranks).code == 0);
    if (first.empty()) first = read_text(function);
    if (!picture) picture = files.drawn();
    CHECK(read_text(function) == first);
    CHECK(files.drawn() == *picture);
  }
}

TEST_CASE("what was chosen goes to stderr when a file goes to stdout", "[mpi]") {
  const Files files;
  const Ended ended = succeeded(files.render(files.usual, {"--tf-out", "-"}));
  CHECK(json::parse(ended.out).is_array());
  CHECK_THAT(ended.err, Catch::Matchers::Contains("--tf auto: "));
}

TEST_CASE("labels are found, told, and drawn without values between them", "[mpi]") {
  const Files files;
  const Ended found = succeeded(files.render(files.labels));
  CHECK_THAT(found.out, Catch::Matchers::Contains("8 labels"));
  CHECK(found.err.empty());
  const Image by_itself = files.drawn();
  CHECK(seen_in(by_itself).most > 0.9);
  REQUIRE(files.render(files.labels, {"--labels", "--quality", "best", "--interpolation", "nearest"}).code ==
          0);
  CHECK(files.drawn() == by_itself);
  REQUIRE(files.render(files.labels, {"--interpolation", "linear"}).code == 0);
  CHECK_FALSE(files.drawn() == by_itself);
  const Ended slabs = succeeded(files.render(files.labels, {"--slabs", "1"}));
  CHECK(slabs.err.empty());
  CHECK_FALSE(files.drawn() == by_itself);
  CHECK(files.render(files.usual, {"--labels"}).code == 2);
}

TEST_CASE("a nearly empty picture is warned of, a useful one is not", "[mpi]") {
  const Files files;
  const Ended thin = succeeded(files.render(files.usual, {"--tf", "grey", "--opacity", "1e-5"}));
  CHECK_THAT(thin.err, Catch::Matchers::Contains("nearly empty") && Catch::Matchers::Contains("--opacity"));
  const Ended usual = files.render(files.usual, {"--tf", "grey"});
  CHECK_THAT(usual.err, !Catch::Matchers::Contains("nearly empty"));
}

TEST_CASE("options of colours change the transfer function as they say", "[mpi]") {
  const Files files;
  const std::string function = files.folder / "tf.json";
  const auto made = [&](const Words& options) {
    succeeded(files.render(files.usual, joined(options, {"--tf-out", function})));
    return read_transfer_function(function);
  };
  const TransferFunction stretched = made({"--tf", "grey", "--range", "50:150"});
  CHECK(stretched.evaluate(50).opacity == 0);
  CHECK(stretched.evaluate(100).opacity == Approx(0.125));
  CHECK(stretched.evaluate(150).opacity == Approx(0.25));
  CHECK(made({"--tf", "grey", "--range", "50:150", "--opacity", "2"}).evaluate(150).opacity ==
        Approx(1 - 0.75 * 0.75));
  const TransferFunction coloured = made({"--tf", "grey", "--range", "0:200", "--colours", "Viridis"});
  CHECK(coloured.evaluate(200).opacity == Approx(0.25));  // kept
  CHECK(coloured.evaluate(200).colour.x > 0.9);
  CHECK(coloured.evaluate(200).colour.z < 0.1);
  const TransferFunction window = made({"--range=20:120"});
  CHECK(window.opacities.front().value == 20);
  CHECK(window.opacities.back().value == 120);
  const TransferFunction logarithmic = made({"--tf", "grey", "--range", "1:100", "--log"});
  CHECK(logarithmic.evaluate(10).opacity == Approx(0.125));
  CHECK(logarithmic.evaluate(0).opacity == 0);
  CHECK(made({"--log"}).evaluate(-1).opacity == 0);
  CHECK_THAT(run_program({"render", "--colours", "list"}).out,
             Catch::Matchers::StartsWith("viridis") && Catch::Matchers::Contains("coolwarm"));
  CHECK_THAT(run_program({"info", "--presets"}).out, Catch::Matchers::Contains("viridis"));
}

TEST_CASE("a map without opacities is shown as a ramp, and told", "[mpi]") {
  const Files files;
  const fs::path map = files.folder / "map.json";
  write_text(map, R"([{"Name":"plain","RGBPoints":[0,0,0,1, 200,1,0,0]}])");
  const Ended ended = succeeded(files.render(files.usual, {"--tf", map.string()}));
  CHECK_THAT(ended.out,
             Catch::Matchers::Contains("no opacities, so a ramp from clear at 0 to opaque at 200"));
}

TEST_CASE("a fill value that the file names is clear in every transfer function") {
  ValueStatistics values = positive_values();
  values.notes.fill = 1e20;
  values.fill_voxels = 7;
  for (const char* name : {"auto", "grey", "ct-bone"}) {
    Shown shown;
    app::TransferFunctionChoice(name).make(values, shown);
    CHECK(shown.transfer_function.evaluate(1e20).opacity == 0);
    CHECK(shown.transfer_function.evaluate(1000).opacity > 0.1);
  }
  values.notes.fill = 500;
  Shown shown;
  app::TransferFunctionChoice("grey").make(values, shown);
  CHECK(shown.transfer_function.evaluate(500).opacity == 0);
  CHECK(shown.transfer_function.evaluate(500.001).opacity > 0.1);
}
