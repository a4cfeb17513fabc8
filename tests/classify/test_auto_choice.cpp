// What "auto" chooses for volumes that a picture can fail on.
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "classify/adjust.hpp"
#include "classify/auto_preset.hpp"
#include "classify/classifier.hpp"
#include "classify/find_visible.hpp"
#include "classify/made_volume.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

/// A soft ball, 0 outside to 255 in its middle.
double ball(double x, double y, double z) { return std::max(0.0, 255 * (1 - radius(x, y, z) / 0.8)); }

/// Neither next to nothing of the volume nor all of it, and neither a haze nor a block.
template <class T>
void require_useful(const Volume<T>& volume, const AutoChoice& made) {
  INFO(made.why);
  const double coverage = volume.coverage(made.function);
  CHECK(coverage > 0.005);
  CHECK(coverage < 0.75);
  double densest = 0;
  for (const T v : volume.voxels)
    if (std::isfinite(double(v))) densest = std::max(densest, made.function.evaluate(double(v)).opacity);
  CHECK(densest > 0.1);
}

}  // namespace

TEST_CASE("auto leaves out one voxel of 1e30, and says so") {
  const Volume<float> usual(ball);
  Volume<float> odd = usual;
  odd.voxels[1234] = 1e30F;
  const auto values = odd.statistics();
  CHECK(values.histogram.high < 256);
  CHECK(values.histogram.above == 1);
  CHECK(values.quantile(0.3) == 0);
  CHECK(values.quantile(0.999) < 256);
  const auto made = odd.choice();
  require_useful(odd, made);
  CHECK(says(made.why, "1 voxel far outside (up to 1e+30)"));
  CHECK(made.range.high < 260);
  CHECK(made.function.evaluate(1e30).opacity == 0);
  CHECK(made.function.evaluate(255).opacity > 0.3);
  CHECK(std::abs(odd.coverage(made.function) - usual.coverage(usual.choice().function)) < 0.02);
  odd.voxels[99] = -3e25F;
  require_useful(odd, odd.choice());
  CHECK(odd.choice().range.high < 260);
}

TEST_CASE("auto leaves a fill value clear, whether the file names it or not, and not-a-number") {
  const auto cut = [](double outside) {
    return [outside](double x, double y, double z) {
      return radius(x, y, z) > 0.8 ? outside : 10 + 20 * std::abs(x) * (1 + y * z);
    };
  };
  for (const double fill : {-9999.0, 9.96921e36, -32768.0, 1e20}) {
    Volume<float> volume(cut(fill));
    for (const bool noted : {false, true}) {
      if (noted) volume.notes.fill = fill;
      const auto made = volume.choice();
      INFO(fill << (noted ? " noted: " : ": ") << made.why);
      CHECK(made.range.low > 0);
      CHECK(made.range.high < 60);
      if (!noted) CHECK(made.function.evaluate(double(float(fill))).opacity == 0);
      if (!noted) CHECK(says(made.why, "left clear"));
      // An axis over the function resolves the data.
      if (!noted) CHECK(ends_of(made.function).high - ends_of(made.function).low < 500);
      if (!noted) require_useful(volume, made);
      if (noted) CHECK(volume.statistics().fill_voxels > side * side);
    }
  }
  const Volume<float> flow([](double x, double y, double z) {
    return radius(x, y, z) > 0.8 ? -9999 : 3 * std::sin(4 * x) * std::cos(3 * y) * std::cos(2 * z);
  });
  const auto made = flow.choice();
  require_useful(flow, made);
  CHECK(says(made.why, "diverging"));
  CHECK(made.function.evaluate(-9999).opacity == 0);
  CHECK(made.function.evaluate(-3).opacity > 0.1);
  const Volume<float> nan(cut(std::numeric_limits<double>::quiet_NaN()));
  require_useful(nan, nan.choice());
}

TEST_CASE("auto makes no step and little haze of a plateau inside the object") {
  const Volume<float> volume([](double x, double y, double z) {
    const double r = radius(x, y, z);
    return r > 0.95 ? 0.0 : r > 0.9 ? 100.0 * (0.95 - r) / 0.05 : r > 0.4 ? 100.0 : 100 + 300 * (0.4 - r);
  });
  const auto made = volume.choice();
  require_useful(volume, made);
  const auto opacity = [&](double v) { return made.function.evaluate(v).opacity; };
  CHECK(says(made.why, "at 100"));
  CHECK(opacity(0) == 0);
  CHECK(std::abs(opacity(102) - opacity(98)) < 0.05);
  CHECK(-std::log1p(-opacity(100)) * side < 1.5);
  CHECK(opacity(200) > 5 * opacity(100));
}

TEST_CASE("auto shows both signs of a field about zero in diverging colours, zero clear") {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 1);
  const std::vector<Volume<float>> volumes{
      Volume<float>([](double x, double y, double z) {
        return 3 * std::sin(4 * x) * std::cos(3 * y) * std::cos(2 * z);
      }),
      Volume<float>([&](double, double, double) { return noise(random); }),
      Volume<float>([](double x, double y, double z) { return 1e-6 * x * std::exp(-9 * radius(x, y, z)); })};
  for (const auto& volume : volumes) {
    const auto made = volume.choice();
    require_useful(volume, made);
    INFO(made.why);
    CHECK(says(made.why, "diverging"));
    const auto at = [&](double part) { return made.function.evaluate(part * made.range.high); };
    CHECK(made.range.low == -made.range.high);
    CHECK(at(0).opacity == 0);
    CHECK(at(1).opacity > 0.1);
    CHECK(at(-1).opacity == at(1).opacity);
    CHECK(at(-1).colour.z > 2 * at(-1).colour.x);
    CHECK(at(1).colour.x > 2 * at(1).colour.z);
  }
}

TEST_CASE("auto spreads over narrow ranges of floats and of few 16-bit values") {
  const Volume<float> narrow([](double x, double y, double z) { return 1000 + 3 * ball(x, y, z) / 255; });
  require_useful(narrow, narrow.choice());
  CHECK(narrow.choice().range.low >= 1000);
  CHECK(narrow.choice().range.high <= 1003);
  std::mt19937 random(4);
  const Volume<std::uint16_t> few([&](double x, double y, double z) {
    return 40000 + std::lround(3 * ball(x, y, z) / 255 + 0.6 * double(random() % 1000) / 1000);
  });
  const auto made = few.choice();
  require_useful(few, made);
  CHECK_FALSE(made.labels);
  CHECK(made.function.evaluate(40000).opacity == 0);
  CHECK(made.function.evaluate(40003).opacity > made.function.evaluate(40001).opacity);
}

TEST_CASE("auto has the colours of tissue for patients alone, and shows the same of all else") {
  for (const bool decades : {false, true}) {
    Volume<float> volume([&](double x, double y, double z) {
      return decades ? std::pow(10.0, 6 * (1 - radius(x, y, z))) : ball(x, y, z);
    });
    const auto sample = volume.choice();
    volume.notes.world = World::patient;
    const auto patient = volume.choice();
    CHECK(says(sample.why, "viridis"));
    CHECK(says(patient.why, "warm ramp"));
    for (const double part : {0.2, 0.5, 0.9}) {
      const double value = part * patient.range.high;
      CHECK(sample.function.evaluate(value).opacity == patient.function.evaluate(value).opacity);
      CHECK(patient.function.evaluate(value).colour.x > patient.function.evaluate(value).colour.z);
    }
    CHECK(sample.function.colours.front().srgb.z > sample.function.colours.front().srgb.x);
  }
}

TEST_CASE("auto takes logarithmic steps over many decades") {
  const Volume<float> density([](double x, double y, double z) {
    return std::pow(10.0, 6 * (1 - radius(x, y, z) / 1.8) + std::sin(9 * x) * std::cos(7 * y) * 0.5);
  });
  const auto made = density.choice();
  require_useful(density, made);
  CHECK(says(made.why, "logarithmic"));
  const double low = made.range.low, high = made.range.high;
  CHECK(high > 100 * low);
  // Half-way on the logarithm's axis it is neither clear nor as dense as at the end.
  const double middle = made.function.evaluate(std::sqrt(low * high)).opacity;
  CHECK(middle > 0.01);
  CHECK(middle < 0.9 * made.function.evaluate(high).opacity);
}

TEST_CASE("zeros do not count as positive on a logarithmic axis") {
  const Volume<float> decay([](double x, double y, double z) {
    return radius(x, y, z) > 0.8 ? 0 : 1000 * std::exp(-8 * radius(x, y, z));
  });
  CHECK(positive_range(decay.statistics()).low > 0.1);
  CHECK(decay.choice().function.colours.front().value > 0.1);
}

TEST_CASE(
    "auto knows CT in Hounsfield units by its range or by the modality, with the air and the headrest "
    "clear") {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 12);
  const auto head = [&](double x, double y, double z) {
    const double r = radius(x, y, z), here = noise(random);
    if (y > 0.85 && z > -0.5) return -800 + here;  // foam below the head
    return (r > 0.8 ? -1000 : r > 0.7 ? 20 : r > 0.6 ? 1300 : 35) + here;
  };
  Volume<std::int16_t> volume(head);
  auto made = volume.choice();
  require_useful(volume, made);
  CHECK(says(made.why, "CT in Hounsfield units"));
  CHECK(says(made.why, "ct-soft"));
  CHECK(made.function.evaluate(-1000).opacity == 0);
  CHECK(made.function.evaluate(-800).opacity == 0);
  CHECK(made.function.evaluate(1300).opacity > 0.5);
  // A part without air is CT only by its modality.
  Volume<std::int16_t> part([&](double x, double y, double z) { return std::max(-300.0, head(x, y, z)); });
  CHECK_FALSE(says(part.choice().why, "CT"));
  part.notes.modality = "CT";
  CHECK(says(part.choice().why, "modality CT"));
  Volume<std::int16_t> raw(
      [&](double x, double y, double z) { return 1024 + std::max(-1024.0, head(x, y, z)); });
  raw.notes.modality = "CT";
  CHECK_FALSE(says(raw.choice().why, "Hounsfield"));  // not rescaled
}

TEST_CASE(
    "auto keeps an 8-bit MR-like volume's background clear, and calls no scan of more than 6 levels labels") {
  std::mt19937 random(6);
  std::normal_distribution<double> noise(0, 3);
  for (const int levels : {256, 64, 32, 16, 12, 8, 6, 5, 4, 3}) {
    const Volume<std::uint8_t> scan([&](double x, double y, double z) {
      const double r = radius(x, y, z);
      const double tissue = r > 0.85   ? 4
                            : r > 0.75 ? 150
                            : r > 0.7  ? 30
                                       : 80 + 60 * std::sin(7 * x + 5 * y * z);
      const double value = std::clamp(tissue + noise(random), 0.0, 255.0);
      return std::floor(value * levels / 256) * (levels > 8 ? 256 / levels : 1);
    });
    const auto made = scan.choice();
    INFO(levels << ' ' << made.why);
    CHECK(made.labels == (levels <= 6));
    require_useful(scan, made);
    CHECK(made.function.evaluate(double(scan.voxels[0])).opacity == 0);
  }
}

TEST_CASE("labels are found where few whole numbers lie in pieces, and each has its own colour exactly") {
  const auto pieces = [](auto number) {
    return [number](double x, double y, double z) {
      if (radius(x, y, z) > 0.9) return 0.0;
      std::mt19937 random(8);
      double nearest = 9;
      int which = 0;
      for (int k = 0; k < 9; ++k) {
        const auto place = [&] { return 2 * double(random() % 1000) / 1000 - 1; };
        const double a = place(), b = place(), c = place();
        const double distance = radius(x - a, y - b, z - c);
        if (distance < nearest) nearest = distance, which = k;
      }
      return number(which);
    };
  };
  const auto freesurfer = [](int k) {
    constexpr double numbers[] = {2, 41, 3, 42, 17, 2035, 1011, 77, 16};
    return numbers[k];
  };
  const auto large = [](int k) { return k == 4 ? 100000.0 : 7.0 * k + 1; };
  const Volume<std::uint8_t> small(pieces([](int k) { return k + 1.0; }));
  const Volume<std::int16_t> aseg(pieces(freesurfer));
  const Volume<std::int32_t> wide(pieces(large));
  const Volume<float> floats(pieces(freesurfer));
  const auto require_labels = [](const auto& volume) {
    const auto made = volume.choice();
    INFO(made.why);
    REQUIRE(made.labels);
    CHECK(says(made.why, "9 labels"));
    const auto type = volume.statistics().grid.type;
    const Classifier classifier(made.function, type, 1.0);
    for (const double label : volume.statistics().labels) {
      auto value = static_cast<typename std::decay_t<decltype(volume.voxels)>::value_type>(label);
      const auto row = find_visible(classifier, reinterpret_cast<const std::byte*>(&value), 1);
      REQUIRE(row.visible == (label == 0 ? 0U : 1U));
      if (label == 0) continue;
      const ClassifiedSample sample = classifier.table()
                                          ? classifier.table()->samples[int(label) - classifier.table()->low]
                                          : classifier.evaluate(label);
      TransferFunction one;
      one.colours = {{0, label_colour(label)}, {1, label_colour(label)}};
      one.opacities = {{0, label_opacity}, {1, label_opacity}};
      const auto wanted = Classifier(one, ScalarType::float64, 1.0).evaluate(0.5);
      CHECK(sample.r == wanted.r);
      CHECK(sample.g == wanted.g);
      CHECK(sample.b == wanted.b);
      CHECK(sample.opacity == wanted.opacity);
      CHECK(made.function.evaluate(label + 0.75).opacity * (label == 100000 ? 1 : 0) == 0);
    }
  };
  require_labels(small);
  require_labels(aseg);
  require_labels(wide);
  require_labels(floats);
}

TEST_CASE(
    "masks and few values about a frequent 0 are labels, however they are nested, and all are visible") {
  const auto nested = [](double x, double y, double z) {
    const double r = radius(x, y, z);
    return r > 0.9 ? 0 : r > 0.6 ? 1 : r > 0.4 ? 2 : r > 0.3 ? 3 : 4;
  };
  const auto require_all = [](const auto& volume, std::size_t count) {
    const auto made = volume.choice();
    INFO(made.why);
    CHECK(made.labels);
    const auto labels = volume.statistics().labels;
    CHECK(labels.size() == count);
    for (const double label : labels) CHECK(made.function.evaluate(label).opacity == (label == 0 ? 0 : 0.9));
  };
  require_all(Volume<std::uint8_t>(nested), 5);
  require_all(Volume<std::int16_t>(nested), 5);
  require_all(Volume<float>(nested), 5);
  require_all(Volume<std::uint8_t>([&](double x, double y, double z) { return nested(x, y, z) > 0; }), 2);
  require_all(
      Volume<std::uint16_t>([&](double x, double y, double z) { return nested(x, y, z) > 3 ? 40000 : 0; }),
      2);
  require_all(Volume<std::uint8_t>([&](double x, double y, double z) { return nested(x, y, z) < 4; }), 2);
}

TEST_CASE("labels of a large volume are found by some of its rows, the same whoever has which slice") {
  constexpr int wide = 256, slices = 80;  // one row in two
  const auto statistics_of = [](auto value_at, const std::vector<int>& order) {
    const Pass pass = [&](const RowVisitor& visit) {
      std::vector<std::uint8_t> slice;
      for (const int z : order) {
        slice.clear();
        for (int y = 0; y < wide; ++y)
          for (int x = 0; x < wide; ++x) slice.push_back(std::uint8_t(value_at(x, y, z)));
        visit(std::as_bytes(std::span(slice)), wide);
      }
    };
    return describe_values({.dims = {wide, wide, slices}, .type = ScalarType::uint8}, {}, pass);
  };
  std::vector<int> forwards(slices), backwards(slices);
  std::iota(forwards.begin(), forwards.end(), 0);
  std::iota(backwards.rbegin(), backwards.rend(), 0);
  const auto pieces = [](int x, int y, int z) { return 1 + 7 * (x / 16 * 5 + y / 16 * 3 + z / 16) % 20; };
  const auto levels = [](int x, int y, int z) { return (x + y + z) / 8 % 20; };
  const auto counted = statistics_of(pieces, forwards), again = statistics_of(pieces, backwards);
  CHECK(look_like_labels(counted));
  CHECK_FALSE(look_like_labels(statistics_of(levels, forwards)));
  const auto pairs = [](const NeighbourCounts& n) { return n.equal + n.adjacent + n.apart; };
  CHECK(pairs(*counted.neighbours) == std::uint64_t(wide - 1) * wide / 2 * slices);
  CHECK(counted.neighbours->equal == again.neighbours->equal);
  CHECK(counted.neighbours->apart == again.neighbours->apart);
}

TEST_CASE("counts of few events are no labels, and none of them is cut off") {
  std::mt19937 random(7);
  const Volume<std::uint8_t> counts([&](double x, double y, double z) {
    return std::min(15, std::poisson_distribution<int>(radius(x, y, z) < 0.5 ? 3 : 0.3)(random));
  });
  const auto made = counts.choice();
  INFO(made.why);
  CHECK_FALSE(made.labels);
  CHECK(made.function.evaluate(0).opacity == 0);
  for (int value = 1; value <= 10; ++value) CHECK(made.function.evaluate(value).opacity > 0);
}

TEST_CASE("labels that are asked for must be whole numbers") {
  const Volume<float> scan(ball);
  CHECK(says(message_of<InputError>([&] { choose_labels(scan.statistics()); }), "no labels"));
  const Volume<std::uint8_t> nothing([](double, double, double) { return 0; });
  CHECK(says(message_of<InputError>([&] { choose_labels(nothing.statistics()); }), "has no label"));
  Volume<std::uint8_t> mask([](double x, double y, double z) { return ball(x, y, z) > 100 ? 2 : 1; });
  CHECK_FALSE(mask.choice().labels);
  mask.notes.labels = true;
  CHECK(mask.choice().labels);
  CHECK(choose_labels(mask.statistics()).function.evaluate(1).opacity == label_opacity);
}

TEST_CASE("a window's function is clear at its low end and dense at its high end, on either axis") {
  const Volume<float> volume([](double x, double y, double z) { return ball(x, y, z) + 1; });
  for (const bool logarithmic : {false, true}) {
    const auto made = choose_within(volume.statistics(), {50, 200}, logarithmic);
    CHECK(made.function.evaluate(49).opacity == 0);
    CHECK(made.function.evaluate(200).opacity > 0.2);
    CHECK(made.function.opacities.back().value == 200);
  }
  CHECK(positive_range(volume.statistics()).high == Approx(volume.statistics().range.high));
  const Volume<float> negative([](double x, double, double) { return -1 - x * x; });
  CHECK(says(message_of<InputError>([&] { positive_range(negative.statistics()); }), "positive"));
}

TEST_CASE("opacities scale as a volume of another density would") {
  TransferFunction tf;
  tf.colours = {{0, glm::dvec3(0)}, {10, glm::dvec3(1)}};
  tf.opacities = {{0, 0.0}, {5, 0.19}, {10, 1.0}};
  scale_opacity(tf, 2);
  CHECK(tf.opacities[1].opacity == Approx(1 - 0.81 * 0.81));
  CHECK(tf.opacities[0].opacity == 0);
  CHECK(tf.opacities[2].opacity == 1);
  scale_opacity(tf, 0.25);
  CHECK(tf.opacities[1].opacity == Approx(0.1));
  stretch(tf, {-100, 300});
  CHECK(tf.opacities[1].value == Approx(100));
  CHECK(tf.colours[1].value == 300);
  clear_above(tf, 200);
  CHECK(tf.evaluate(199).opacity > 0.4);
  CHECK(tf.evaluate(200).opacity == 0);
  for (const bool whole : {false, true}) {
    TransferFunction cleared = tf;
    clear_at(cleared, 100, whole);
    CHECK(cleared.evaluate(100).opacity == 0);
    for (const double beside : {99.49, 100.51}) CHECK(cleared.evaluate(beside).opacity > 0.09);
    for (const double near : {99.51, 100.49}) CHECK((cleared.evaluate(near).opacity == 0) == whole);
  }
}

TEST_CASE("a logarithmic axis has eight steps a decade") {
  TransferFunction tf;
  tf.colours = {{1, glm::dvec3(0)}, {1000, glm::dvec3(1)}};
  tf.opacities = {{1, 0.0}, {10, 1.0}, {100, 0.0}};
  const TransferFunction stepped = at_logarithmic_steps(tf);
  CHECK(stepped.colours.size() == 25);
  CHECK(stepped.opacities.size() == 17);
  CHECK(stepped.evaluate(std::pow(10, 0.375)).opacity == Approx(0.375));
}
