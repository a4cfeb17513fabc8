// Views from a pipe: how many are read ahead, and what happens to lines that are no views.
#include "app/views.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>
#include <ext/stdio_filebuf.h>

#include <istream>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

/// A pipe, and a stream that reads it and keeps its warnings.
class PipedStream {
 public:
  explicit PipedStream(const std::function<void(const Camera&)>& check = [](const Camera&) {}) {
    REQUIRE(pipe2(ends_, O_CLOEXEC) == 0);
    // The reader's thread may outlive this, but not its hooks.
    const auto in = std::make_shared<Input>(ends_[0]);
    const auto warn = [this, in](const std::string& warning) { warnings_.push_back(warning); };
    stream_ = ViewStream::of(in->stream, "views", {}, {check, warn});
  }
  ~PipedStream() {
    stream_.reset();
    end();
  }
  PipedStream(const PipedStream&) = delete;
  PipedStream& operator=(const PipedStream&) = delete;

  void write(const std::string& text) const {
    REQUIRE(::write(ends_[1], text.data(), text.size()) == ssize_t(text.size()));
  }
  /// Writes `line` again and again until the pipe stays full; returns the bytes taken.
  std::size_t fill(const std::string& line, std::size_t most) const {
    fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    std::size_t written = 0;
    while (written < most) {
      pollfd wait{ends_[1], POLLOUT, 0};
      if (poll(&wait, 1, 500) != 1) break;
      const auto bytes = ::write(ends_[1], line.data(), line.size());
      if (bytes > 0) written += std::size_t(bytes);
    }
    return written;
  }
  void end() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  std::vector<Camera> rest() {
    end();
    std::vector<Camera> views;
    while (stream_->may_come()) {
      if (const auto view = stream_->next())
        views.push_back(*view);
      else
        usleep(200);
    }
    return views;
  }
  ViewStream& stream() { return *stream_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  /// Closes its end of the pipe.
  struct Input {
    explicit Input(int end) : buffer(end, std::ios::in), stream(&buffer) {}
    __gnu_cxx::stdio_filebuf<char> buffer;
    std::istream stream;
  };

  int ends_[2] = {-1, -1};
  std::vector<std::string> warnings_;
  std::shared_ptr<ViewStream> stream_;
};

}  // namespace

TEST_CASE("no more is read from the pipe while enough views wait, and none is lost", "[threads]") {
  PipedStream piped;
  const std::string line = "10 20\n";
  constexpr std::size_t most = 4'000'000;
  const std::size_t written = piped.fill(line, most);
  // The pipe itself holds 64 KiB; one read takes as much.
  CHECK(written < most / 4);
  CHECK(piped.rest().size() == (written + line.size() - 1) / line.size());
  CHECK_NOTHROW(piped.stream().check_all_was_read());
}

TEST_CASE("a stream can be given up while its reader waits for room", "[threads]") {
  PipedStream piped;
  std::string text;
  for (std::size_t k = 0; k < 4 * ViewStream::room; ++k) text += "1 2\n";
  piped.write(text);
  while (!piped.stream().next()) usleep(200);
}

TEST_CASE("lines that give no view are skipped with a warning, and counted in the end", "[threads]") {
  PipedStream piped([](const Camera& camera) {
    if (camera.zoom == 0) throw InputError("the zoom is 0", "use more");
  });
  piped.write("azimuth zoom\n10 2\nleft\x1b[2J right\n# nothing\n\n30 0\n" + std::string(5000, 'y') +
              "\n{\"a\\u0007\": 1}\n50");
  const auto views = piped.rest();
  REQUIRE(views.size() == 2);
  CHECK(views[0] == Camera{.azimuth = 10, .zoom = 2});
  CHECK(views[1] == Camera{.azimuth = 50});
  REQUIRE(piped.warnings().size() == 4);
  CHECK_THAT(piped.warnings()[0], Catch::Matchers::StartsWith("skipped views, line 3: 'left\\x1b[2J right'"));
  CHECK_THAT(piped.warnings()[1], Catch::Matchers::Contains("views, line 6: the zoom is 0; hint: use more"));
  CHECK_THAT(piped.warnings()[2],
             Catch::Matchers::Contains("line 7: '" + std::string(60, 'y') + "...' has more than 4096 bytes"));
  CHECK_THAT(piped.warnings()[3], Catch::Matchers::Contains("line 8: 'a\\x07' is not azimuth"));
  CHECK_THROWS_WITH(
      piped.stream().check_all_was_read(),
      Catch::Matchers::Contains("4 of the lines give no view and were skipped; views rendered: 2"));
}

TEST_CASE("not every line of a flood of bad ones is warned of", "[threads]") {
  PipedStream piped;
  std::string text;
  for (int k = 0; k < 2000; ++k) text += "no\n";
  piped.write(text + "1 2\n");
  CHECK(piped.rest().size() == 1);
  REQUIRE(piped.warnings().size() == ViewStream::most_warnings + 1);
  CHECK_THAT(piped.warnings().back(), Catch::Matchers::Contains("only counted"));
  CHECK_THROWS_WITH(piped.stream().check_all_was_read(),
                    Catch::Matchers::Contains("2000 of the lines give no view"));
}

TEST_CASE("a stream without a view is no good input, nor is one that cannot be read", "[threads]") {
  PipedStream piped;
  CHECK(piped.rest().empty());
  CHECK_THROWS_WITH(piped.stream().check_all_was_read(), Catch::Matchers::Contains("no view came"));
  __gnu_cxx::stdio_filebuf<char> folder(open("/", O_RDONLY | O_CLOEXEC), std::ios::in);
  std::istream in(&folder);
  const auto stream = ViewStream::of(in, "views", {}, {[](const Camera&) {}, [](const std::string&) {}});
  while (stream->may_come()) usleep(200);
  CHECK_THROWS_WITH(stream->check_all_was_read(), Catch::Matchers::Contains("cannot be read"));
}
