#pragma once
#include <map>
#include <memory>
#include <vector>

#include "app/frame_output.hpp"
#include "app/view_stream.hpp"
#include "session/director.hpp"

namespace ringsplat::app {

/// Which frames are rendered, in which order: each view once, or with --progressive from coarse to fine
/// (Neumann 1992, section 4.4). A refinement is dropped when a newer view has come; a view's first, coarse
/// picture never is.
class Browsing {
 public:
  /// `views` come first, then those of `stream`; null: no others. `frame` holds what all frames have in
  /// common.
  Browsing(const FrameSpec& frame, std::vector<Camera> views, std::unique_ptr<ViewStream> stream,
           bool progressive);

  /// The director of the run. `output` takes finished frames; both arguments must outlive the run.
  Director director(FrameOutput& output, Progress& progress);
  /// Views shown and refinements dropped, for a line at the end; empty when nothing was dropped.
  std::string summary() const;
  /// Throws InputError when some of the stream's lines were no views. Call it when all frames are done.
  void check_stream();

  /// The reductions of a view's pictures, coarse to fine.
  static std::vector<Reduction> levels(const FrameSpec& frame, bool progressive);

 private:
  struct Step {
    std::size_t view;   ///< from 0
    std::size_t level;  ///< into levels_
  };
  struct Shown {
    Reduction reduction;
    Image image;
    std::int64_t frame;
    double seconds;  ///< since the view was first announced
  };

  std::optional<FrameSpec> next();
  void say_whether_waiting(bool frame_comes, Progress& progress);
  std::optional<Camera> next_view();
  bool newer_view_waits();
  bool unwanted(const FrameSpec& spec);
  void take(FrameResult&& result, FrameOutput& output, Progress& progress);
  void compare_with_full(const Step& step, const Image& full, double seconds, FrameOutput& output,
                         Progress& progress);

  FrameSpec frame_;
  std::vector<Reduction> levels_;
  std::vector<Camera> views_;
  std::unique_ptr<ViewStream> stream_;
  std::size_t next_listed_ = 0;  ///< into views_
  std::size_t shown_views_ = 0;
  std::optional<Camera> current_;
  std::size_t next_level_ = 0;
  std::int64_t next_frame_ = 0;
  std::map<std::int64_t, Step> steps_;                ///< by frame, announced and not done
  std::map<std::size_t, double> asked_;               ///< when a view was first announced
  std::map<std::size_t, std::vector<Shown>> coarse_;  ///< a view's pictures so far
  std::size_t dropped_ = 0;
  bool waiting_ = false;  ///< for a view, while no frame is being rendered
};

}  // namespace ringsplat::app
