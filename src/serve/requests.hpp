#pragma once
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "serve/client_message.hpp"
#include "serve/movie.hpp"
#include "serve/picture_maker.hpp"
#include "serve/probe.hpp"
#include "serve/web_server.hpp"
#include "session/director.hpp"

namespace ringsplat::serve {

/// What pages ask for beside the views that they show: probes, snapshots, movies. Each is answered once, with
/// what was asked for or an error that has its number, unless the client goes or cancels it before. Frames
/// are rendered one at a time for probes, and one at a time for files. All functions may be called by any
/// thread.
class Requests {
 public:
  /// `wake`: called by any thread when there may be a frame to render. `levels`: how many there are; files
  /// are drawn at the last. `ffmpeg`: without it there are no movies.
  Requests(WebServer& server, std::function<void()> wake, const Grid& grid, const ValueRange& range,
           int levels, std::optional<std::filesystem::path> ffmpeg);
  ~Requests();
  Requests(const Requests&) = delete;
  Requests& operator=(const Requests&) = delete;

  /// `best`: the frame to draw, or the last view's, at the best level; the ranks will not refuse it. All
  /// throw InputError when there is too much to do already, and for a movie whatever is wrong with it.
  /// A probe is of volume `volume` of the series; a file says its own.
  void add(ClientId client, const ProbeMessage& asked, const FrameSpec& best, int volume);
  void add(ClientId client, const FileMessage& asked, const FrameSpec& best);
  /// Gives a client's movie up. Another number than its movie's: nothing happens.
  void cancel_movie(ClientId client, std::uint32_t id);
  /// The client is gone.
  void forget(ClientId client);
  /// No more frames will be rendered.
  void end();
  /// end(), and waits for what is under way. Nothing is sent any more.
  void stop();

  /// Frames are drawn of another volume from now on; none is under way.
  void show(int volume, const ValueRange& range);
  /// The volume that must be shown for what waits, when next() has nothing for the one that is.
  std::optional<int> wanted_volume() const;
  /// Answers all that waits for this volume by an error.
  void refuse_volume(int volume, const std::string& what);

  /// The next frame to render, which has the number `frame`.
  std::optional<FrameSpec> next(std::int64_t frame);
  /// True when that frame is one that next() gave and that has not come back.
  bool renders(std::int64_t frame) const;
  /// True once for such a frame that nobody waits for any more; it then counts as come back.
  bool unwanted(std::int64_t frame);
  /// Takes such a frame.
  void take(FrameResult&& result);

 private:
  using Clock = Movie::Clock;
  struct Probing {
    ClientId client;
    std::uint32_t id;
    Probe probe;
    int volume = 0;
    std::int64_t frame = -1;  ///< that is being rendered
    bool forgotten = false;
  };
  struct File {
    ClientId client;
    Request request;
    FrameSpec spec;
    int volume = 0;
    glm::dvec3 background;  ///< linear light
    bool exr = false;
    std::shared_ptr<Movie> movie;  ///< that it is a frame of
    int index = 0;                 ///< in the movie
    std::int64_t frame = -1;       ///< that is being rendered
    bool forgotten = false;
  };
  struct MovieTurn {
    ClientId client;
    std::uint32_t id;
    std::shared_ptr<Movie> movie;
    Clock::time_point heard;  ///< when the client last asked or was answered
    int next = 0;             ///< index that must come
    int answered = 0;         ///< frames
  };

  std::optional<FrameSpec> next_probe(std::int64_t frame);
  std::optional<FrameSpec> next_file(std::int64_t frame);
  void take_probe(const Image& picture);
  std::shared_ptr<Movie> movie_for(ClientId client, const FileMessage& asked);
  void begin_movie(ClientId client, const FileMessage& asked);
  void give_movie_up();

  void make_file(const FrameResult& result, const File& file);
  void make_snapshot(const FrameResult& result, const File& file);
  void add_to_movie(const FrameResult& result, const File& file);
  void finish_movie(const File& file);
  void fail(const File& file, const std::string& what);
  PictureHead head_of(const File& file, PictureKind kind, PictureFormat format) const;

  WebServer& server_;
  const std::function<void()> wake_;
  const Grid grid_;
  const int levels_;
  const std::optional<std::filesystem::path> ffmpeg_;

  mutable std::mutex mutex_;  ///< guards what follows, up to the workers
  bool ended_ = false;
  int volume_ = 0;                      ///< that is shown
  ValueRange range_;                    ///< its values
  std::map<ClientId, Probing> probes_;  ///< each client's newest, not yet begun
  std::optional<Probing> probing_;
  std::deque<File> files_;
  std::optional<File> rendering_;
  bool encoding_ = false;
  std::optional<MovieTurn> movie_;  ///< there is one at a time

  boost::asio::thread_pool file_worker_{1}, movie_worker_{1};  ///< never call MPI
};

}  // namespace ringsplat::serve
