#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "truth/metrics.hpp"

namespace ringsplat::truth {
namespace {

/// Mean signed difference of each row or column, over all channels, in 1/255.
std::vector<double> line_means(const Image& image, const Image& truth, bool columns) {
  const int lines = columns ? image.width : image.height, along = columns ? image.height : image.width;
  std::vector<double> means(std::size_t(lines), 0.0);
  for (int line = 0; line < lines; ++line)
    for (int k = 0; k < along; ++k) {
      const int x = columns ? line : k, y = columns ? k : line;
      for (int c = 0; c < 4; ++c)
        means[std::size_t(line)] +=
            255 * (double(image.pixel(x, y)[c]) - double(truth.pixel(x, y)[c])) / (4.0 * along);
    }
  return means;
}

/// How far the line is above both neighbours or below both; the ends have one neighbour.
double step_of(const std::vector<double>& means, std::size_t line) {
  const double above = line > 0 ? means[line] - means[line - 1] : means[line] - means[line + 1];
  const double below = line + 1 < means.size() ? means[line] - means[line + 1] : above;
  return above * below > 0 ? std::copysign(std::min(std::abs(above), std::abs(below)), above) : 0.0;
}

Seam worst_line(const Image& image, const Image& truth, bool columns) {
  const auto means = line_means(image, truth, columns);
  Seam seam{columns, 0, 0, 0};
  std::vector<double> steps;
  for (std::size_t line = 0; line < means.size(); ++line) {
    const double step = step_of(means, line);
    if (std::abs(step) > std::abs(seam.step)) seam.position = int(line), seam.step = step;
    steps.push_back(std::abs(step));
  }
  // Only lines with a step: half of them are no extremum and have none.
  std::erase(steps, 0.0);
  double typical = 1e-12;
  if (steps.size() > 1) {
    std::nth_element(steps.begin(), steps.begin() + std::ptrdiff_t(steps.size() / 2), steps.end());
    typical = std::max(typical, 1.4826 * steps[steps.size() / 2]);
  }
  seam.odds = std::abs(seam.step) / typical;
  return seam;
}

/// Bilinear sample of one channel; border pixels are repeated outside.
double sample(const Image& image, double x, double y, int channel) {
  const double fx = std::floor(x), fy = std::floor(y), tx = x - fx, ty = y - fy;
  const auto at = [&](double px, double py) {
    return double(image.pixel(int(std::clamp(px, 0.0, image.width - 1.0)),
                              int(std::clamp(py, 0.0, image.height - 1.0)))[channel]);
  };
  return (1 - ty) * ((1 - tx) * at(fx, fy) + tx * at(fx + 1, fy)) +
         ty * ((1 - tx) * at(fx, fy + 1) + tx * at(fx + 1, fy + 1));
}

/// Sums of the normal equations of Lucas and Kanade for the truth moved by `shift`.
struct NormalEquations {
  double xx = 0, xy = 0, yy = 0, ex = 0, ey = 0;
};
NormalEquations normal_equations(const Image& image, const Image& truth, const Shift& shift) {
  NormalEquations sums;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const double px = x - shift.x, py = y - shift.y;
        // The average of the image's and the truth's gradients, because bilinear resampling smooths only one
        // of them.
        const double gx = 0.25 * (sample(truth, px + 1, py, c) - sample(truth, px - 1, py, c) +
                                  double(image.pixel(x + 1, y)[c]) - double(image.pixel(x - 1, y)[c]));
        const double gy = 0.25 * (sample(truth, px, py + 1, c) - sample(truth, px, py - 1, c) +
                                  double(image.pixel(x, y + 1)[c]) - double(image.pixel(x, y - 1)[c]));
        const double e = sample(truth, px, py, c) - double(image.pixel(x, y)[c]);
        sums.xx += gx * gx;
        sums.xy += gx * gy;
        sums.yy += gy * gy;
        sums.ex += gx * e;
        sums.ey += gy * e;
      }
  return sums;
}

}  // namespace

std::optional<Seam> find_seam(const Image& image, const Image& truth) {
  if (image.width < 8 || image.height < 8) return std::nullopt;
  const Seam column = worst_line(image, truth, true), row = worst_line(image, truth, false);
  return column.odds >= row.odds ? column : row;
}

double brightness_change(const Image& image, const Image& truth) {
  double together = 0, square = 0;
  for (std::size_t at = 0; at < truth.rgba.size(); ++at) {
    together += double(image.rgba[at]) * double(truth.rgba[at]);
    square += double(truth.rgba[at]) * double(truth.rgba[at]);
  }
  return square > 0 ? together / square - 1 : 0.0;
}

Shift find_shift(const Image& image, const Image& truth) {
  Shift shift;
  constexpr int rounds = 8;
  for (int round = 0; round < rounds; ++round) {
    const NormalEquations n = normal_equations(image, truth, shift);
    const double determinant = n.xx * n.yy - n.xy * n.xy, trace = n.xx + n.yy;
    if (!(determinant > 1e-6 * trace * trace)) break;  // no structure, or along one direction only
    shift.x += (n.yy * n.ex - n.xy * n.ey) / determinant;
    shift.y += (n.xx * n.ey - n.xy * n.ex) / determinant;
  }
  return shift;
}

}  // namespace ringsplat::truth
