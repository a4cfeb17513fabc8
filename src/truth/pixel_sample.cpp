// Chooses the pixels to sample: makes strata by the picture's local variation, and gives each its share of
// the sample.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <unordered_set>

#include "truth/parallel.hpp"
#include "truth/sampling.hpp"

namespace ringsplat::truth {
namespace {

// Classes: activity from 2⁻²⁰ up in eighths of an octave, separately for opaque pixels, since only these err
// by what a Renderer leaves out behind them.
constexpr int lowest_octave = -20, octaves = 24, steps = 8, activity_classes = octaves * steps;
constexpr std::size_t classes = 2 * activity_classes;
constexpr float opaque = 0.99F;

constexpr std::size_t most_strata = 16, pixels_a_stratum = 8;

/// The largest range of a channel over nine pixels that are `apart` from each other.
float range(const Image& picture, int x, int y, int apart) {
  std::array<float, 4> low, high;
  std::copy_n(picture.pixel(x, y), 4, low.begin());
  high = low;
  for (int dy = -apart; dy <= apart; dy += apart) {
    const int row = std::clamp(y + dy, 0, picture.height - 1);
    for (int dx = -apart; dx <= apart; dx += apart) {
      const float* other = picture.pixel(std::clamp(x + dx, 0, picture.width - 1), row);
      for (std::size_t c = 0; c < 4; ++c) {
        low[c] = std::min(low[c], other[c]);
        high[c] = std::max(high[c], other[c]);
      }
    }
  }
  float range = 0;
  for (std::size_t c = 0; c < 4; ++c) range = std::max(range, high[c] - low[c]);
  return range;
}

/// How much the picture varies about a pixel: the larger of the nearest pixels' range and half that of
/// farther ones, plus an eighth of the pixel's largest value.
float activity(const Image& picture, int x, int y) {
  const float* pixel = picture.pixel(x, y);
  if (!std::all_of(pixel, pixel + 4, [](float v) { return std::isfinite(v); }))
    return std::numeric_limits<float>::infinity();
  const float most =
      std::max({std::abs(pixel[0]), std::abs(pixel[1]), std::abs(pixel[2]), std::abs(pixel[3])});
  return std::max(range(picture, x, y, 1), 0.5F * range(picture, x, y, 2)) + 0.125F * most;
}

/// Exponent and first three bits: of positive floats the bits ascend as the values do.
int step_of(float activity) {
  if (!std::isfinite(activity)) return activity_classes - 1;
  constexpr int bias = 127;
  const int step = int(std::bit_cast<std::uint32_t>(activity) >> 20) - (bias + lowest_octave) * steps;
  return std::clamp(step, 0, activity_classes - 1);
}

/// The least activity of class k. A power of two times a few bits, so that sums of it are exact.
double activity_of(std::size_t k) {
  const int step = int(k) % activity_classes;
  return step == 0 ? 0 : std::ldexp(1 + double(step % steps) / steps, lowest_octave + step / steps);
}

/// The class of each pixel within the bounds, row by row.
std::vector<std::uint16_t> classify(const Image& picture, const ScreenBounds& bounds) {
  std::vector<std::size_t> begin{0};
  for (const auto& row : bounds.rows)
    begin.push_back(begin.back() + std::size_t(std::max(0, row.end - row.first)));
  std::vector<std::uint16_t> all(begin.back());
  parallel_for(bounds.rows.size(), 16, [&](std::size_t from, std::size_t to) {
    for (std::size_t y = from; y < to; ++y)
      for (int x = bounds.rows[y].first; x < bounds.rows[y].end; ++x) {
        const bool is_opaque = picture.pixel(x, int(y))[3] >= opaque;
        all[begin[y] + std::size_t(x - bounds.rows[y].first)] =
            std::uint16_t(step_of(activity(picture, x, int(y))) + (is_opaque ? activity_classes : 0));
      }
  });
  return all;
}

/// Each class's share of the sample: half by its pixels, half by their activity.
std::array<double, classes> shares_of(const std::array<std::size_t, classes>& counts) {
  double pixels = 0, activity = 0;
  for (std::size_t k = 0; k < classes; ++k) {
    pixels += double(counts[k]);
    activity += double(counts[k]) * activity_of(k);
  }
  std::array<double, classes> shares{};
  for (std::size_t k = 0; k < classes; ++k) {
    const double by_pixels = double(counts[k]) / pixels;
    const double by_activity = activity > 0 ? double(counts[k]) * activity_of(k) / activity : by_pixels;
    shares[k] = 0.5 * by_pixels + 0.5 * by_activity;
  }
  return shares;
}

struct Strata {
  std::array<std::uint8_t, classes> of_class{};
  std::vector<PixelSample::Stratum> strata;
  std::vector<double> shares;
};

/// Joins neighbouring classes to strata with about the same share of the sample.
Strata make_strata(const std::array<std::size_t, classes>& counts, std::size_t most) {
  const auto shares = shares_of(counts);
  Strata made;
  const std::size_t together = most == 1 ? classes : activity_classes;
  for (std::size_t first = 0; first < classes; first += together) {
    double total = 0, before = 0;
    for (std::size_t k = first; k < first + together; ++k) total += shares[k];
    const double wanted = std::max(1.0, std::floor(double(most) * total + 0.5));
    double open = -1;  // number of the last stratum among those wanted
    for (std::size_t k = first; k < first + together; ++k) {
      if (counts[k] == 0) continue;
      const double middle = std::min(wanted - 1, std::floor((before + 0.5 * shares[k]) / total * wanted));
      before += shares[k];
      if (middle != open) {
        made.strata.emplace_back();
        made.shares.push_back(0);
        open = middle;
      }
      made.of_class[k] = std::uint8_t(made.strata.size() - 1);
      made.strata.back().pixels += counts[k];
      made.shares.back() += shares[k];
    }
  }
  return made;
}

/// Allots two pixels to each stratum and the rest by shares; what a stratum cannot use goes to the others.
void allot(Strata& s, std::size_t count) {
  std::size_t left = count;
  const auto give = [&](std::size_t k, std::size_t more) {
    auto& stratum = s.strata[k];
    more = std::min({more, left, stratum.pixels - stratum.sampled});
    stratum.sampled += more;
    left -= more;
  };
  for (std::size_t k = 0; k < s.strata.size(); ++k) give(k, 2);
  for (bool given = true; given && left > 0;) {
    const std::size_t before = left;
    double open = 0;
    for (std::size_t k = 0; k < s.strata.size(); ++k)
      if (s.strata[k].sampled < s.strata[k].pixels) open += s.shares[k];
    for (std::size_t k = 0; k < s.strata.size(); ++k)
      if (s.strata[k].sampled < s.strata[k].pixels) give(k, std::size_t(double(before) * s.shares[k] / open));
    given = left < before;
  }
  for (std::size_t k = 0; k < s.strata.size(); ++k) give(k, left);
}

/// `count` different numbers below `total`, ascending: Floyd's sampling (Bentley and Floyd 1987). Takes
/// remainders of the engine's numbers, since the standard does not fix its distributions' results; the bias
/// is below 2⁻³⁰ for any picture.
std::vector<std::size_t> choose(std::size_t total, std::size_t count, std::mt19937_64& random) {
  std::unordered_set<std::size_t> chosen;
  for (std::size_t j = total - count; j < total; ++j)
    if (!chosen.insert(random() % (j + 1)).second) chosen.insert(j);
  std::vector<std::size_t> places(chosen.begin(), chosen.end());
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace

PixelSample draw_sample(const Image& picture, const ScreenBounds& bounds, std::size_t count,
                        std::uint64_t seed) {
  PixelSample sample;
  sample.bounds = bounds;
  const auto classified = classify(picture, bounds);
  std::array<std::size_t, classes> counts{};
  for (const std::uint16_t k : classified) ++counts[k];
  Strata s = make_strata(counts, std::clamp<std::size_t>(count / pixels_a_stratum, 1, most_strata));
  allot(s, count);

  std::mt19937_64 random(seed);
  std::vector<std::vector<std::size_t>> chosen;
  for (const auto& stratum : s.strata) chosen.push_back(choose(stratum.pixels, stratum.sampled, random));
  std::vector<std::vector<Pixel>> pixels(s.strata.size());
  std::vector<std::size_t> met(s.strata.size());
  std::size_t at = 0;
  for (std::size_t y = 0; y < bounds.rows.size(); ++y)
    for (int x = bounds.rows[y].first; x < bounds.rows[y].end; ++x) {
      const std::size_t k = s.of_class[classified[at++]];
      if (pixels[k].size() < chosen[k].size() && chosen[k][pixels[k].size()] == met[k])
        pixels[k].push_back({x, int(y)});
      ++met[k];
    }
  sample.strata = std::move(s.strata);
  for (const auto& some : pixels) sample.pixels.insert(sample.pixels.end(), some.begin(), some.end());
  return sample;
}

}  // namespace ringsplat::truth
