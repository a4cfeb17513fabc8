#pragma once
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::serve {

/// One way to draw a view, cheap and coarse or dear and fine.
struct Level {
  std::string name;
  int undersample = 1;
  double scale = 1;  ///< of the picture's sides
  Sheets sheets;
};

/// The program's settings of --quality, which levels are made of.
struct Qualities {
  Sheets draft, normal, best;
};

/// From coarse to fine; the last is `best` and nothing less. Small volumes are not undersampled.
std::vector<Level> make_levels(const Qualities& qualities, const glm::ivec3& dims);

/// The frame that shows a view at a level. `full` has the view at its whole size. In perspective there is no
/// image in the slices' plane, so those levels draw on the screen.
FrameSpec at_level(FrameSpec full, const Level& level);

/// About the seconds that a frame takes one core: a term for voxels, one for samples, one for pixels. What a
/// machine, a transfer function and a number of ranks make of it is learnt; levels are as this to each other.
double rough_seconds(const FrameSpec& spec, const glm::ivec3& dims);

/// Chooses the level for pictures of a view that moves: the finest that is expected to take no longer than
/// the target. Each picture's time tells of its own level, and in part of all others. Knows no clock.
class LevelController {
 public:
  explicit LevelController(double target_seconds);

  /// By level, what the present view's pictures roughly cost. Call it first of all.
  void expect(std::vector<double> rough_seconds);
  /// A picture took so long.
  void took(int level, double seconds);
  /// For the next picture of a view that moves. It is left for a finer one only where that clearly fits.
  int level();
  /// Seconds that a picture is expected to take.
  double expected(int level) const;
  double target() const { return target_; }
  int levels() const { return int(rough_.size()); }

 private:
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

/// The level of a view's next picture when it rests; nothing when it has been shown as well as can be.
/// `shown`: the finest that was shown of it. There are at most three: as for a moving view, a middle one when
/// the best takes long, the best.
std::optional<int> next_level_at_rest(LevelController& controller, std::optional<int> shown);

}  // namespace ringsplat::serve
