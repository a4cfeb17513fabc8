// "auto" on pictures of detectors, whose background is noise about an offset: it is clear, and the object is
// not.
#include <array>
#include <random>
#include <string>

#include "classify/made_volume.hpp"

using namespace ringsplat;

namespace {

/// From 0, background, to 1.
using Object = double (*)(double x, double y, double z);

double soft_ball(double x, double y, double z, double size) {
  return std::clamp((size - radius(x - 0.1, y + 0.2, z)) / (0.1 * size) + 0.5, 0.0, 1.0);
}
double large(double x, double y, double z) { return soft_ball(x, y, z, 0.7); }
double small(double x, double y, double z) { return soft_ball(x, y, z, 0.25); }
double threads(double x, double y, double z) {
  double most = 0;
  for (int k = 0; k < 5; ++k) {
    const double away = std::hypot(y - 0.6 * std::sin(3 * x + k), z - 0.6 * std::cos(2 * x + 2 * k));
    most = std::max(most, std::exp(-away * away / 0.006));
  }
  return most;
}

struct Detector {
  double offset, noise, bright, lowest, highest;
};

template <class T>
void require_seen(const Detector& d, Object object, bool brighter_is_noisier) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::array<double, 2> voxels{}, visible{};  // of the background, of the object
  std::vector<double> shares;
  const Volume<T> volume([&](double x, double y, double z) {
    const double share = object(x, y, z);
    shares.push_back(share);
    const double noise = d.noise * (brighter_is_noisier ? std::sqrt(1 + 8 * share) : 1);
    const double value = d.offset + d.bright * share + noise * normal(random);
    return std::clamp(std::is_integral_v<T> ? std::round(value) : value, d.lowest, d.highest);
  });
  const auto made = volume.choice();
  for (std::size_t k = 0; k < shares.size(); ++k) {
    if (shares[k] > 0.02 && shares[k] < 0.5) continue;
    const std::size_t part = shares[k] >= 0.5 ? 1 : 0;
    ++voxels[part];
    visible[part] += made.function.evaluate(double(volume.voxels[k])).opacity > 0 ? 1 : 0;
  }
  INFO(d.offset << " +- " << d.noise << ", object " << d.bright << " more: " << made.why);
  CHECK(visible[0] <= 0.01 * voxels[0]);
  CHECK(visible[1] >= 0.5 * voxels[1]);
}

template <class T>
void require_seen(const Detector& detector) {
  for (const Object object : {large, small, threads})
    for (const bool brighter_is_noisier : {false, true})
      require_seen<T>(detector, object, brighter_is_noisier);
}

}  // namespace

TEST_CASE("auto leaves a background of noise about an offset clear, for all types, and shows the object") {
  for (const auto& [noise, bright] :
       {std::pair(400.0, 20000.0), {400.0, 2800.0}, {1500.0, 40000.0}, {6.0, 300.0}})
    require_seen<std::uint16_t>({5000, noise, bright, 0, 65535});
  for (const auto& [offset, noise] : {std::pair(20.0, 5.0), {8.0, 6.0}, {60.0, 10.0}})
    require_seen<std::uint8_t>({offset, noise, 140, 0, 255});
  require_seen<std::int16_t>({-200, 50, 3000, -32768, 32767});
  require_seen<std::int16_t>({1000, 30, 300, -32768, 32767});
  require_seen<float>({0.1, 0.02, 0.5, -1e9, 1e9});
  require_seen<float>({1e4, 200, 4000, -1e9, 1e9});
}

TEST_CASE("auto takes no field that has no background for noise about an offset") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even;
  const std::vector<Volume<float>> fields{
      Volume<float>([&](double, double, double) { return even(random); }),
      Volume<float>([&](double, double, double) { return 10 + normal(random); }),
      Volume<float>([&](double, double, double) { return std::exp(0.8 * normal(random)); }),
      Volume<float>([](double x, double y, double z) {
        return 5 + std::sin(4 * x) * std::cos(3 * y) * std::cos(5 * z);
      }),
      Volume<float>([](double x, double, double) { return x + 2; }),
      Volume<float>([&](double x, double y, double z) {  // three parts, the middle one the largest
        const double wave = std::sin(9 * x) * std::sin(8 * y) * std::sin(7 * z);
        return (wave > 0.2 ? 3 : wave > -0.2 ? 2 : 1) + 0.1 * normal(random);
      })};
  for (const auto& field : fields) {
    const auto made = field.choice();
    INFO(made.why);
    CHECK_FALSE(says(made.why, "background"));
    CHECK(field.coverage(made.function) > 0.9);
  }
}
