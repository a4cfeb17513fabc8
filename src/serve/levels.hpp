#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/quality.hpp"

namespace ringsplat::serve {

/// One way to draw a view, cheap and coarse or dear and fine.
struct Level {
  std::string name;
  int undersample = 1;
  double scale = 1;  ///< of the picture's sides
  Sheets sheets;
};

/// From coarse to fine, of the program's qualities; the last is the best and nothing less. Small volumes are
/// not undersampled.
inline std::vector<Level> make_levels(const glm::ivec3& dims) {
  constexpr int least_voxels = 16;  // along an undersampled volume's shortest side
  const int shortest = std::min({dims.x, dims.y, dims.z});
  std::vector<Level> levels;
  const auto add = [&](Quality quality, int factor, double scale) {
    std::string words = name(quality);
    if (factor > 1) words += fmt::format(", 1/{} of the voxels", factor);
    if (scale < 1) words += fmt::format(", {:.0f} % of the size", 100 * scale);
    levels.push_back({words, factor, scale, sheets_of(quality)});
  };
  for (const int factor : {4, 2, 1}) {
    if (factor > 1 && shortest / factor < least_voxels) continue;
    for (const double scale : {0.5, 0.7, 1.0}) add(Quality::draft, factor, scale);
    add(Quality::normal, factor, 1);
    for (const double scale : {0.6, 0.7, 0.85, 1.0}) add(Quality::best, factor, scale);
  }
  return levels;
}

/// The frame that shows a view at a level. `full` has the view at its whole size. In perspective there is no
/// image in the slices' plane, so those levels draw on the screen.
inline FrameSpec at_level(FrameSpec full, const Level& level) {
  full.how = level.sheets;
  full.shown.reduction.factor = level.undersample;
  const auto scaled = [&](int side) { return static_cast<int>(std::ceil(level.scale * side)); };
  full.shown.width = scaled(full.shown.width);
  full.shown.height = scaled(full.shown.height);
  return full;
}

/// About the seconds that a frame takes one core: a term for voxels, one for samples, one for pixels. What a
/// machine, a transfer function and a number of ranks make of it is learnt; levels are as this to each other.
inline double rough_seconds(const FrameSpec& spec, const glm::ivec3& dims) {
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

/// Chooses the level for pictures of a view that moves: the finest that is expected to take no longer than
/// the target. Each picture's time tells of its own level, and in part of all others. Knows no clock.
class LevelController {
 public:
  explicit LevelController(double target_seconds) : target_(target_seconds) {}

  /// By level, what the present view's pictures roughly cost; infinite: not to be drawn. Call it first.
  void expect(std::vector<double> rough_seconds) {
    rough_ = std::move(rough_seconds);
    own_.resize(rough_.size());
  }
  void took(int level, double seconds) {
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
  /// For the next picture of a view that moves. It is left for a finer one only where that clearly fits.
  int level() {
    int finest = int(std::min_element(rough_.begin(), rough_.end()) - rough_.begin());
    for (int k = 0; k < levels(); ++k)
      if (expected(k) <= (k == level_ ? still_fits : clearly_fits) * target_) finest = k;
    level_ = finest;
    return finest;
  }
  /// The level of a view's next picture when it rests; nothing when it has been shown as well as can be.
  /// `shown`: the finest that was shown of it. There are at most three: as for a moving view, a middle one
  /// when the best takes long, the best.
  std::optional<int> level_at_rest(std::optional<int> shown) {
    constexpr double soon = 1.5, long_wait = 4, much_sooner = 0.35;
    const int best = levels() - 1;
    if (shown == best) return std::nullopt;
    const double cost = expected(best);
    if (!shown) return cost <= soon * target_ ? best : level();
    if (cost > long_wait * target_)
      for (int middle = best - 1; middle > *shown; --middle)
        if (expected(middle) <= much_sooner * cost) return middle;
    return best;
  }
  double expected(int level) const {
    const auto k = std::size_t(level);
    return rough_[k] * std::exp(common_.value_or(first_guess) + own_[k].factor);
  }
  int levels() const { return int(rough_.size()); }

 private:
  /// Shares of the target: a finer level is taken when it is expected to take less than the first, and left
  /// when it takes more than the second.
  static constexpr double clearly_fits = 0.9, still_fits = 1.1;
  /// Machines differ; the first picture of all is rather too coarse than late.
  inline static const double first_guess = std::log(2.0);
  /// How much of an error is put down to what all levels have in common, and how much to the level.
  static constexpr double common_share = 0.5, own_share = 0.3;
  /// Anything may hold a single picture up: a larger error, a factor of 1.5, counts when it comes again.
  inline static const double doubtful = std::log(1.5);
  /// What a level was found to be dearer or cheaper than thought is forgotten by this share with each picture
  /// of other levels, so that none is given up for ever.
  static constexpr double forgotten = 0.005;

  /// True over rough seconds, as logarithms; a level's own comes on top of what all have in common.
  struct Own {
    double factor = 0;
    bool drawn = false;
  };

  double target_;
  std::vector<double> rough_;
  std::vector<Own> own_;
  std::optional<double> common_;  ///< nothing before the first picture
  double last_error_ = 0;
  std::optional<int> level_;
};

}  // namespace ringsplat::serve
