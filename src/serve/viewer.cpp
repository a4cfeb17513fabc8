#include "serve/viewer.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <mutex>
#include <utility>

#include "base/log.hpp"
#include "classify/srgb.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/audience.hpp"
#include "serve/picture_maker.hpp"
#include "serve/requests.hpp"
#include "serve/scene_frames.hpp"

namespace ringsplat::serve {
namespace {

using namespace std::chrono_literals;

constexpr auto rest_begins = 150ms;

class PageViewer final : public Viewer {
 public:
  explicit PageViewer(ViewerOptions options)
      : options_(std::move(options)),
        levels_(make_levels(options_.volume.grid.dims)),
        rules_{options_.initial, options_.volume.grid, options_.volume.patient, int(options_.frames.size()),
               options_.largest_side},
        audience_({[this](ClientId client, std::string text) { server_.send_text(client, std::move(text)); },
                   [this](ClientId client, std::shared_ptr<const std::string> bytes) {
                     server_.send_binary(client, std::move(bytes));
                   }}),
        controller_(options_.target_seconds),
        requests_(
            server_,
            [this] {
              const std::lock_guard lock(mutex_);
              wake();
            },
            options_.volume.grid, options_.volume.ranges, int(levels_.size()), options_.ffmpeg),
        server_(options_.server, events()),
        maker_(int(levels_.size())) {
    server_.start();
  }

  /// Requests send their answers by the server, which calls them.
  ~PageViewer() override { requests_.stop(); }
  PageViewer(const PageViewer&) = delete;
  PageViewer& operator=(const PageViewer&) = delete;

  std::string url() const override { return server_.url(); }
  Director director() override {
    const std::lock_guard lock(mutex_);
    next_frame_ = 0;
    rendering_.reset();  // of a run that failed
    return {.next_frame = {},
            .frame_done = [this](FrameResult&& result) { take(std::move(result)); },
            .may_come =
                [this] {
                  const std::lock_guard lock(mutex_);
                  return !ended_ && !next_volume_;
                },
            .unwanted = [this](const FrameSpec& spec) { return unwanted(spec); },
            .pause = [this](std::chrono::nanoseconds most) { pause(most); },
            .next_picture = [this] { return next(); }};
  }

  std::optional<int> next_volume() override {
    const std::lock_guard lock(mutex_);
    return ended_ ? std::nullopt : next_volume_;
  }

  void loaded(int volume, const std::vector<ValueRange>& ranges) override {
    requests_.show(volume, ranges);
    const std::lock_guard lock(mutex_);
    next_volume_.reset();
    shown_volume_ = volume;
    not_yet_seen_ = true;
    audience_.say(frame_text(volume, "shown"));
  }

  void not_loaded(int volume, const std::string& why) override {
    requests_.refuse_volume(volume, why);
    const std::lock_guard lock(mutex_);
    if (newest_ && newest_->message.scene.frame == volume) newest_.reset();
    if (current_ && current_->message.scene.frame == volume) current_.reset();
    audience_.say(frame_text(volume, "failed"));
    audience_.say(error_text(why, {}));
  }

  void renewed(const ValueRange& range, bool changes) override {
    requests_.show(0, {range});
    const std::lock_guard lock(mutex_);
    changes_ = changes;
    if (current_) current_->shown.reset();
  }

  void tell(const std::string& text) override {
    const std::lock_guard lock(mutex_);
    told_ = text;
    audience_.say(text);
  }

  bool has_pages() override {
    const std::lock_guard lock(mutex_);
    return audience_.size() > 0;
  }

  bool has_requests() override { return requests_.any(); }

  void warn(const std::string& text) override {
    constexpr std::size_t most = 20;
    const std::lock_guard lock(mutex_);
    if (warnings_.size() >= most) return;
    warnings_.push_back(warning_text(text));
    audience_.say(warnings_.back());
  }

  void end(const std::string& message) override {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(ended_, true)) return;
      wake();
    }
    requests_.end();
    server_.end(end_text(message));
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Frames = std::vector<VolumeFrame>;
  struct View {
    ViewMessage message;
    std::uint64_t scene = 0;   ///< the same for views that show the same in the same size
    Clock::time_point came;    ///< its own
    std::optional<int> shown;  ///< finest level
  };
  struct Rendering {
    std::int64_t frame = 0;
    View view;
    int level = 0;
    bool at_rest = false, refines = false;
  };

  ServerEvents events() {
    return {
        .opened = [this](ClientId client) { opened(client); },
        .received = [this](ClientId client, std::string&& text) { received(client, text); },
        .refused =
            [this](ClientId client) { server_.send_text(client, error_text("messages must be texts", {})); },
        .closed = [this](ClientId client) { closed(client); },
        .signalled = [this](int number) { end(ended_by_signal_text(number)); }};
  }

  void opened(ClientId client) {
    const std::lock_guard lock(mutex_);
    audience_.add(client);
    server_.send_text(client, hello_text(options_, levels_, audience_.drives(client), audience_.size()));
    for (const std::string& warning : warnings_) server_.send_text(client, warning);
    if (!told_.empty()) server_.send_text(client, told_);
    audience_.say_who_drives();
    if (!audience_.drives(client)) audience_.catch_up(client);
    wake();
  }

  void received(ClientId client, const std::string& text) {
    try {
      std::visit([&](auto&& message) { handle(client, std::move(message)); },
                 parse_client_message(text, rules_));
    } catch (const std::exception& e) {
      const std::optional<Request> request = request_of(text);
      if (request && request->type == "movie_frame") requests_.cancel_movie(client, request->id);
      server_.send_text(client, error_text(e.what(), request));
    }
    const std::lock_guard lock(mutex_);
    wake();
  }

  void closed(ClientId client) {
    const std::lock_guard lock(mutex_);
    audience_.remove(client);
    requests_.forget(client);
    audience_.say_who_drives();
    wake();
  }

  void handle(ClientId client, ViewMessage&& view) {
    for (const Level& level : levels_)
      check_frame(frames_of(view.scene, level, options_).front().spec, options_.volume.grid);
    const std::lock_guard lock(mutex_);
    if (!audience_.drives(client)) return;
    if (!last_put_ || *last_put_ != view.scene) ++scenes_;
    last_put_ = view.scene;
    newest_ = View{std::move(view), scenes_, Clock::now(), {}};
  }

  void handle(ClientId client, const AckMessage& ack) {
    const std::lock_guard lock(mutex_);
    audience_.acknowledge(client, ack.picture);
  }

  void handle(ClientId client, const DriveMessage&) {
    const std::lock_guard lock(mutex_);
    if (audience_.drives(client)) return;
    audience_.drive(client);
    audience_.say_who_drives();
  }

  void handle(ClientId client, const ProbeMessage& asked) {
    const std::lock_guard lock(mutex_);
    if (asked.scene)
      return requests_.add(client, asked, best_frames(*asked.scene).front(), asked.scene->frame);
    if (!last_put_ || asked.x >= last_put_->shown.width || asked.y >= last_put_->shown.height)
      throw InputError("there is no such pixel in the last view");
    requests_.add(client, asked, best_frames(*last_put_).front(), last_put_->frame);
  }

  void handle(ClientId client, const MapMessage& map) { server_.send_text(client, map_text(map)); }

  void handle(ClientId client, const FileMessage& asked) {
    requests_.add(client, asked, best_frames(asked.scene));
  }

  void handle(ClientId client, const CancelMessage& asked) { requests_.cancel_movie(client, asked.id); }

  void handle(ClientId client, const SteerMessage& wanted) {
    if (!options_.steer) throw InputError("there is no simulation to steer");
    {
      const std::lock_guard lock(mutex_);
      if (!audience_.drives(client)) return;
    }
    options_.steer(wanted);
  }

  Frames next() {
    const std::lock_guard lock(mutex_);
    if (ended_ || next_volume_) return {};
    Frames frames = next_picture();
    if (frames.empty() && !next_volume_) {
      frames = requests_.next(next_frame_);
      const auto volume = frames.empty() ? requests_.wanted_volume() : std::nullopt;
      if (volume) ask_for(*volume);
    }
    if (!frames.empty()) ++next_frame_;
    return frames;
  }

  Frames next_picture() {
    if (audience_.size() == 0) return {};
    if (rendering_ || pictures_encoding_ + audience_.unacknowledged() >= Audience::most_unacknowledged)
      return {};
    take_newest();
    if (!current_) return {};
    View& view = *current_;
    const bool rests = !changes_ && (!view.message.moving || Clock::now() - view.came >= rest_begins);
    std::optional<int> level;
    if (rests)
      level = controller_.level_at_rest(view.shown);
    else if (!view.shown)
      level = controller_.level();
    if (!level) {
      if (rests) show_again();
      return {};
    }
    if (view.message.scene.frame != shown_volume_) {
      ask_for(view.message.scene.frame);
      return {};
    }
    not_yet_seen_ = false;
    rendering_ = {next_frame_, view, *level, rests, view.shown.has_value()};
    return frames_of(view.message.scene, levels_[std::size_t(*level)], options_);
  }

  /// While a series is gone through quickly only the newest view's volume is loaded, but one picture is drawn
  /// of each that was.
  void take_newest() {
    if (!newest_) return;
    const bool loaded_for_current =
        not_yet_seen_ && current_ && !current_->shown && current_->message.scene.frame == shown_volume_;
    if (loaded_for_current && newest_->message.scene.frame != shown_volume_) return;
    View view = *std::exchange(newest_, std::nullopt);
    if (current_ && current_->scene == view.scene) view.shown = current_->shown;
    current_ = std::move(view);
    std::vector<double> costs;
    for (const Level& level : levels_) {
      const Frames frames = frames_of(current_->message.scene, level, options_);
      // To reduce a volume for a single picture takes longer than to draw it.
      const double one = changes_ && level.undersample > 1
                             ? std::numeric_limits<double>::infinity()
                             : rough_seconds(frames.front().spec, options_.volume.grid.dims);
      costs.push_back(double(frames.size()) * one);
    }
    controller_.expect(std::move(costs));
  }

  /// The mutex is held.
  void ask_for(int volume) {
    next_volume_ = volume;
    audience_.say(frame_text(volume, "loading"));
  }

  /// For a view that shows what the last picture shows: the page waits for one with the view's number.
  void show_again() {
    if (pictures_encoding_ > 0 || !audience_.last() || audience_.last()->scene != current_->scene ||
        shown_view_ == current_->came)
      return;
    SentPicture again = *audience_.last();
    again.head.seq = current_->message.seq;
    again.head.time = current_->message.time;
    shown_view_ = current_->came;
    audience_.show(std::move(again));
  }

  void take(FrameResult&& result) {
    if (requests_.renders(result.spec.frame)) {
      requests_.take(std::move(result));
      return;
    }
    const std::lock_guard lock(mutex_);
    // unwanted() may have dropped it when it was already complete.
    if (!rendering_ || rendering_->frame != result.spec.frame) return;
    const Rendering rendering = *std::exchange(rendering_, std::nullopt);
    ++pictures_encoding_;
    const ViewMessage& view = rendering.view.message;
    const int levels = int(levels_.size());
    // What is drawn at best while the view moves is sent with less quality, and once more when it rests.
    const bool at_rest = rendering.at_rest && rendering.level + 1 == levels;
    if (current_ && current_->scene == rendering.view.scene)
      current_->shown = at_rest ? rendering.level : std::min(rendering.level, levels - 2);
    auto picture = std::make_shared<RenderedPicture>();
    picture->image = std::move(result.image);
    picture->background = srgb_to_linear(view.scene.background);
    picture->moving = !rendering.at_rest;
    picture->scene = rendering.view.scene;
    picture->head = {.seq = view.seq,
                     .level = std::uint8_t(rendering.level),
                     .levels = std::uint8_t(levels),
                     .at_rest = at_rest,
                     .seconds = static_cast<float>(result.stats.seconds),
                     .time = view.time};
    post(picture_worker_,
         [this, picture, rendering, drawn = Clock::now()] { send_picture(*picture, rendering, drawn); });
  }

  bool unwanted(const FrameSpec& spec) {
    if (requests_.unwanted(spec.frame)) return true;
    const std::lock_guard lock(mutex_);
    if (!rendering_ || rendering_->frame != spec.frame) return false;
    const bool newer = newest_ && newest_->scene != rendering_->view.scene;
    if (!ended_ && audience_.size() > 0 && !(rendering_->refines && newer)) return false;
    rendering_.reset();
    return true;
  }

  void pause(std::chrono::nanoseconds most) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, most, [this] { return woken_; });
    woken_ = false;
  }

  /// Of a file that a page asks for. An error in a frame that is announced would end the job.
  Frames best_frames(const SceneState& scene) const {
    Frames best = frames_of(scene, levels_.back(), options_);
    check_frame(best.front().spec, options_.volume.grid);
    return best;
  }

  void send_picture(RenderedPicture& picture, const Rendering& rendering, Clock::time_point drawn) {
    std::string message;
    try {
      message = maker_.make(picture);
    } catch (const std::exception& e) {
      log_error("the viewer: {}", e.what());
    }
    {
      const std::lock_guard lock(mutex_);
      --pictures_encoding_;
      const View& view = rendering.view;
      if (!message.empty()) {
        shown_view_ = view.came;
        audience_.show({std::make_shared<const std::string>(std::move(message)), picture.head,
                        view.message.scene, view.scene});
      }
      const std::chrono::duration<double> to_send = Clock::now() - drawn;
      controller_.took(rendering.level, double(picture.head.seconds) + to_send.count());
      wake();
    }
    maker_.learn(picture);
  }

  /// The mutex is held.
  void wake() {
    woken_ = true;
    changed_.notify_all();
  }

  const ViewerOptions options_;
  const std::vector<Level> levels_;
  const MessageRules rules_;

  std::mutex mutex_;  ///< guards what follows, up to the requests
  std::condition_variable changed_;
  bool woken_ = false, ended_ = false;
  Audience audience_;
  std::vector<std::string> warnings_;
  std::string told_;            ///< last
  std::optional<View> newest_;  ///< not yet taken
  std::uint64_t scenes_ = 0;
  std::optional<View> current_;
  int shown_volume_ = 0;
  std::optional<int> next_volume_;  ///< that the run ends for
  bool changes_ = false;            ///< the volume does, all the time
  bool not_yet_seen_ = false;       ///< no frame was drawn of the volume since it was loaded
  std::optional<SceneState> last_put_;
  LevelController controller_;
  std::optional<Rendering> rendering_;
  std::int64_t next_frame_ = 0;
  int pictures_encoding_ = 0;
  Clock::time_point shown_view_;  ///< when the view came that the last picture was sent for

  Requests requests_;  ///< has a lock of its own, taken after that
  WebServer server_;
  PictureMaker maker_;
  boost::asio::thread_pool picture_worker_{1};  ///< never calls MPI; last, as it uses all else
};

}  // namespace

std::unique_ptr<Viewer> make_viewer(ViewerOptions options) {
  return std::make_unique<PageViewer>(std::move(options));
}

}  // namespace ringsplat::serve
