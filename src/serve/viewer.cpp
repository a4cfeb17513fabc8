#include "serve/viewer.hpp"

#include <algorithm>
#include <utility>

#include "base/log.hpp"
#include "classify/srgb.hpp"
#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/viewer_texts.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {
namespace {

using namespace std::chrono_literals;

constexpr auto rest_begins = 150ms;
constexpr std::size_t most_snapshots = 4;  // waiting, of one client

bool shows_the_same(const ViewMessage& a, const ViewMessage& b) {
  return a.width == b.width && a.height == b.height && a.scene == b.scene;
}

}  // namespace

Viewer::Viewer(ViewerOptions options)
    : options_(std::move(options)),
      levels_(make_levels(options_.qualities, options_.volume.grid.dims)),
      rules_{options_.initial, options_.volume.grid.dims, options_.largest_side, options_.largest_side},
      hello_(hello_text(options_, levels_)),
      controller_(int(levels_.size()), options_.target_seconds),
      server_(std::make_unique<WebServer>(options_.server, events())),
      maker_(int(levels_.size())) {
  server_->start();
}

Viewer::~Viewer() = default;

ServerEvents Viewer::events() {
  return {.opened = [this](ClientId client) { opened(client); },
          .received = [this](ClientId client, std::string&& text) { received(client, text); },
          .refused = [this](ClientId client) { complain(client, "messages must be texts"); },
          .closed = [this](ClientId client) { closed(client); },
          .signalled = [this](int number) { end(ended_by_signal_text(number)); }};
}

Director Viewer::director() {
  return {.next_frame = [this] { return next(); },
          .frame_done = [this](FrameResult&& result) { take(std::move(result)); },
          .may_come =
              [this] {
                const std::lock_guard lock(mutex_);
                return !ended_;
              },
          .unwanted = [this](const FrameSpec& spec) { return unwanted(spec); },
          .pause = [this](std::chrono::nanoseconds most) { pause(most); }};
}

void Viewer::end(const std::string& message) {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(ended_, true)) return;
    wake();
  }
  server_->end(end_text(message));
}

/// The mutex is held.
void Viewer::wake() {
  woken_ = true;
  changed_.notify_all();
}

void Viewer::pause(std::chrono::nanoseconds most) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, most, [this] { return woken_; });
  woken_ = false;
}

// What pages say: on the server's thread.

void Viewer::say(ClientId client, const std::string& text) {
  server_->send_text(client, std::make_shared<const std::string>(text));
}

void Viewer::complain(ClientId client, const std::string& what) { say(client, error_text(what)); }

/// The mutex is held.
void Viewer::say_driver() {
  for (const ClientId client : audience_.all())
    say(client, driver_text(audience_.drives(client), audience_.size()));
}

void Viewer::opened(ClientId client) {
  const std::lock_guard lock(mutex_);
  audience_.add(client);
  say(client, hello_for(hello_, audience_.drives(client), audience_.size()));
  say_driver();
  if (!audience_.drives(client) && last_.message) send_to(client, last_);
  wake();
}

void Viewer::closed(ClientId client) {
  const std::lock_guard lock(mutex_);
  audience_.remove(client);
  probes_.erase(client);
  std::erase_if(snapshots_, [client](const Snapshot& s) { return s.client == client; });
  say_driver();
  wake();
}

void Viewer::received(ClientId client, const std::string& text) {
  try {
    std::visit([&](auto&& message) { handle(client, std::move(message)); },
               parse_client_message(text, rules_));
  } catch (const std::exception& e) {
    complain(client, e.what());
  }
}

FrameSpec Viewer::full_frame(const SceneState& scene, int width, int height) const {
  FrameSpec spec = with_scene(options_.frame, scene);
  spec.shown.width = width;
  spec.shown.height = height;
  return spec;
}

/// An error in a frame that is announced would end the job.
void Viewer::check_view(const ViewMessage& view) const {
  const FrameSpec full = full_frame(view.scene, view.width, view.height);
  for (const Level& level : levels_) check_frame(at_level(full, level), options_.volume.grid);
}

void Viewer::handle(ClientId client, ViewMessage&& view) {
  check_view(view);
  const std::lock_guard lock(mutex_);
  if (!audience_.drives(client)) return;
  if (!last_put_ || !shows_the_same(*last_put_, view)) ++scenes_;
  last_put_ = view;
  newest_ = View{std::move(view), scenes_, ++views_, Clock::now(), {}};
  wake();
}

void Viewer::handle(ClientId client, const AckMessage& ack) {
  const std::lock_guard lock(mutex_);
  audience_.acknowledge(client, ack.picture);
  // Pictures that a slow watcher could not take are skipped, but not the last one.
  if (last_.message && audience_.lacks(client, last_.head.number)) send_to(client, last_);
  wake();
}

void Viewer::handle(ClientId client, const DriveMessage&) {
  const std::lock_guard lock(mutex_);
  if (audience_.drives(client)) return;
  audience_.drive(client);
  say_driver();
  wake();
}

void Viewer::handle(ClientId client, const ProbeMessage& asked) {
  const std::lock_guard lock(mutex_);
  if (!audience_.has(client)) return;
  if (!last_put_ || asked.x >= last_put_->width || asked.y >= last_put_->height)
    throw InputError("there is no such pixel in the last view");
  const FrameSpec full = full_frame(last_put_->scene, last_put_->width, last_put_->height);
  probes_.insert_or_assign(client, Probing{client, asked.id,
                                           Probe(at_level(full, levels_.back()), options_.volume.grid,
                                                 options_.volume.range, asked.x, asked.y)});
  wake();
}

void Viewer::handle(ClientId client, SnapshotMessage&& snapshot) {
  check_frame(at_level(full_frame(snapshot.scene, snapshot.width, snapshot.height), levels_.back()),
              options_.volume.grid);
  const std::lock_guard lock(mutex_);
  if (!audience_.has(client)) return;
  const auto waiting = std::count_if(snapshots_.begin(), snapshots_.end(),
                                     [client](const Snapshot& s) { return s.client == client; });
  if (std::size_t(waiting) >= most_snapshots)
    throw InputError(fmt::format("{} snapshots are waiting already", most_snapshots), "try again later");
  snapshots_.push_back({client, std::move(snapshot)});
  wake();
}

// What is rendered: on the thread that renders.

std::optional<FrameSpec> Viewer::next() {
  const std::lock_guard lock(mutex_);
  if (ended_) return std::nullopt;
  auto spec = next_picture();
  if (!spec) spec = next_probe();
  if (!spec) spec = next_snapshot();
  if (spec) ++next_frame_;
  return spec;
}

void Viewer::take_newest() {
  if (!newest_) return;
  View view = *std::exchange(newest_, std::nullopt);
  if (current_ && current_->scene == view.scene) view.shown = current_->shown;
  if (view.message.moving && current_ && !current_->message.moving) controller_.begin_motion();
  if (current_ &&
      (current_->message.width != view.message.width || current_->message.height != view.message.height))
    controller_.forget();
  current_ = std::move(view);
}

std::optional<FrameSpec> Viewer::next_picture() {
  if (audience_.size() == 0) return std::nullopt;
  const int under_way = pictures_rendering_ + pictures_encoding_ + audience_.unacknowledged();
  if (pictures_rendering_ > 0 || under_way >= Audience::most_unacknowledged) return std::nullopt;
  take_newest();
  if (!current_) return std::nullopt;
  View& view = *current_;
  const bool rests = !view.message.moving || Clock::now() - view.came >= rest_begins;
  std::optional<int> level;
  if (rests)
    level = next_level_at_rest(controller_, int(levels_.size()), options_.target_seconds, view.shown);
  else if (!view.shown)
    level = controller_.level();
  if (!level) {
    if (rests) show_again();
    return std::nullopt;
  }
  ++pictures_rendering_;
  rendering_[next_frame_] = {view, *level, rests, view.shown.has_value(), {}};
  return at_level(full_frame(view.message.scene, view.message.width, view.message.height),
                  levels_[std::size_t(*level)]);
}

/// For a view that shows what the last picture shows: the page waits for one with the view's number.
void Viewer::show_again() {
  const ViewMessage& view = current_->message;
  if (pictures_encoding_ > 0 || !last_.message || last_.scene != current_->scene ||
      last_.view == current_->number)
    return;
  LastPicture again = last_;
  again.view = current_->number;
  again.head.seq = view.seq;
  again.head.time = view.time;
  send_to_all(std::move(again));
}

std::optional<FrameSpec> Viewer::next_probe() {
  const bool renders = std::any_of(rendering_.begin(), rendering_.end(),
                                   [](const auto& frame) { return frame.second.probes; });
  if (renders) return std::nullopt;
  if (!probing_ && !probes_.empty()) probing_ = std::move(probes_.extract(probes_.begin()).mapped());
  if (!probing_) return std::nullopt;
  rendering_[next_frame_].probes = true;
  return probing_->probe.next_frame();
}

void Viewer::take_probe(const Image& picture) {
  probing_->probe.take(picture);
  if (probing_->probe.next_frame() && audience_.has(probing_->client)) return;
  say(probing_->client, probe_text(probing_->id, probing_->probe.answer()));
  probing_.reset();
}

std::optional<FrameSpec> Viewer::next_snapshot() {
  if (snapshots_.empty() || snapshots_under_way_ > 0) return std::nullopt;
  Rendering rendering;
  rendering.snapshot = std::move(snapshots_.front());
  snapshots_.pop_front();
  ++snapshots_under_way_;
  const SnapshotMessage& wanted = rendering.snapshot->message;
  FrameSpec spec = at_level(full_frame(wanted.scene, wanted.width, wanted.height), levels_.back());
  rendering_[next_frame_] = std::move(rendering);
  return spec;
}

bool Viewer::unwanted(const FrameSpec& spec) {
  const std::lock_guard lock(mutex_);
  const auto found = rendering_.find(spec.frame);
  if (found == rendering_.end()) return false;
  const Rendering& rendering = found->second;
  if (rendering.probes) {
    if (!ended_) return false;
  } else if (rendering.snapshot) {
    if (!ended_ && audience_.has(rendering.snapshot->client)) return false;
    --snapshots_under_way_;
  } else {
    const bool newer = newest_ && newest_->scene != rendering.view.scene;
    if (!ended_ && audience_.size() > 0 && !(rendering.refines && newer)) return false;
    --pictures_rendering_;
  }
  rendering_.erase(found);
  return true;
}

/// The mutex is held.
void Viewer::measure(const Rendering& rendering, double seconds) {
  if (rendering.at_rest)
    controller_.rested(rendering.level, seconds);
  else
    controller_.moved(seconds);
}

void Viewer::take(FrameResult&& result) {
  std::unique_lock lock(mutex_);
  const auto found = rendering_.find(result.spec.frame);
  if (found == rendering_.end()) return;  // unwanted() dropped it, but it was already complete
  const Rendering rendering = std::move(found->second);
  rendering_.erase(found);
  if (rendering.probes) {
    take_probe(result.image);
    return;
  }
  if (rendering.snapshot) {
    file_worker_.give(
        [this, snapshot = *rendering.snapshot,
         kept = std::make_shared<const FrameResult>(std::move(result))] { send_snapshot(*kept, snapshot); });
    return;
  }
  --pictures_rendering_;
  ++pictures_encoding_;
  const double seconds = result.stats.seconds;
  measure(rendering, seconds);
  if (current_ && current_->scene == rendering.view.scene) current_->shown = rendering.level;
  const ViewMessage& view = rendering.view.message;
  const int levels = int(levels_.size());
  const bool at_rest = rendering.level + 1 == levels;
  auto picture = std::make_shared<RenderedPicture>();
  picture->image = std::move(result.image);
  picture->background = srgb_to_linear(view.scene.background);
  picture->quality = rendering.at_rest ? JpegQuality::at_rest : JpegQuality::moving;
  picture->scene = rendering.view.scene;
  picture->head = {.seq = view.seq,
                   .level = rendering.level,
                   .levels = levels,
                   .at_rest = at_rest,
                   .seconds = static_cast<float>(seconds),
                   .time = view.time};
  picture_worker_.give([this, picture, shown = rendering.view] { send_picture(*picture, shown); });
}

// What is sent: on the workers' threads.

void Viewer::send_picture(RenderedPicture& picture, const View& view) {
  std::string message;
  try {
    message = maker_.make(picture);
  } catch (const std::exception& e) {
    log_error("the viewer: {}", e.what());
  }
  {
    const std::lock_guard lock(mutex_);
    --pictures_encoding_;
    if (!message.empty())
      send_to_all({std::make_shared<const std::string>(std::move(message)), picture.head, picture.scene,
                   view.message.scene, view.number});
    wake();
  }
  maker_.learn(picture);
}

/// The mutex is held.
void Viewer::send_to_all(LastPicture&& picture) {
  const auto now = Clock::now();
  sent_.push_back(now);
  while (now - sent_.front() > 1s) sent_.pop_front();
  picture.head.number = ++last_number_;
  picture.head.pictures_a_second = pictures_a_second();
  picture.message = std::make_shared<const std::string>(with_head(*picture.message, picture.head));
  last_ = std::move(picture);
  for (const ClientId client : audience_.takers()) send_to(client, last_);
}

void Viewer::send_to(ClientId client, const LastPicture& picture) {
  if (audience_.must_learn(client, picture.scene)) say(client, state_text(picture.state));
  audience_.sent(client, picture.head.number);
  server_->send_binary(client, picture.message);
}

float Viewer::pictures_a_second() {
  if (sent_.size() < 2) return 0;
  const std::chrono::duration<float> span = sent_.back() - sent_.front();
  return float(sent_.size() - 1) / std::max(span.count(), 1e-3F);
}

void Viewer::send_snapshot(const FrameResult& result, const Snapshot& snapshot) {
  const SnapshotMessage& wanted = snapshot.message;
  try {
    const Bytes file = image_bytes(result.image, wanted.exr ? ".exr" : ".png",
                                   srgb_to_linear(wanted.scene.background), to_json_text(result.spec));
    const PictureHead head{.kind = PictureKind::snapshot,
                           .number = wanted.id,
                           .width = result.image.width,
                           .height = result.image.height,
                           .level = int(levels_.size()) - 1,
                           .levels = int(levels_.size()),
                           .at_rest = true,
                           .format = wanted.exr ? PictureFormat::exr : PictureFormat::png,
                           .seconds = static_cast<float>(result.stats.seconds),
                           .rmse = 0};
    server_->send_binary(snapshot.client,
                         std::make_shared<const std::string>(picture_message(
                             head, {reinterpret_cast<const char*>(file.data()), file.size()})));
  } catch (const std::exception& e) {
    complain(snapshot.client, e.what());
  }
  const std::lock_guard lock(mutex_);
  --snapshots_under_way_;
  wake();
}

}  // namespace ringsplat::serve
