#include <cmath>
#include <limits>
#include <random>

#include "classify/classifier.hpp"
#include "classify/find_visible.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

template <class T>
struct Data {
  std::vector<T> values;
  ScalarType type;

  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(values)); }
  Histogram histogram() const {
    ValueRange range;
    range.add(type, bytes());
    Histogram h(range.low, range.high, 256);
    h.add(type, bytes());
    return h;
  }
  /// The share of voxels with an opacity above zero.
  double visible(const TransferFunction& tf) const {
    const VisibleRow row = find_visible(Classifier(tf, type, 1.0), bytes().data(), int(values.size()));
    return row.visible / double(values.size());
  }
};

Data<std::uint8_t> head() {
  const auto source = open_volume(RINGSPLAT_TEST_DATA "/head.nrrd");
  const Grid& grid = source->grid();
  REQUIRE(grid.type == ScalarType::uint8);
  Data<std::uint8_t> data{std::vector<std::uint8_t>(std::size_t(grid.voxels())), ScalarType::uint8};
  source->read_slices(0, grid.dims.z, std::as_writable_bytes(std::span(data.values)));
  return data;
}

}  // namespace

TEST_CASE("every preset is a sound transfer function for any range, and survives ParaView's format") {
  for (const auto& [name, description] : preset_names()) {
    REQUIRE_FALSE(description.empty());
    for (const auto& [low, high] : {std::pair{0.0, 254.0},
                                    {-1024.0, 3071.0},
                                    {0.0, 1e-30},
                                    {-1.7e308, 1.7e308},
                                    {5.0, 5.0},
                                    {1.79e308, 1.79e308},
                                    {1.0, -1.0}}) {
      INFO(name << ' ' << low << ' ' << high);
      Histogram histogram(low, high, 64);
      const auto empty = preset(name, histogram);
      REQUIRE(message_of([&] { check(empty, name); }).empty());
      histogram.counts[0] = 100;
      histogram.counts[63] = 5;
      const auto tf = preset(name, histogram);
      REQUIRE(tf.name == name);
      REQUIRE(message_of([&] { check(tf, name); }).empty());
      REQUIRE(parse_transfer_function(to_paraview_json(tf), name) == tf);
    }
  }
}

TEST_CASE("an unknown name is answered with the names there are") {
  const auto message = message_of([] { preset("mr-bones", Histogram(0, 1, 4)); });
  REQUIRE(says(message, "\"mr-bones\""));
  for (const auto& [name, description] : preset_names()) REQUIRE(says(message, name));
}

TEST_CASE("on the head of the test data the MR presets show their shares of the voxels") {
  const auto data = head();
  const auto histogram = data.histogram();
  const double soft = data.visible(preset("mr-soft", histogram)),
               surface = data.visible(preset("mr-surface", histogram)),
               skin = data.visible(preset("mr-skin", histogram)),
               automatic = data.visible(preset("auto", histogram));
  INFO("soft " << soft << " surface " << surface << " skin " << skin << " auto " << automatic);
  REQUIRE(soft == Approx(0.327).margin(0.005));     // Neumann 1992: 664,486 of 128 x 128 x 124 voxels
  REQUIRE(surface == Approx(0.114).margin(0.005));  // 238,637 of 128 cubed
  REQUIRE(skin > 0.4);
  REQUIRE(skin < 0.7);
  REQUIRE(automatic > 0.2);
  REQUIRE(automatic < 0.7);
}

TEST_CASE("CT presets are in Hounsfield units, whatever the histogram") {
  for (const Histogram& h : {Histogram(0, 1, 4), Histogram(-1024, 3071, 4)}) {
    const auto bone = preset("ct-bone", h), skin = preset("ct-skin", h), soft = preset("ct-soft", h);
    for (const auto& tf : {bone, skin, soft}) REQUIRE(tf.evaluate(-1000).opacity == 0);  // air
    REQUIRE(bone.evaluate(50).opacity == 0);                                             // muscle
    REQUIRE(bone.evaluate(1000).opacity > 0.6);
    REQUIRE(skin.evaluate(0).opacity > 0.8);
    REQUIRE(soft.evaluate(50).opacity > 0.01);
    REQUIRE(soft.evaluate(50).opacity < 0.2);
    REQUIRE(soft.evaluate(1000).opacity > 0.6);
  }
}

TEST_CASE("grey is linear over the range") {
  const auto tf = preset("grey", Histogram(100, 300, 8));
  REQUIRE(tf.evaluate(100).opacity == 0);
  REQUIRE(tf.evaluate(200).opacity == Approx(0.125));
  REQUIRE(tf.evaluate(300).opacity == Approx(0.25));
  REQUIRE(tf.evaluate(200).colour.y == Approx(0.5));
}

TEST_CASE("auto: the background is clear, the object is not, at either end of the values") {
  std::mt19937_64 random(1);
  std::normal_distribution<float> air(0, 3), tissue(100, 10), bone(300, 20);
  Data<float> data{{}, ScalarType::float32};
  for (int i = 0; i < 7000; ++i) data.values.push_back(std::abs(air(random)));
  for (int i = 0; i < 2500; ++i) data.values.push_back(tissue(random));
  for (int i = 0; i < 500; ++i) data.values.push_back(bone(random));
  const auto tf = preset("auto", data.histogram());
  REQUIRE(data.visible(tf) > 0.29);
  REQUIRE(data.visible(tf) < 0.5);
  REQUIRE(tf.evaluate(0).opacity == 0);
  REQUIRE(tf.evaluate(100).opacity > 0.01);
  REQUIRE(tf.evaluate(300).opacity > tf.evaluate(100).opacity);

  Data<float> inverted = data;
  for (auto& v : inverted.values) v = 1000 - v;
  const auto inverse = preset("auto", inverted.histogram());
  REQUIRE(inverted.visible(inverse) > 0.29);
  REQUIRE(inverted.visible(inverse) < 0.5);
  REQUIRE(inverse.evaluate(1000).opacity == 0);
  REQUIRE(inverse.evaluate(700).opacity > inverse.evaluate(900).opacity);
}

TEST_CASE("auto is never blank where there is something to see, and shows a constant volume as a haze") {
  const std::vector<std::vector<double>> volumes{
      {0, 0, 0, 1},
      {1, 1, 1, 0},
      {0, 1},
      {-1e300, 1e300, 1e300},
      {0, 0, 0, 0, 0, 0, 0, 1e-300},
      {5, std::nextafter(5.0, 6.0), 5, 5},
      {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
  };
  for (const auto& values : volumes) {
    const Data<double> data{values, ScalarType::float64};
    const double visible = data.visible(preset("auto", data.histogram()));
    INFO(values[0] << ' ' << values[1] << " ...: " << visible);
    REQUIRE(visible > 0);
    REQUIRE(visible <= 1.0);
  }
  for (const double value : {0.0, 7.0, -1e300, 1.79e308}) {
    const Data<double> constant{std::vector<double>(50, value), ScalarType::float64};
    const auto tf = preset("auto", constant.histogram());
    REQUIRE(constant.visible(tf) == 1.0);
    REQUIRE(tf.evaluate(value).opacity == Approx(0.05));
  }
}
