#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"
#include "record/stats.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/session/session.hpp"
#include "scene/scene.hpp"
#include "session/render.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat {

struct FrameResult {
  FrameSpec spec;
  Image image;
  FrameStats stats;
  Axis axis = Axis::z;  ///< of the slice set that was traversed
};

/// The frame of numbers that are the depths of a frame's picture. Its slices' planes are the same, but rays
/// go on until they are so opaque.
inline FrameSpec depth_frame_of(FrameSpec frame) {
  frame.shown.values = true;
  frame.shown.opaque_threshold =
      std::min(frame.shown.opaque_threshold, 0.5 * (1 - frame.shown.depth.value_or(0.5)));
  if (auto* const sheets = std::get_if<Sheets>(&frame.how)) sheets->layers = 0;
  return frame;
}
/// Gives a picture the depths that its frame of numbers has.
inline void take_depths(Image& picture, const Image& values) {
  picture.depth.resize(values.rgba.size() / 4);
  for (std::size_t k = 0; k < picture.depth.size(); ++k)
    picture.depth[k] = values.rgba[4 * k + 3] > 0 ? values.rgba[4 * k] : INFINITY;
}

/// How a frame becomes part of a picture: added to what there is of it, laid over that, or as the beginning
/// of a picture of its own, in the rows under it.
enum class Joins : std::uint8_t { added, over, below };
/// `rgba`: of premultiplied colours, the same pixels.
inline void lay_over(float* below, const Image::Floats& rgba) {
  for (std::size_t k = 0; k < rgba.size(); ++k) below[k] = rgba[k] + (1 - rgba[k | 3]) * below[k];
}

/// Adds up pictures of several volumes: light and opacity, both at most 1. So volumes do not hide each other.
/// A frame of depths gives them to the picture before it.
class FrameSum {
 public:
  using Take = std::function<void(FrameResult&& sum, std::size_t view)>;

  /// `take` gets a view's sum when its last picture was added.
  explicit FrameSum(Take take) : take_(std::move(take)) {}

  /// Each view's pictures come in the same order, so that sums have the same bits in every run.
  void add(FrameResult&& picture, std::size_t view, bool last, Joins joins = Joins::added) {
    const auto [found, is_first] = sums_.try_emplace(view, std::move(picture));
    if (!is_first) {
      FrameResult& sum = found->second;
      if (picture.spec.shown.values && !sum.spec.shown.values)
        take_depths(sum.image, picture.image);
      else
        add_to(sum.image, picture.image, joins);
      add_to(sum.stats, picture.stats);
    }
    if (last) take_(std::move(sums_.extract(found).mapped()), view);
  }
  /// Nothing more is added of the view.
  void forget(std::size_t view) { sums_.erase(view); }

 private:
  static void add_to(Image& sum, const Image& more, Joins joins) {
    if (joins == Joins::below) {
      sum.height += more.height;
      sum.rgba.resize(sum.rgba.size() + more.rgba.size(), 0.0F);
    }
    float* const rgba = sum.rgba.data() + (sum.rgba.size() - more.rgba.size());
    if (joins == Joins::over) return lay_over(rgba, more.rgba);
    for (std::size_t k = 0; k < more.rgba.size(); ++k) rgba[k] = std::min(rgba[k] + more.rgba[k], 1.0F);
  }
  /// Of one frame after another: each node's slices of one are gone when those of the next are held.
  static void add_to(FrameStats& sum, const FrameStats& more) {
    const auto add = [](std::vector<NodeStats>& nodes, const std::vector<NodeStats>& others) {
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto held = std::max(nodes[k].slice_memory, others[k].slice_memory);
        nodes[k] += others[k];
        nodes[k].slice_memory = held;
      }
    };
    add(sum.gps, more.gps);
    add(sum.renderers, more.renderers);
    for (std::size_t k = 0; k < sum.links.size(); ++k) sum.links[k] += more.links[k];
    sum.seconds += more.period;  // frames may overlap
  }

  Take take_;
  std::map<std::size_t, FrameResult> sums_;  ///< by view
};

/// A frame of one of the volumes that are rendered together.
struct VolumeFrame {
  std::size_t volume = 0;  ///< the scene's own; from 1 its others
  FrameSpec spec;
  Joins joins = Joins::added;
};

/// Supplies frames to render and takes the results; lives on rank 0.
struct Director {
  /// The next frame to render, or nothing when there are no more. `frame` is set by the frame buffer: 0, 1,
  /// 2 …
  std::function<std::optional<FrameSpec>()> next_frame;
  std::function<void(FrameResult&&)> frame_done;
  /// True while next_frame has nothing now and may have something later, as when views arrive during the run.
  /// May be left empty.
  std::function<bool()> may_come = {};
  /// True when an announced frame is no longer wanted: it is dropped and not passed to frame_done.
  std::function<bool(const FrameSpec&)> unwanted = {};
  /// Waits until next_frame may have something, so long at most. May be left empty: it is asked again and
  /// again.
  std::function<void(std::chrono::nanoseconds)> pause = {};
  /// In place of next_frame: the frames whose FrameSum is the next picture, or none when
  /// there are no more. Pictures are counted instead of frames; a picture has the spec of its first frame.
  std::function<std::vector<VolumeFrame>()> next_picture = {};
};

/// The frame as each camera sees it.
inline std::vector<FrameSpec> frames_of(const FrameSpec& frame, const std::vector<Camera>& cameras) {
  std::vector<FrameSpec> frames(cameras.size(), frame);
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k].shown.camera = cameras[k];
  return frames;
}

/// Renders `frames`, one after another.
inline Director director_of(std::vector<FrameSpec> frames, std::function<void(FrameResult&&)> frame_done) {
  const auto next = [frames = std::move(frames), asked = std::size_t{0}]() mutable {
    return asked < frames.size() ? std::optional(frames[asked++]) : std::nullopt;
  };
  return {next, std::move(frame_done)};
}

/// Which slice sets a list of views of the frame traverses.
std::array<bool, 3> needed_axes(FrameSpec frame, const std::vector<Camera>& cameras, const Grid& grid);

/// What has to be loaded for such frames that traverse these axes' slices.
LoadOptions needed_along(const FrameSpec& spec, const std::array<bool, 3>& axes);
/// What has to be loaded for one frame.
LoadOptions needed_to_render(const FrameSpec& spec, const Grid& grid);

/// Throws the InputError with which ranks would refuse to draw a frame of this volume. Costs no voxel.
void check_frame(const FrameSpec& spec, const Grid& grid);

/// Throws InputError when a volume has nothing to show: no finite value.
void check_values(const ValueStatistics& values, const std::string& hint = "check the blocks' values");

Sharing sharing_of(const Layout& layout, const Wiring& wiring);

/// Throws InputError when the layout is none, or is for another number of ranks.
void check_wiring(const Layout& layout, const Wiring& wiring);

/// Throws InputError on all processes, with the name of one that differs, unless all mean the same scene and
/// run the same build. Collective.
void require_same_scene(const Grid& grid, const LoadOptions& options, const Layout& layout,
                        const Wiring& wiring);

/// Deals an opened volume's slices and gathers its range and histogram. All processes call it, with the same
/// grid, options and layout; otherwise all throw the same InputError that names a process that differs.
Scene load_scene(OpenedVolume& volume, const LoadOptions& options, const Layout& layout,
                 const Wiring& wiring);

/// Renders the director's frames of the scene and its others (asked for on process 0 only). All processes
/// call it; returns when the last frame is done. Throws InputError when the layout does not fit the number of
/// processes, RunError when a run fails.
void render_frames(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                   const Wiring& wiring, const EngineOptions& engine = {});

/// Makes the engine of one method.
using MakeEngine = std::function<std::unique_ptr<Engine>(const EngineSetup& setup)>;
/// Makes engines of a class, whose constructor takes `more` besides.
template <class EngineOfMethod, class... More>
MakeEngine maker_of(More... more) {
  return [=](const EngineSetup& setup) { return std::make_unique<EngineOfMethod>(setup, more...); };
}

/// The engines of one rank, each made on first use, whose steps are the setup's bundles. `methods`: in the
/// order of Method's alternatives.
std::unique_ptr<Engine> make_engines(EngineSetup setup, std::vector<MakeEngine> methods);
/// The same of engines that draw.
std::unique_ptr<Engine> make_rank_engine(EngineSetup setup);

/// What a session can do for other rooms that is not for users.
struct SessionParts {
  /// Has the session's next collective call throw this as InputError on all ranks.
  static void note_problem(Session& session, const std::string& problem);
  /// Of the committed volume, until the next commit. Collective; `call` is its name for people.
  static const ValueStatistics& values(Session& session, const char* call = "values");
  /// As Session::render(), with all that is known of each frame.
  static void render(Session& session, const std::vector<FrameSpec>& frames,
                     const std::function<void(FrameResult&&)>& take);
  /// Renders frames of the committed volume as rank 0's director gives them; they need no more than `needed`,
  /// the same on all ranks. Collective.
  static void direct(Session& session, const LoadOptions& needed, Director director);
  /// For what ranks agree on between the session's calls: all, or where some are set aside these, or the
  /// others.
  static Collectives& collectives(Session& session);
  static Processes& all(Session& session);
  /// False where others are set aside for it.
  static bool draws(const Session& session);
  /// Of the committed volume. Throws InputError when there is none.
  static const Grid& grid(const Session& session);
};

}  // namespace ringsplat
