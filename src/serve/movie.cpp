#include "serve/movie.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "base/child_program.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {
namespace {

using Arguments = std::vector<std::string>;

constexpr std::uintmax_t most_frame_bytes = std::uintmax_t{8} << 30;  // of one movie
constexpr std::uintmax_t most_movie_bytes = std::uintmax_t{256} << 20;
constexpr const char* movie_name = "movie.mp4";
constexpr const char* frame_names = "%05d.png";

Arguments arguments_for(const MoviePlan& plan, const Arguments& codec) {
  Arguments all{"-nostdin", "-loglevel", "quiet", "-y", "-framerate", fmt::format("{}", plan.frames_a_second),
                // PNGs alone: what ffmpeg opens must not depend on what it thinks of a file's bytes.
                "-f", "image2", "-c:v", "png", "-start_number", "0", "-i", frame_names, "-vf",
                "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"};
  all.insert(all.end(), codec.begin(), codec.end());
  // Players take colours for those of old television without a word about them.
  all.insert(all.end(), {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1",
                         "-color_range", "tv", "-movflags", "+faststart", movie_name});
  return all;
}

std::string read_file(const std::filesystem::path& file) {
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

}  // namespace

Movie::Movie(std::filesystem::path ffmpeg, const MoviePlan& plan)
    : ffmpeg_(std::move(ffmpeg)), plan_(plan), folder_("movie") {
  std::error_code error;
  const auto space = std::filesystem::space(folder(), error);
  bytes_left_ = error ? most_frame_bytes : std::min(most_frame_bytes, space.available / 2);
}

void Movie::add(int index, const Bytes& png) {
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

std::chrono::milliseconds Movie::patience() const {
  const double megapixels = 1e-6 * plan_.count * plan_.width * plan_.height;
  const double seconds = std::min(60 + 0.5 * megapixels, 3600.0);
  return std::chrono::milliseconds(static_cast<long>(1e3 * seconds));
}

std::string Movie::encode(Clock::time_point deadline) {
  std::optional<int> code;
  for (const Arguments& codec : {Arguments{"-c:v", "libx264", "-crf", "18", "-preset", "medium"},
                                 Arguments{"-c:v", "mpeg4", "-q:v", "2"}}) {  // best first
    code = run_program(ffmpeg_, arguments_for(plan_, codec), folder(), deadline, cancelled_);
    if (!code || code == 0) break;
  }
  if (!code)
    throw RunError(cancelled_ ? "the movie was cancelled" : "ffmpeg did not finish the movie in time",
                   "make it smaller or shorter");
  if (code != 0) throw RunError(fmt::format("ffmpeg failed with exit code {}", *code));
  return read_file(folder() / movie_name);
}

}  // namespace ringsplat::serve
