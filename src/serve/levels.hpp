#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::serve {

/// One way to draw a view, cheap and coarse or dear and fine.
struct Level {
  std::string name;
  int undersample = 1;
  bool half_size = false;
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

/// Chooses the level for pictures of a view that moves: coarser when two in a row take longer than 1.2 times
/// the target, finer when ten in a row take less than 0.7 times, but not to a level that lately took longer
/// than the target. Knows no clock.
class LevelController {
 public:
  LevelController(int levels, double target_seconds);

  /// For the next picture of a view that moves.
  int level() const { return level_; }
  /// A picture of a moving view took so long.
  void moved(double seconds);
  /// A picture of a view at rest took so long at that level.
  void rested(int level, double seconds);
  /// A view begins to move: starts as fine as was lately quick enough.
  void begin_motion();
  /// Pictures will cost something else now, as another size does.
  void forget();
  /// Seconds that a level took lately.
  std::optional<double> recent(int level) const;

 private:
  struct Cost {
    double seconds;
    long at;  ///< in pictures
  };
  bool may_fit(int level) const;

  double target_;
  int level_ = 0, slow_ = 0, quick_ = 0;
  long pictures_ = 0;
  std::vector<std::optional<Cost>> costs_;
};

/// The level of a view's next picture when it rests; nothing when it has been shown as well as can be.
/// `shown`: the finest that was shown of it. There are at most three: as for a moving view, a middle one when
/// the best takes long, the best.
std::optional<int> next_level_at_rest(const LevelController& controller, int levels, double target_seconds,
                                      std::optional<int> shown);

}  // namespace ringsplat::serve
