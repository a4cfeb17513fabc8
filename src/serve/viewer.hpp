#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/child_program.hpp"
#include "classify/adjust.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "serve/client_message.hpp"
#include "serve/levels.hpp"
#include "serve/web_server.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {

/// A value that is the number of something.
struct Label {
  double value;
  std::string name;  ///< empty: the file has none
};

/// What a page is told of the volume and the job.
struct ShownVolume {
  std::string name;
  Grid grid;
  bool patient = false;            ///< the world's axes are a patient's: left, posterior, superior
  std::string unit;                ///< of the spacing; empty: unknown
  bool hounsfield = false;         ///< its values are a CT's
  std::vector<ValueRange> ranges;  ///< of the channels, of one without them
  Histogram histogram;             ///< of the first
  std::vector<Label> labels = {};  ///< but 0, ascending; none: the values are no labels
};

/// A channel that is drawn with others.
struct ShownChannel {
  std::string name;
  std::map<Mode, Shown> own = {};  ///< the function that it has in each mode, in white, and what goes with it

  /// As that of ChannelState.
  glm::dvec2 window(Mode mode) const {
    const DataRange ends = ends_of(own.at(mode).transfer_function);
    return mode == Mode::surface ? glm::dvec2(own.at(mode).isovalue) : glm::dvec2(ends.low, ends.high);
  }
};

/// The volumes of a series that ranks hold: one, or two that are compared.
struct HeldVolumes {
  std::vector<int> volumes;
  std::vector<ValueRange> ranges;        ///< of each channel of the first, then of the second
  std::optional<Reduction> coarse = {};  ///< set: of the only one there are levels alone, made like that

  bool hold(int volume) const { return std::ranges::find(volumes, volume) != volumes.end(); }
  /// Where the ranks have a held volume's first channel.
  std::size_t first_of(int volume) const {
    return volume == volumes.front() ? 0 : ranges.size() / volumes.size();
  }
  /// What draws this one instead of the first.
  std::vector<VolumeFrame> frames_of(int volume, std::vector<VolumeFrame> frames) const {
    for (VolumeFrame& frame : frames) frame.volume += first_of(volume);
    return frames;
  }
};

/// The side of the largest picture whose floats leave room for the rest of this machine's memory.
int largest_side();

/// What a picture errs, as a picture and in words.
struct ProvedErrors {
  std::string words;
  TransferFunction colours;  ///< what the map's mean, in 1/255
  Bytes map;                 ///< a PNG of the picture's size
};

/// What pages want in place of the volume, or of the part of it, that they see.
struct NextPart {
  std::optional<VoxelBox> box;  ///< of that volume's voxels; none: all of it, as it was first
  SceneState scene;             ///< that was seen
  Grid grid = {};               ///< of that volume
  ServerOptions server;         ///< where pages look for it
  int number = 0;               ///< how many there were before it
};

struct ViewerOptions {
  std::string layout;  ///< "4 GPs + 2 Renderers, ring"
  int ranks = 1;
  ShownVolume volume;                   ///< the first of the series
  std::vector<std::string> frames{""};  ///< names of the series' volumes; one without a series
  SceneState initial;
  std::vector<std::pair<Mode, TransferFunction>> modes;  ///< that can be chosen, each with its first function
  std::vector<ShownChannel> channels;                    ///< as many as `initial` has
  bool finer = false;  ///< more voxels of a part could be held than of the whole
  int part = 0;        ///< NextPart::number; 0: of the whole volume
  bool is_part = false;
  std::vector<Label> segments;               ///< of a segmentation over the volume, as `initial` tints them
  FrameSpec frame;                           ///< what all frames have in common, but for what is shown
  double target_seconds = 0.04;              ///< for a picture of a view that moves
  int largest_side = serve::largest_side();  ///< of a picture
  std::optional<std::filesystem::path> ffmpeg = find_program("ffmpeg");  ///< makes movies
  ServerOptions server;
  /// Takes what the driver wants of the simulation, on the server's thread; throws InputError for the page.
  /// Empty: there is none.
  std::function<void(const SteerMessage&)> steer = {};
  /// What a picture of a volume of the series errs, on a thread of its own; throws InputError for the page,
  /// and what `go_on` throws, which it calls now and then. Empty: that is not known.
  std::function<ProvedErrors(const FrameResult& picture, int volume, const std::function<void()>& go_on)>
      errors = {};
};

/// How far a simulation is.
struct RunState {
  struct Parameter {
    std::string name;
    double value, low, high;
    std::vector<std::string> choices = {};  ///< what whole values mean; of numbers empty
  };
  std::int64_t step = 0;
  double time = 0;  ///< the simulation's own
  double steps_a_second = 0;
  bool paused = false;
  Histogram histogram;                ///< of the values that are shown
  std::vector<Parameter> parameters;  ///< that pages may set
};

/// Shows a volume to pages: takes their views, has frames rendered, and sends them as pictures. Lives on rank
/// 0. The director's functions are called by the thread that renders, all else may be called by any.
class Viewer {
 public:
  virtual ~Viewer() = default;
  virtual std::string url() const = 0;
  /// Of a run of the volumes that are held, the first of the series before loaded(). It lasts until others
  /// are needed, end() or a signal. The viewer must outlive it.
  virtual Director director() = 0;
  /// After such a run: the volumes to load for the next one; none when the viewer has ended.
  virtual std::vector<int> next_volumes() = 0;
  /// The next run is of these volumes.
  virtual void loaded(const HeldVolumes& held) = 0;
  /// It cannot be loaded: whoever waits for it is told why. loaded() must follow.
  virtual void not_loaded(int volume, const std::string& why) = 0;
  /// The volume has other values from the next run on: what was drawn of it is out of date. `changes`: it
  /// soon has others again, so that all views are drawn as those that move.
  virtual void renewed(const ValueRange& range, bool changes) = 0;
  /// Sends a text to all pages, and to those that come until the next.
  virtual void tell(const std::string& text) = 0;
  virtual bool has_pages() = 0;
  /// The page that drives has seen no picture yet.
  virtual bool has_newcomer() = 0;
  /// Somebody waits for something else than a view.
  virtual bool has_requests() = 0;
  /// Shows a warning of the job on all pages, also of those that come later.
  virtual void warn(const std::string& text) = 0;
  /// After the viewer has ended: what it has ended for, if pages want something else.
  virtual std::optional<NextPart> next_part() = 0;
  /// Tells all pages why there will be no more pictures, and ends the run.
  virtual void end(const std::string& message) = 0;
};

/// Binds the port. Throws InputError when it cannot be had.
std::unique_ptr<Viewer> make_viewer(ViewerOptions options);

// For who makes the options.

/// What all levels of all views of the frame need.
LoadOptions needed_for_levels(const FrameSpec& frame, const Grid& grid);

/// Sets the modes that a page offers, each with its first function; `usual` is that of light. Where values
/// between voxels mean nothing there is one mode only.
void set_modes(const TransferFunction& usual, const ValueStatistics& values, ViewerOptions& options);

/// The voxels that the scene's picture shows, of its clip box. Throws InputError when there are none.
VoxelBox seen_box(const SceneState& scene, const Grid& grid);

std::string hello_text(const ViewerOptions& options, const std::vector<Level>& levels, bool drives,
                       int viewers);
/// What becomes of a frame of a series: "loading", "shown" from now on, or "failed".
std::string frame_text(int frame, std::string_view status);
std::string run_text(const RunState& run);
/// Which part of a volume is loaded, 0 ... 1, of which coarse data is shown meanwhile.
std::string loading_text(double part);
/// `what`: an error's text, "WHAT IS WRONG; hint: WHAT TO DO". `id`: of the message that it answers.
std::string error_text(std::string_view what, std::optional<std::uint32_t> id = std::nullopt);
/// `what`: as of an error.
std::string warning_text(std::string_view what);

}  // namespace ringsplat::serve
