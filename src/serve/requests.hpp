#pragma once
// Only viewer.cpp includes it.
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/srgb.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "serve/client_message.hpp"
#include "serve/movie.hpp"
#include "serve/picture_maker.hpp"
#include "serve/probe.hpp"
#include "serve/ruler.hpp"
#include "serve/viewer.hpp"
#include "serve/web_server.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {

/// What pages ask for beside the views that they show: probes, snapshots, movies. Each is answered once, with
/// what was asked for or an error that has its number, unless the client goes or cancels it before. Frames
/// are rendered one at a time for probes, and one at a time for files. All functions may be called by any
/// thread.
class Requests {
 public:
  /// `wake`: called by any thread when there may be a frame to render. `options` must outlive this.
  Requests(WebServer& server, std::function<void()> wake, const ViewerOptions& options)
      : server_(server), wake_(std::move(wake)), options_(options) {}

  /// `best`: the frame or frames to draw, or the last view's, at the best level; the ranks will not refuse
  /// them. All throw InputError when there is too much to do already, and for a movie whatever is wrong with
  /// it. A probe is of volume `volume` of the series; a file says its own.
  void add(ClientId client, const ProbeMessage& asked, const VolumeFrame& best, int volume) {
    const Grid& grid = options_.volume.grid;
    const Probe probe =
        asked.scene ? Probe(best.spec, grid, asked.voxel) : Probe(best.spec, grid, asked.x, asked.y);
    Probing probing{{client}, asked.id, probe, volume, best.volume};
    const std::lock_guard lock(mutex_);
    if (const auto old = probes_.find(client); old != probes_.end())
      server_.send_text(client, error_text("another pixel was asked for", old->second.id));
    probes_.insert_or_assign(client, std::move(probing));
  }
  void add(ClientId client, const FileMessage& asked, std::vector<VolumeFrame> best) {
    if (asked.errors && (!options_.errors || asked.scene.shown.cut))
      throw InputError("errors are not known of what is shown");
    const std::lock_guard lock(mutex_);
    File file{{client}, asked, std::move(best), asked.movie ? movie_for(client, asked) : nullptr};
    const auto waiting = std::ranges::count_if(files_, [&](const File& f) { return f.client == client; });
    if (waiting >= most_waiting)
      throw InputError(fmt::format("{} pictures are waiting already", most_waiting), "try again later");
    if (asked.errors) proving_[client] = asked.id;
    if (!ended_) files_.push_back(std::move(file));
  }

  /// Gives a client's movie up. Another number than its movie's: nothing happens.
  void cancel_movie(ClientId client, std::uint32_t id) {
    const std::lock_guard lock(mutex_);
    if (is_turn_of(client, id)) give_movie_up();
  }

  /// The client is gone.
  void forget(ClientId client) {
    const std::lock_guard lock(mutex_);
    probes_.erase(client);
    if (probing_ && probing_->client == client) probing_->forgotten = true;
    std::erase_if(files_, [client](const File& file) { return file.client == client; });
    if (making_ && making_->client == client) making_->forgotten = true;
    proving_.erase(client);
    if (movie_ && movie_->client == client) give_movie_up();
  }

  /// No more frames will be rendered.
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    files_.clear();
    give_movie_up();
  }

  /// end(), and waits for what is under way. Nothing is sent any more.
  void stop() {
    end();
    for (auto* const worker : {&file_worker_, &movie_worker_}) {
      worker->stop();  // what has not begun is left undone
      worker->join();
    }
  }

  /// The volume that must be held for what waits, when next() has nothing for those that are.
  std::optional<int> wanted_volume(const HeldVolumes& held) const {
    const std::lock_guard lock(mutex_);
    if (ended_) return std::nullopt;
    if (probing_ && probing_->frame < 0 && !probing_->forgotten && !held.hold(probing_->volume))
      return probing_->volume;
    if (files_.empty() || making_ || held.hold(files_.front().volume())) return std::nullopt;
    return files_.front().volume();
  }

  /// Answers all that waits for this volume by an error.
  void refuse_volume(int volume, const std::string& what) {
    std::vector<File> refused;
    {
      const std::lock_guard lock(mutex_);
      if (probing_ && probing_->volume == volume)
        probes_.insert_or_assign(probing_->client, *std::exchange(probing_, std::nullopt));
      std::erase_if(probes_, [&](const auto& waiting) {
        const auto& [client, probing] = waiting;
        if (probing.volume != volume) return false;
        if (!probing.forgotten) server_.send_text(client, error_text(what, probing.id));
        return true;
      });
      const auto is_of_it = [volume](const File& file) { return file.volume() == volume; };
      std::copy_if(files_.begin(), files_.end(), std::back_inserter(refused), is_of_it);
      std::erase_if(files_, is_of_it);
    }
    for (const File& file : refused) fail(file, what);
  }

  /// The next picture to render, which has the number `frame`; none: nothing.
  std::vector<VolumeFrame> next(std::int64_t frame, const HeldVolumes& held) {
    const std::lock_guard lock(mutex_);
    if (ended_) return {};
    auto frames = next_probe(frame, held);
    return frames.empty() ? next_file(frame, held) : frames;
  }

  /// True when frames are wanted for one, now or after those that are under way.
  bool any() const {
    const std::lock_guard lock(mutex_);
    const bool draws = making_ ? making_->frame >= 0 : !files_.empty();
    return !ended_ && (probing_ || draws || !probes_.empty());
  }

  /// True once for a frame that next() gave and that nobody waits for any more; it then counts as come back.
  bool unwanted(std::int64_t frame) {
    const std::lock_guard lock(mutex_);
    const auto drop = [&](auto& job) {
      if (!job || job->frame != frame || !(ended_ || job->forgotten)) return false;
      job.reset();
      return true;
    };
    return drop(probing_) || drop(making_);
  }

  /// Takes a frame that next() gave; false when it is none, or one that has come back.
  bool take(FrameResult& result) {
    const std::lock_guard lock(mutex_);
    if (probing_ && probing_->frame == result.spec.frame) return take_probe(result.image), true;
    if (!making_ || making_->frame != result.spec.frame) return false;
    if (making_->forgotten || ended_) return making_.reset(), true;
    making_->frame = -1;
    const auto kept = std::make_shared<const FrameResult>(std::move(result));
    post(file_worker_, [this, file = *making_, kept] { make_file(kept, file); });
    return true;
  }

 private:
  static constexpr std::ptrdiff_t most_waiting = 4;  // files of one client

  struct Job {
    ClientId client;
    std::int64_t frame = -1;  ///< that is being rendered
    bool forgotten = false;
  };
  struct Probing : Job {
    std::uint32_t id;
    Probe probe;
    int volume = 0;
    std::size_t channel = 0;
  };
  struct File : Job {
    FileMessage asked;
    std::vector<VolumeFrame> frames;
    std::shared_ptr<Movie> movie;  ///< that it is a frame of

    int volume() const { return asked.scene.frame; }
  };

  std::vector<VolumeFrame> next_probe(std::int64_t frame, const HeldVolumes& held) {
    if (probing_ && probing_->frame >= 0) return {};
    if (probing_ && probing_->forgotten) probing_.reset();
    if (!probing_ && !probes_.empty()) probing_ = std::move(probes_.extract(probes_.begin()).mapped());
    if (!probing_ || !held.hold(probing_->volume)) return {};
    const std::size_t volume = held.first_of(probing_->volume) + probing_->channel;
    probing_->probe.know_range(held.ranges[volume]);
    probing_->frame = frame;
    return {{volume, *probing_->probe.next_frame()}};
  }

  std::vector<VolumeFrame> next_file(std::int64_t frame, const HeldVolumes& held) {
    if (files_.empty() || making_ || !held.hold(files_.front().volume())) return {};
    making_ = std::move(files_.front());
    files_.pop_front();
    making_->frame = frame;
    return held.frames_of(making_->volume(), making_->frames);
  }

  /// The mutex is held; texts are only handed over.
  void take_probe(const Image& picture) {
    probing_->frame = -1;
    probing_->probe.take(picture);
    if (probing_->probe.next_frame()) return;
    const auto& [hit, voxel, world, value] = probing_->probe.answer();
    if (!probing_->forgotten)
      server_.send_text(probing_->client, text_of({{"type", "probe"},
                                                   {"id", probing_->id},
                                                   {"hit", hit},
                                                   {"voxel", {voxel.x, voxel.y, voxel.z}},
                                                   {"world", {world.x, world.y, world.z}},
                                                   {"value", value}}));
    probing_.reset();
  }

  /// The mutex is held.
  bool is_turn_of(ClientId client, std::uint32_t id) const {
    return movie_ && movie_->client == client && movie_->id == id;
  }

  /// The mutex is held. A client that begins anew has given its other movie up.
  std::shared_ptr<Movie> movie_for(ClientId client, const FileMessage& asked) {
    if (!options_.ffmpeg)
      throw InputError("movies need ffmpeg, which was not in PATH when the server was started",
                       "take the pictures instead");
    if (asked.movie->index == 0) {
      if (movie_ && movie_->client != client && !movie_->is_abandoned())
        throw InputError("somebody else's movie is being made", "try again when it is done");
      give_movie_up();
      movie_ = {client, asked.id, std::make_shared<Movie>(*options_.ffmpeg, asked.movie->plan)};
    }
    if (!is_turn_of(client, asked.id)) throw InputError("there is no such movie", "begin with frame 0");
    movie_->ask(*asked.movie);
    return movie_->movie;
  }

  /// The mutex is held. The folder, which may take long to remove, goes when the workers have let go of it.
  void give_movie_up() {
    if (!movie_) return;
    std::shared_ptr<Movie> movie = movie_->movie;
    movie_.reset();
    movie->cancel();
    std::erase_if(files_, [&](const File& file) { return file.movie == movie; });
    if (making_ && making_->movie == movie) making_->forgotten = true;
    post(movie_worker_, [kept = std::move(movie)] {});
  }

  void make_file(const std::shared_ptr<const FrameResult>& result, const File& file) {
    try {
      if (file.movie)
        add_to_movie(*result, file);
      else if (file.asked.errors)  // which takes long
        post(movie_worker_, [this, file, result] { prove_errors(*result, file); });
      else
        send_snapshot(*result, file, bytes_of(*result, file));
    } catch (const std::exception& e) {
      fail(file, e.what());
    }
    {
      const std::lock_guard lock(mutex_);
      making_.reset();
    }
    wake_();
  }

  /// The picture's file. Channels have functions of their own.
  Bytes bytes_of(const FrameResult& result, const File& file) const {
    auto settings = to_json(result.spec);
    if (!file.asked.scene.channels.empty()) {
      settings.erase("transfer_function");
      settings["channels"] = to_json(file.asked.scene)["channels"];
    }
    const FileMessage& asked = file.asked;
    Overlay ruler;
    if (!asked.exr)
      ruler = ruler_overlay(asked.ruler, asked.scene.shown, options_.volume.grid, options_.volume.unit,
                            asked.scene.background);
    return image_bytes(result.image, asked.exr ? ".exr" : ".png", srgb_to_linear(asked.scene.background),
                       text_of(settings), ruler);
  }

  void send_snapshot(const FrameResult& result, const File& file, const Bytes& bytes) {
    PictureHead head =
        head_of(file, PictureKind::snapshot, file.asked.exr ? PictureFormat::exr : PictureFormat::png);
    head.seconds = static_cast<float>(result.stats.seconds);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    server_.send(file.client, true, std::make_shared<const std::string>(picture_message(head, text)));
  }

  void prove_errors(const FrameResult& result, const File& file) {
    try {
      const auto go_on = [&] {
        const std::lock_guard lock(mutex_);
        const auto wanted = proving_.find(file.client);
        if (ended_ || wanted == proving_.end() || wanted->second != file.asked.id)
          throw RunError("it is no longer wanted");
      };
      const auto [words, colours, map] = options_.errors(result, file.volume(), go_on);
      server_.send_text(file.client,
                        text_of({{"type", "errors"}, {"words", words}, {"colours", to_json(colours)}}));
      send_snapshot(result, file, map);
    } catch (const std::exception& e) {
      fail(file, e.what());
    }
  }

  void add_to_movie(const FrameResult& result, const File& file) {
    if (file.movie->cancelled()) return;
    file.movie->add(file.asked.movie->index, bytes_of(result, file));
    if (file.asked.movie->index + 1 == file.movie->plan().count) {
      post(movie_worker_, [this, file] { finish_movie(file); });
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      if (!movie_ || movie_->movie != file.movie) return;
      movie_->answer();
    }
    server_.send_text(
        file.client,
        text_of({{"type", "movie_frame"}, {"id", file.asked.id}, {"index", file.asked.movie->index}}));
  }

  void finish_movie(const File& file) {
    try {
      const std::string bytes = file.movie->encode(Movie::Clock::now() + file.movie->patience());
      PictureHead head = head_of(file, PictureKind::movie, PictureFormat::mp4);
      for (std::uint16_t* const side : {&head.width, &head.height})
        *side = static_cast<std::uint16_t>(*side + *side % 2);
      if (file.movie->cancelled()) return;
      cancel_movie(file.client, file.asked.id);  // before the answer, after which another may be asked for
      server_.send(file.client, true, std::make_shared<const std::string>(picture_message(head, bytes)));
    } catch (const std::exception& e) {
      fail(file, e.what());
    }
  }

  /// A movie that was given up needs no answer.
  void fail(const File& file, const std::string& what) {
    if (file.movie && file.movie->cancelled()) return;
    if (file.movie) cancel_movie(file.client, file.asked.id);
    server_.send_text(file.client, error_text(what, file.asked.id));
  }

  static PictureHead head_of(const File& file, PictureKind kind, PictureFormat format) {
    return {.kind = kind,
            .number = file.asked.id,
            .width = std::uint16_t(file.asked.scene.shown.width),
            .height = std::uint16_t(file.asked.scene.shown.height),
            .format = format};
  }

  WebServer& server_;
  const std::function<void()> wake_;
  const ViewerOptions& options_;

  mutable std::mutex mutex_;  ///< guards what follows, up to the workers
  bool ended_ = false;
  std::map<ClientId, Probing> probes_;  ///< each client's newest, not yet begun
  std::optional<Probing> probing_;
  std::deque<File> files_;
  std::map<ClientId, std::uint32_t> proving_;  ///< each client's newest question for errors
  std::optional<File> making_;                 ///< is rendered, or has been and is encoded
  std::optional<MovieTurn> movie_;             ///< there is one at a time

  boost::asio::thread_pool file_worker_{1}, movie_worker_{1};  ///< never call MPI
};

}  // namespace ringsplat::serve
