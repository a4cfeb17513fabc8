#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/child_program.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/client_message.hpp"
#include "serve/private_folder.hpp"
#include "serve/web_server.hpp"

namespace ringsplat::serve {

/// A movie that is being made: its frames as PNGs in a folder of its own, which nobody else can read and
/// which is gone with this object, until ffmpeg makes a file of them. add() and encode() for one thread at a
/// time, never one that calls MPI, as they may take long.
class Movie {
 public:
  using Clock = std::chrono::steady_clock;

  /// Makes the folder, below TMPDIR. Throws RunError when it cannot.
  Movie(std::filesystem::path ffmpeg, const MoviePlan& plan)
      : ffmpeg_(std::move(ffmpeg)), plan_(plan), folder_("movie") {
    std::error_code error;
    const auto space = std::filesystem::space(folder(), error);
    bytes_left_ = error ? most_frame_bytes : std::min(most_frame_bytes, space.available / 2);
  }

  const MoviePlan& plan() const { return plan_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

  /// Keeps frame `index`. Throws RunError when the disk is full, or its share of it.
  void add(int index, const Bytes& png) {
    if (png.size() > bytes_left_)
      throw RunError("the movie's frames take too much of the disk", "make it smaller or shorter");
    bytes_left_ -= png.size();
    std::ofstream file(folder() / fmt::format("{:05}.png", index), std::ios::binary);
    file.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    file.close();
    if (!file)
      throw RunError(fmt::format("frame {} of the movie cannot be written; is the disk full?", index),
                     "set TMPDIR to a folder with room");
  }
  /// The MP4 of all frames: H.264 if ffmpeg has libx264, else MPEG-4; 4:2:0, so with an even width and
  /// height: a black row or column is added where they are not. Throws RunError when ffmpeg fails or takes
  /// until the deadline.
  std::string encode(Clock::time_point deadline) {
    std::optional<int> code;
    for (const Arguments& codec : {Arguments{"-c:v", "libx264", "-crf", "18", "-preset", "medium"},
                                   Arguments{"-c:v", "mpeg4", "-q:v", "2"}}) {  // best first
      Arguments all{"-nostdin", "-loglevel", "quiet", "-y", "-framerate",
                    fmt::format("{}", plan_.frames_a_second),
                    // PNGs alone: what ffmpeg opens must not depend on what it thinks of a file's bytes.
                    "-f", "image2", "-c:v", "png", "-start_number", "0", "-i", "%05d.png", "-vf",
                    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"};
      all.insert(all.end(), codec.begin(), codec.end());
      // Players take colours for those of old television without a word about them.
      all.insert(all.end(), {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc",
                             "iec61966-2-1", "-color_range", "tv", "-movflags", "+faststart", movie_name});
      code = run_program(ffmpeg_, all, folder(), deadline, cancelled_);
      if (!code || code == 0) break;
    }
    if (!code)
      throw RunError(cancelled_ ? "the movie was cancelled" : "ffmpeg did not finish the movie in time",
                     "make it smaller or shorter");
    if (code != 0) throw RunError(fmt::format("ffmpeg failed with exit code {}", *code));
    const std::filesystem::path file = folder() / movie_name;
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (error || size == 0) throw RunError("ffmpeg made no movie");
    if (size > most_movie_bytes)
      throw RunError(fmt::format("the movie has {} MiB, and more than {} are not sent", size >> 20,
                                 most_movie_bytes >> 20),
                     "make it smaller or shorter");
    std::string bytes(size, '\0');
    if (!std::ifstream(file, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(size)))
      throw RunError("the movie cannot be read back");
    return bytes;
  }
  /// What a movie of that many pixels may take to encode.
  std::chrono::milliseconds patience() const {
    const double megapixels = 1e-6 * plan_.count * plan_.width * plan_.height;
    const double seconds = std::min(60 + 0.5 * megapixels, 3600.0);
    return std::chrono::milliseconds(static_cast<long>(1e3 * seconds));
  }

  /// Ends encode() soon; for any thread.
  void cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  using Arguments = std::vector<std::string>;

  static constexpr std::uintmax_t most_frame_bytes = std::uintmax_t{8} << 30;  // of one movie
  static constexpr std::uintmax_t most_movie_bytes = std::uintmax_t{256} << 20;
  static constexpr const char* movie_name = "movie.mp4";

  const std::filesystem::path ffmpeg_;
  const MoviePlan plan_;
  PrivateFolder folder_;
  std::uintmax_t bytes_left_ = 0;  ///< for frames
  std::atomic<bool> cancelled_ = false;
};

/// A client's turn to make a movie, whose frames come in order. Not for several threads at once.
struct MovieTurn {
  ClientId client;
  std::uint32_t id;
  std::shared_ptr<Movie> movie;
  int next = 0;                                          ///< index that must come
  int answered = 0;                                      ///< frames
  Movie::Clock::time_point heard = Movie::Clock::now();  ///< when the client last asked or was answered

  /// The client, which got an answer to all that it sent, has said nothing for long.
  bool is_abandoned() const {
    constexpr std::chrono::seconds patience{60};
    return answered == next && Movie::Clock::now() - heard > patience;
  }
  /// Throws InputError unless it is the next frame of the movie as it began.
  void ask(const MovieFrame& frame) {
    if (frame.plan != movie->plan())
      throw InputError("all frames of a movie must have the same size, rate and count");
    if (frame.index != next)
      throw InputError(fmt::format("frame {} of the movie must come, not {}", next, frame.index));
    ++next;
    heard = Movie::Clock::now();
  }
  void answer() {
    ++answered;
    heard = Movie::Clock::now();
  }
};

}  // namespace ringsplat::serve
