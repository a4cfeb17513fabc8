#include "serve/viewer.hpp"

#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <condition_variable>
#include <csignal>
#include <mutex>

#include "base/log.hpp"
#include "serve/audience.hpp"
#include "serve/picture_maker.hpp"
#include "serve/requests.hpp"
#include "serve/views.hpp"

namespace ringsplat::serve {
namespace {

class PageViewer final : public Viewer, ServerEvents {
 public:
  explicit PageViewer(ViewerOptions options)
      : options_(std::move(options)),
        rules_{options_.initial, options_.volume.grid, options_.volume.patient, int(options_.frames.size()),
               options_.largest_side},
        audience_([this](auto&&... message) { server_.send(std::move(message)...); }),
        views_(options_),
        requests_(
            server_, [this] { wake(); }, options_),
        server_(options_.server, *this),
        maker_(int(views_.levels().size())) {
    server_.start();
  }

  /// Requests send their answers by the server, which calls them.
  ~PageViewer() override { requests_.stop(); }

  std::string url() const override { return server_.url(); }
  Director director() override {
    const std::lock_guard lock(mutex_);
    next_frame_ = 0;
    rendering_.reset();  // of a run that failed
    return {.next_frame = {},
            .frame_done = [this](FrameResult&& result) { take(std::move(result)); },
            .may_come = [this] { return may_come(); },
            .unwanted = [this](const FrameSpec& spec) { return unwanted(spec); },
            .pause = [this](std::chrono::nanoseconds most) { pause(most); },
            .next_picture = [this] { return next(); }};
  }

  std::vector<int> next_volumes() override {
    const std::lock_guard lock(mutex_);
    return ended_ ? std::vector<int>() : next_volumes_;
  }

  void loaded(const HeldVolumes& held) override {
    const std::lock_guard lock(mutex_);
    next_volumes_.clear();
    views_.loaded(held);
    for (const int volume : held.volumes) audience_.say(frame_text(volume, "shown"));
  }

  void not_loaded(int volume, const std::string& why) override {
    requests_.refuse_volume(volume, why);
    const std::lock_guard lock(mutex_);
    views_.not_loaded(volume);
    audience_.say(frame_text(volume, "failed"));
    audience_.say(error_text(why));
  }

  std::optional<NextPart> next_part() override {
    server_.stop();  // until then a signal may end the job
    const std::lock_guard lock(mutex_);
    return next_part_;
  }

  void renewed(const ValueRange& range, bool changes) override {
    const std::lock_guard lock(mutex_);
    views_.renewed(range, changes);
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

  bool has_newcomer() override {
    const std::lock_guard lock(mutex_);
    return audience_.has_newcomer();
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
      const bool opens = std::exchange(next_part_, std::nullopt).has_value();
      if (std::exchange(ended_, true) && !opens) return;
      server_.end(text_of({{"type", "end"}, {"message", message}}));  // before who waits for it can stop it
    }
    wake();
    requests_.end();
  }

 private:
  using Clock = Views::Clock;
  using Frames = std::vector<VolumeFrame>;
  struct Rendering {
    std::int64_t frame = 0;
    Views::Wish wish;
  };

  void opened(ClientId client) override {
    std::unique_lock lock(mutex_);
    audience_.add(client);
    server_.send_text(client,
                      hello_text(options_, views_.levels(), audience_.drives(client), audience_.size()));
    for (const std::string& warning : warnings_) server_.send_text(client, warning);
    if (!told_.empty()) server_.send_text(client, told_);
    audience_.say_who_drives();
    if (!audience_.drives(client)) audience_.catch_up(client);
    lock.unlock();
    wake();
  }

  void received(ClientId client, const std::string& text) override {
    try {
      std::visit([&](auto&& message) { handle(client, std::move(message)); },
                 parse_client_message(text, rules_));
    } catch (const std::exception& e) {
      const auto id = id_of(text);
      if (id) requests_.cancel_movie(client, *id);
      server_.send_text(client, error_text(e.what(), id));
    }
    wake();
  }

  void refused(ClientId client) override { server_.send_text(client, error_text("messages must be texts")); }

  void closed(ClientId client) override {
    requests_.forget(client);
    std::unique_lock lock(mutex_);
    audience_.remove(client);
    audience_.say_who_drives();
    lock.unlock();
    wake();
  }

  void signalled(int number) override {
    end(number == SIGINT ? "The server was interrupted."
                         : "The job was ended from outside: it was cancelled, or one of its ranks died.");
  }

  void handle(ClientId client, ViewMessage&& view) {
    check_drawable(view.scene);
    const std::lock_guard lock(mutex_);
    if (audience_.drives(client)) views_.put(std::move(view));
  }

  void check_drawable(const SceneState& scene) const {
    for (const Level& level : views_.levels())
      check_frame(frames_of(scene, level, options_).front().spec, options_.volume.grid);
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
    const auto& last = views_.last();
    if (!last || asked.x >= last->shown.width || asked.y >= last->shown.height)
      throw InputError("there is no such pixel in the last view");
    requests_.add(client, asked, best_frames(*last).front(),
                  asked.of_compared ? last->compared.value_or(last->frame) : last->frame);
  }

  void handle(ClientId client, const MapMessage& map) {
    server_.send_text(
        client,
        text_of({{"type", "map"}, {"id", map.id}, {"transfer_function", to_json(map.transfer_function)}}));
  }

  void handle(ClientId client, const FileMessage& asked) {
    requests_.add(client, asked, best_frames(asked.scene));
  }

  void handle(ClientId client, const PartMessage& wanted) {
    if (!(wanted.seen ? options_.finer : options_.is_part))
      throw InputError(wanted.seen ? "the volume is shown as finely as it can be" : "all is shown already");
    check_drawable(wanted.scene);
    NextPart next{{}, wanted.scene, options_.volume.grid, server_.successor(), options_.part + 1};
    if (wanted.seen) next.box = seen_box(wanted.scene, options_.volume.grid);
    {
      const std::lock_guard lock(mutex_);
      if (ended_ || !audience_.drives(client)) return;
      next_part_ = std::move(next);
      ended_ = true;
      server_.end(text_of({{"type", "opening"}}));
    }
    requests_.end();
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
    if (ended_ || !next_volumes_.empty()) return {};
    Frames frames = next_picture();
    if (frames.empty() && next_volumes_.empty() && !views_.held().coarse) {
      frames = requests_.next(next_frame_, views_.held());
      const auto volume = frames.empty() ? requests_.wanted_volume(views_.held()) : std::nullopt;
      if (volume) ask_for({*volume});
    }
    if (!frames.empty()) ++next_frame_;
    return frames;
  }

  Frames next_picture() {
    if (audience_.size() == 0 || rendering_ ||
        pictures_encoding_ + audience_.unacknowledged() >= Audience::most_unacknowledged)
      return {};
    const auto wish = views_.next();
    if (!wish) return {};
    if (!wish->level) {
      if (wish->rests) show_again(wish->view);
    } else if (!views_.can_draw(wish->view.message.scene)) {
      // What is begun is loaded first, and shown meanwhile.
      if (!views_.held().coarse) ask_for(wish->view.message.scene.volumes());
    } else {
      views_.begun();
      rendering_ = {next_frame_, *wish};
      return views_.frames(*wish->level);
    }
    return {};
  }

  /// The mutex is held.
  void ask_for(const std::vector<int>& volumes) {
    next_volumes_ = volumes;
    for (const int volume : volumes) audience_.say(frame_text(volume, "loading"));
  }

  /// For a view that shows what the last picture shows: the page waits for one with the view's number.
  void show_again(const Views::View& view) {
    if (pictures_encoding_ > 0 || !audience_.last() || audience_.last()->scene != view.scene ||
        shown_view_ == view.came)
      return;
    SentPicture again = *audience_.last();
    again.head.seq = view.message.seq;
    again.head.time = view.message.time;
    shown_view_ = view.came;
    audience_.show(std::move(again));
  }

  void take(FrameResult&& result) {
    if (requests_.take(result)) return;
    const std::lock_guard lock(mutex_);
    // unwanted() may have dropped it when it was already complete.
    if (!rendering_ || rendering_->frame != result.spec.frame) return;
    const Views::Wish wish = std::exchange(rendering_, std::nullopt)->wish;
    ++pictures_encoding_;
    const ViewMessage& view = wish.view.message;
    auto picture = std::make_shared<RenderedPicture>();
    picture->image = std::move(result.image);
    picture->background = srgb_to_linear(view.scene.background);
    picture->moving = !wish.rests;
    picture->scene = wish.view.scene;
    picture->head = {.seq = view.seq,
                     .level = std::uint8_t(*wish.level),
                     .levels = std::uint8_t(views_.levels().size()),
                     .at_rest = views_.drawn(wish),
                     .seconds = static_cast<float>(result.stats.seconds),
                     .time = view.time,
                     .pictures = view.scene.compared ? 2U : 1U};
    // What JPEG loses would be seen in a difference.
    if (picture->head.at_rest && view.scene.compared && view.scene.gain > 0)
      picture->head.format = PictureFormat::png;
    post(picture_worker_,
         [this, picture, view = wish.view, drawn = Clock::now()] { send_picture(*picture, view, drawn); });
  }

  bool unwanted(const FrameSpec& spec) {
    if (requests_.unwanted(spec.frame)) return true;
    const std::lock_guard lock(mutex_);
    if (!rendering_ || rendering_->frame != spec.frame) return false;
    // A view's first picture is wanted, whatever came after it.
    const Views::View& view = rendering_->wish.view;
    if (!ended_ && audience_.size() > 0 && !(view.shown && views_.has_newer(view))) return false;
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
    Frames best = frames_of(scene, views_.levels().back(), options_);
    check_frame(best.front().spec, options_.volume.grid);
    return best;
  }

  void send_picture(RenderedPicture& picture, const Views::View& view, Clock::time_point drawn) {
    std::string message;
    try {
      message = maker_.make(picture);
    } catch (const std::exception& e) {
      log_error("the viewer: {}", e.what());
    }
    {
      const std::lock_guard lock(mutex_);
      --pictures_encoding_;
      if (!message.empty()) {
        shown_view_ = view.came;
        audience_.show({std::make_shared<const std::string>(std::move(message)), picture.head,
                        view.message.scene, view.scene});
      }
      const std::chrono::duration<double> to_send = Clock::now() - drawn;
      views_.took(picture.head.level, double(picture.head.seconds) + to_send.count());
    }
    wake();
    maker_.learn(picture);
  }

  bool may_come() {
    const std::lock_guard lock(mutex_);
    return !ended_ && next_volumes_.empty();
  }

  void wake() {
    const std::lock_guard lock(mutex_);
    woken_ = true;
    changed_.notify_all();
  }

  const ViewerOptions options_;
  const MessageRules rules_;

  std::mutex mutex_;  ///< guards what follows, up to the requests
  std::condition_variable changed_;
  bool woken_ = false, ended_ = false;
  Audience audience_;
  std::vector<std::string> warnings_;
  std::string told_;  ///< last
  Views views_;
  std::vector<int> next_volumes_;      ///< that the run ends for
  std::optional<NextPart> next_part_;  ///< that the viewer ends for
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
