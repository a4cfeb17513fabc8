#include "serve/levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ringsplat::serve {
namespace {

/// Shares of the target: a finer level is taken when it is expected to take less than the first, and left
/// when it takes more than the second.
constexpr double clearly_fits = 0.9, still_fits = 1.1;
/// Machines differ; the first picture of all is rather too coarse than late.
const double first_guess = std::log(2.0);
/// How much of an error is put down to what all levels have in common, and how much to the level.
constexpr double common_share = 0.5, own_share = 0.3;
/// Anything may hold a single picture up: a larger error, a factor of 1.5, counts when it comes again.
const double doubtful = std::log(1.5);
/// What a level was found to be dearer or cheaper than thought is forgotten by this share with each picture
/// of other levels, so that none is given up for ever.
constexpr double forgotten = 0.005;

Level part(const char* quality, int undersample, double scale, const Sheets& sheets) {
  std::string name = quality;
  if (undersample > 1) name += fmt::format(", 1/{} of the voxels", undersample);
  if (scale < 1) name += fmt::format(", {:.0f} % of the size", 100 * scale);
  return {name, undersample, scale, sheets};
}

}  // namespace

std::vector<Level> make_levels(const Qualities& q, const glm::ivec3& dims) {
  constexpr int least_voxels = 16;  // along an undersampled volume's shortest side
  const int shortest = std::min({dims.x, dims.y, dims.z});
  std::vector<Level> levels;
  for (const int factor : {4, 2, 1}) {
    if (factor > 1 && shortest / factor < least_voxels) continue;
    for (const double scale : {0.5, 0.7, 1.0}) levels.push_back(part("draft", factor, scale, q.draft));
    levels.push_back(part("normal", factor, 1, q.normal));
    for (const double scale : {0.6, 0.7, 0.85, 1.0}) levels.push_back(part("best", factor, scale, q.best));
  }
  return levels;
}

FrameSpec at_level(FrameSpec spec, const Level& level) {
  spec.how = level.sheets;
  spec.shown.reduction.factor = level.undersample;
  const auto scaled = [&](int side) { return static_cast<int>(std::ceil(level.scale * side)); };
  spec.shown.width = scaled(spec.shown.width);
  spec.shown.height = scaled(spec.shown.height);
  return spec;
}

double rough_seconds(const FrameSpec& spec, const glm::ivec3& dims) {
  constexpr double voxel = 1.3e-9, sample = 0.4e-9, pixel = 4e-9;
  const Sheets& how = spec.as<Sheets>();
  const glm::dvec3 level = glm::dvec3(dims) / double(spec.shown.reduction.factor);
  const double voxels = level.x * level.y * level.z, slices = std::cbrt(voxels);
  const double pixels = double(spec.shown.width) * spec.shown.height;
  const double in_plane = how.image_plane == ImagePlane::screen
                              ? pixels
                              : std::min(pixels, how.plane_samples * how.plane_samples * voxels / slices);
  return voxel * voxels + sample * std::sqrt(how.slabs * how.light_points) * slices * in_plane +
         pixel * pixels;
}

LevelController::LevelController(double target_seconds) : target_(target_seconds) {}

void LevelController::expect(std::vector<double> rough_seconds) {
  rough_ = std::move(rough_seconds);
  own_.resize(rough_.size());
}

double LevelController::expected(int level) const {
  const auto k = std::size_t(level);
  return rough_[k] * std::exp(common_.value_or(first_guess) + own_[k].factor);
}

void LevelController::took(int level, double seconds) {
  const double error = std::log(std::max(seconds, 1e-6) / expected(level));
  Own& its = own_[std::size_t(level)];
  const bool again = error * last_error_ > 0 && std::abs(last_error_) > doubtful;
  last_error_ = error;
  if (!common_) {
    common_ = first_guess + error;
  } else if (again || !its.drawn || std::abs(error) <= doubtful) {
    for (Own& own : own_) own.factor *= 1 - forgotten;
    *common_ += common_share * error;
    its.factor += (its.drawn ? own_share : 1 - common_share) * error;
  }
  its.drawn = true;
}

int LevelController::level() {
  int finest = 0;
  for (int k = 0; k < levels(); ++k) {
    if (expected(k) <= (k == level_ ? still_fits : clearly_fits) * target_) finest = k;
  }
  level_ = finest;
  return finest;
}

std::optional<int> next_level_at_rest(LevelController& controller, std::optional<int> shown) {
  constexpr double soon = 1.5, long_wait = 4, much_sooner = 0.35;
  const int best = controller.levels() - 1;
  if (shown == best) return std::nullopt;
  const double cost = controller.expected(best);
  if (!shown) return cost <= soon * controller.target() ? best : controller.level();
  if (cost > long_wait * controller.target())
    for (int middle = best - 1; middle > *shown; --middle)
      if (controller.expected(middle) <= much_sooner * cost) return middle;
  return best;
}

}  // namespace ringsplat::serve
