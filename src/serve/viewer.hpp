#pragma once
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/volume/statistics.hpp"
#include "serve/audience.hpp"
#include "serve/client_message.hpp"
#include "serve/levels.hpp"
#include "serve/picture_maker.hpp"
#include "serve/requests.hpp"
#include "serve/web_server.hpp"
#include "session/director.hpp"

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
  bool patient = false;     ///< the world's axes are a patient's: left, posterior, superior
  std::string unit;         ///< of the spacing; empty: unknown
  bool hounsfield = false;  ///< its values are a CT's
  ValueRange range;
  Histogram histogram;
  std::vector<Label> labels = {};  ///< but 0, ascending; none: the values are no labels
};

struct ViewerOptions {
  std::string version;  ///< of the program
  std::string layout;   ///< "4 GPs + 2 Renderers, ring"
  int ranks = 1;
  ShownVolume volume;                   ///< the first of the series
  std::vector<std::string> frames{""};  ///< names of the series' volumes; one without a series
  SceneState initial;
  std::vector<std::pair<Mode, TransferFunction>> modes;  ///< that can be chosen, each with its first function
  FrameSpec frame;  ///< what all frames have in common, but for what is shown
  Qualities qualities;
  double target_seconds = 0.04;                 ///< for a picture of a view that moves
  int largest_side = 4096;                      ///< of a picture
  std::optional<std::filesystem::path> ffmpeg;  ///< makes movies
  ServerOptions server;
};

/// Shows a volume to pages: takes their views, has frames rendered, and sends them as pictures. Lives on rank
/// 0. The director's functions are called by the thread that renders, all else may be called by any.
class Viewer {
 public:
  /// Binds the port. Throws InputError when it cannot be had.
  explicit Viewer(ViewerOptions options);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  std::string url() const { return server_.url(); }
  /// Of a run of the volume that is shown, the first of the series before loaded(). It lasts until another is
  /// needed, end() or a signal. The viewer must outlive it.
  Director director();
  /// After such a run: the volume to load for the next one; nothing when the viewer has ended.
  std::optional<int> next_volume();
  /// The next run is of this volume.
  void loaded(int volume, const ValueRange& range);
  /// It cannot be loaded: whoever waits for it is told why. loaded() must follow.
  void not_loaded(int volume, const std::string& why);
  /// Shows a warning of the job on all pages, also of those that come later.
  void warn(const std::string& text);
  /// Tells all pages why there will be no more pictures, and ends the run.
  void end(const std::string& message);

 private:
  using Clock = std::chrono::steady_clock;
  struct View {
    ViewMessage message;
    std::uint64_t scene = 0;   ///< the same for views that show the same in the same size
    std::uint64_t number = 0;  ///< its own; pages that come later count their views from 1 again
    Clock::time_point came;
    std::optional<int> shown;  ///< finest level
  };
  struct Rendering {
    std::int64_t frame = 0;
    View view;
    int level = 0;
    bool at_rest = false, refines = false;
  };
  struct LastPicture {
    std::shared_ptr<const std::string> message;
    PictureHead head;
    View view;
  };

  ServerEvents events();
  void opened(ClientId client);
  void received(ClientId client, const std::string& text);
  void closed(ClientId client);
  void handle(ClientId client, ViewMessage&& view);
  void handle(ClientId client, const AckMessage& ack);
  void handle(ClientId client, const DriveMessage& drive);
  void handle(ClientId client, const ProbeMessage& probe);
  void handle(ClientId client, const MapMessage& map);
  void handle(ClientId client, const FileMessage& file);
  void handle(ClientId client, const CancelMessage& cancel);

  std::optional<FrameSpec> next();
  std::optional<FrameSpec> next_picture();
  void take_newest();
  void ask_for(int volume);
  void show_again();
  void take(FrameResult&& result);
  bool unwanted(const FrameSpec& spec);
  void pause(std::chrono::nanoseconds most);

  FrameSpec at(const SceneState& scene, const Level& level) const;
  FrameSpec best_frame(const SceneState& scene) const;
  void send_picture(RenderedPicture& picture, const View& view);
  void send_to_all(LastPicture&& picture);
  void send_last(ClientId client);
  float pictures_a_second();
  void say_driver();
  void say_to_all(const std::string& text);
  void wake();

  const ViewerOptions options_;
  const std::vector<Level> levels_;
  const MessageRules rules_;

  std::mutex mutex_;  ///< guards what follows, up to the requests
  std::condition_variable changed_;
  bool woken_ = false, ended_ = false;
  Audience audience_;
  std::vector<std::string> warnings_;
  std::optional<View> newest_;  ///< not yet taken
  std::uint64_t scenes_ = 0, views_ = 0;
  std::optional<View> current_;
  int shown_volume_ = 0;
  std::optional<int> next_volume_;  ///< that the run ends for
  bool not_yet_seen_ = false;       ///< no frame was drawn of the volume since it was loaded
  std::optional<SceneState> last_put_;
  LevelController controller_;
  std::optional<Rendering> rendering_;
  std::int64_t next_frame_ = 0;
  int pictures_encoding_ = 0;
  std::uint32_t last_number_ = 0;
  std::deque<Clock::time_point> sent_;
  LastPicture last_;

  Requests requests_;  ///< has a lock of its own, taken after that
  WebServer server_;
  PictureMaker maker_;
  boost::asio::thread_pool picture_worker_{1};  ///< never calls MPI; last, as it uses all else
};

}  // namespace ringsplat::serve
