#include "serve/requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <iterator>
#include <utility>
#include <vector>

#include "classify/srgb.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/viewer_texts.hpp"

namespace ringsplat::serve {
namespace {

constexpr std::ptrdiff_t most_waiting = 4;                 // files of one client
constexpr std::chrono::seconds patience_with_a_movie{60};  // for its next frame, while others want one

std::string_view text(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Requests::Requests(WebServer& server, std::function<void()> wake, const Grid& grid, const ValueRange& range,
                   int levels, std::optional<std::filesystem::path> ffmpeg)
    : server_(server),
      wake_(std::move(wake)),
      grid_(grid),
      levels_(levels),
      ffmpeg_(std::move(ffmpeg)),
      range_(range) {}

Requests::~Requests() { stop(); }

void Requests::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  files_.clear();
  give_movie_up();
}

void Requests::stop() {
  end();
  for (auto* const worker : {&file_worker_, &movie_worker_}) {
    worker->stop();  // what has not begun is left undone
    worker->join();
  }
}

// What pages ask.

void Requests::add(ClientId client, const ProbeMessage& asked, const FrameSpec& best, int volume) {
  Probing probing{client, asked.id, Probe(best, grid_, {}, asked.x, asked.y), volume};
  std::optional<std::uint32_t> replaced;
  {
    const std::lock_guard lock(mutex_);
    if (const auto old = probes_.find(client); old != probes_.end()) replaced = old->second.id;
    probes_.insert_or_assign(client, std::move(probing));
  }
  if (replaced)
    server_.send_text(client, error_text("another pixel was asked for", Request{"probe", *replaced}));
}

void Requests::add(ClientId client, const FileMessage& asked, const FrameSpec& best) {
  const std::lock_guard lock(mutex_);
  File file{.client = client,
            .request = {asked.movie ? "movie_frame" : "snapshot", asked.id},
            .spec = best,
            .volume = asked.scene.frame,
            .background = srgb_to_linear(asked.scene.background),
            .exr = asked.exr,
            .movie = asked.movie ? movie_for(client, asked) : nullptr,
            .index = asked.movie ? asked.movie->index : 0};
  const auto waiting =
      std::count_if(files_.begin(), files_.end(), [&](const File& f) { return f.client == client; });
  if (waiting >= most_waiting)
    throw InputError(fmt::format("{} pictures are waiting already", most_waiting), "try again later");
  if (!ended_) files_.push_back(std::move(file));
}

/// The mutex is held.
std::shared_ptr<Movie> Requests::movie_for(ClientId client, const FileMessage& asked) {
  const auto& [index, plan] = *asked.movie;
  if (!ffmpeg_)
    throw InputError("movies need ffmpeg, which was not in PATH when the server was started",
                     "take the pictures instead");
  if (index == 0) begin_movie(client, asked);
  if (!movie_ || movie_->client != client || movie_->id != asked.id)
    throw InputError("there is no such movie", "begin with frame 0");
  if (movie_->next != index || movie_->movie->plan() != plan)
    throw InputError(movie_->next == index
                         ? std::string("all frames of a movie must have the same size, rate and count")
                         : fmt::format("frame {} of the movie must come, not {}", movie_->next, index));
  ++movie_->next;
  movie_->heard = Clock::now();
  return movie_->movie;
}

/// The mutex is held. A client that begins anew has given its other movie up.
void Requests::begin_movie(ClientId client, const FileMessage& asked) {
  const bool abandoned =
      movie_ && movie_->answered == movie_->next && Clock::now() - movie_->heard > patience_with_a_movie;
  if (movie_ && movie_->client != client && !abandoned)
    throw InputError("somebody else's movie is being made", "try again when it is done");
  give_movie_up();
  movie_ = MovieTurn{client, asked.id, std::make_shared<Movie>(*ffmpeg_, asked.movie->plan), Clock::now()};
}

/// The mutex is held. The folder, which may take long to remove, goes when the workers have let go of it.
void Requests::give_movie_up() {
  if (!movie_) return;
  std::shared_ptr<Movie> movie = std::move(movie_->movie);
  movie_.reset();
  movie->cancel();
  std::erase_if(files_, [&](const File& file) { return file.movie == movie; });
  if (rendering_ && rendering_->movie == movie) rendering_->forgotten = true;
  post(movie_worker_, [kept = std::move(movie)] {});
}

void Requests::cancel_movie(ClientId client, std::uint32_t id) {
  const std::lock_guard lock(mutex_);
  if (movie_ && movie_->client == client && movie_->id == id) give_movie_up();
}

void Requests::forget(ClientId client) {
  const std::lock_guard lock(mutex_);
  probes_.erase(client);
  if (probing_ && probing_->client == client) probing_->forgotten = true;
  std::erase_if(files_, [client](const File& file) { return file.client == client; });
  if (rendering_ && rendering_->client == client) rendering_->forgotten = true;
  if (movie_ && movie_->client == client) give_movie_up();
}

// Which volume is shown.

void Requests::show(int volume, const ValueRange& range) {
  const std::lock_guard lock(mutex_);
  volume_ = volume;
  range_ = range;
}

std::optional<int> Requests::wanted_volume() const {
  const std::lock_guard lock(mutex_);
  if (ended_) return std::nullopt;
  if (probing_ && probing_->frame < 0 && !probing_->forgotten && probing_->volume != volume_)
    return probing_->volume;
  const bool file_can_come = !files_.empty() && !rendering_ && !encoding_;
  return file_can_come && files_.front().volume != volume_ ? std::optional(files_.front().volume)
                                                           : std::nullopt;
}

void Requests::refuse_volume(int volume, const std::string& what) {
  std::vector<File> refused;
  {
    const std::lock_guard lock(mutex_);
    if (probing_ && probing_->volume == volume)
      probes_.insert_or_assign(probing_->client, *std::exchange(probing_, std::nullopt));
    std::erase_if(probes_, [&](const auto& waiting) {
      const auto& [client, probing] = waiting;
      if (probing.volume != volume) return false;
      if (!probing.forgotten) server_.send_text(client, error_text(what, Request{"probe", probing.id}));
      return true;
    });
    std::copy_if(files_.begin(), files_.end(), std::back_inserter(refused),
                 [volume](const File& file) { return file.volume == volume; });
    std::erase_if(files_, [volume](const File& file) { return file.volume == volume; });
  }
  for (const File& file : refused) fail(file, what);
}

// What is rendered.

std::optional<FrameSpec> Requests::next(std::int64_t frame) {
  const std::lock_guard lock(mutex_);
  if (ended_) return std::nullopt;
  auto spec = next_probe(frame);
  return spec ? spec : next_file(frame);
}

std::optional<FrameSpec> Requests::next_probe(std::int64_t frame) {
  if (probing_ && probing_->frame >= 0) return std::nullopt;
  if (probing_ && probing_->forgotten) probing_.reset();
  if (!probing_ && !probes_.empty()) probing_ = std::move(probes_.extract(probes_.begin()).mapped());
  if (!probing_ || probing_->volume != volume_) return std::nullopt;
  probing_->probe.know_range(range_);
  probing_->frame = frame;
  return probing_->probe.next_frame();
}

std::optional<FrameSpec> Requests::next_file(std::int64_t frame) {
  if (files_.empty() || rendering_ || encoding_ || files_.front().volume != volume_) return std::nullopt;
  rendering_ = std::move(files_.front());
  files_.pop_front();
  rendering_->frame = frame;
  return rendering_->spec;
}

bool Requests::renders(std::int64_t frame) const {
  const std::lock_guard lock(mutex_);
  return (probing_ && probing_->frame == frame) || (rendering_ && rendering_->frame == frame);
}

bool Requests::unwanted(std::int64_t frame) {
  const std::lock_guard lock(mutex_);
  const auto drop = [&](auto& job) {
    if (!job || job->frame != frame || !(ended_ || job->forgotten)) return false;
    job.reset();
    return true;
  };
  return drop(probing_) || drop(rendering_);
}

void Requests::take(FrameResult&& result) {
  const std::lock_guard lock(mutex_);
  if (probing_ && probing_->frame == result.spec.frame) {
    take_probe(result.image);
  } else if (rendering_ && rendering_->frame == result.spec.frame) {
    const File file = *std::exchange(rendering_, std::nullopt);
    if (file.forgotten || ended_) return;
    encoding_ = true;
    post(file_worker_, [this, file, kept = std::make_shared<const FrameResult>(std::move(result))] {
      make_file(*kept, file);
    });
  }
}

/// The mutex is held; texts are only handed over.
void Requests::take_probe(const Image& picture) {
  probing_->frame = -1;
  probing_->probe.take(picture);
  if (probing_->probe.next_frame()) return;
  if (!probing_->forgotten)
    server_.send_text(probing_->client, probe_text(probing_->id, probing_->probe.answer()));
  probing_.reset();
}

// What is sent: on the workers' threads.

void Requests::make_file(const FrameResult& result, const File& file) {
  try {
    if (file.movie)
      add_to_movie(result, file);
    else
      make_snapshot(result, file);
  } catch (const std::exception& e) {
    fail(file, e.what());
  }
  {
    const std::lock_guard lock(mutex_);
    encoding_ = false;
  }
  wake_();
}

/// A movie that was given up needs no answer.
void Requests::fail(const File& file, const std::string& what) {
  if (file.movie && file.movie->cancelled()) return;
  if (file.movie) cancel_movie(file.client, file.request.id);
  server_.send_text(file.client, error_text(what, file.request));
}

PictureHead Requests::head_of(const File& file, PictureKind kind, PictureFormat format) const {
  return {.kind = kind,
          .number = file.request.id,
          .width = std::uint16_t(file.spec.shown.width),
          .height = std::uint16_t(file.spec.shown.height),
          .level = std::uint8_t(levels_ - 1),
          .levels = std::uint8_t(levels_),
          .at_rest = true,
          .format = format,
          .rmse = 0};
}

void Requests::make_snapshot(const FrameResult& result, const File& file) {
  const Bytes bytes =
      image_bytes(result.image, file.exr ? ".exr" : ".png", file.background, to_json_text(result.spec));
  PictureHead head = head_of(file, PictureKind::snapshot, file.exr ? PictureFormat::exr : PictureFormat::png);
  head.seconds = static_cast<float>(result.stats.seconds);
  server_.send_binary(file.client, std::make_shared<const std::string>(picture_message(head, text(bytes))));
}

void Requests::add_to_movie(const FrameResult& result, const File& file) {
  if (file.movie->cancelled()) return;
  file.movie->add(file.index, image_bytes(result.image, ".png", file.background, to_json_text(result.spec)));
  if (file.index + 1 == file.movie->plan().count) {
    post(movie_worker_, [this, file] { finish_movie(file); });
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    if (!movie_ || movie_->movie != file.movie) return;
    ++movie_->answered;
    movie_->heard = Clock::now();
  }
  server_.send_text(file.client, movie_frame_text(file.request.id, file.index));
}

void Requests::finish_movie(const File& file) {
  try {
    const std::string bytes = file.movie->encode(Clock::now() + file.movie->patience());
    PictureHead head = head_of(file, PictureKind::movie, PictureFormat::mp4);
    for (std::uint16_t* const side : {&head.width, &head.height})
      *side = static_cast<std::uint16_t>(*side + *side % 2);
    if (file.movie->cancelled()) return;
    cancel_movie(file.client, file.request.id);  // before the answer, after which another may be asked for
    server_.send_binary(file.client, std::make_shared<const std::string>(picture_message(head, bytes)));
  } catch (const std::exception& e) {
    fail(file, e.what());
  }
}

}  // namespace ringsplat::serve
