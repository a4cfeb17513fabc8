#pragma once
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "ringsplat/live/live.hpp"
#include "ringsplat/session/session.hpp"
#include "words/picture.hpp"

namespace ringsplat::words {

/// A picture that is wanted now and then.
struct Action {
  std::string name;  ///< the section's
  std::int64_t every = 1, first = 0;
  std::string file = {};                ///< {step}: the step's number in six digits
  std::vector<std::string> words = {};  ///< for parse_picture()
};

/// Of a TOML file: a section is a picture, its keys `every`, `first` and `file`, the others options of
/// `ringsplat render`. Throws InputError.
std::vector<Action> parse_actions(const std::string& text);

/// Pictures that a file asks for, which may be changed while a program runs: as Ascent's actions (Larsen et
/// al. 2022).
class Actions {
 public:
  explicit Actions(std::filesystem::path path) : path_(std::move(path)) {}

  /// Those that the file has now and that are due after a step, with the files that they are written to:
  /// beside it where they are relative. What is wrong in it is warned of, and what it said before counts.
  std::vector<Action> due(std::int64_t step);
  /// Warns, unless of the same as the last time.
  void warn(const std::string& what);

 private:
  std::filesystem::path path_;
  std::string text_, warned_;  ///< as they were last
  std::vector<Action> actions_;
};

/// A session whose pictures are described by the command line's options.
class BlockSession {
 public:
  /// `layout`: words for parse_layout(). Throws InputError on all ranks when one has a `problem` or wrong
  /// words.
  BlockSession(Processes processes, const std::vector<std::string>& layout, const SessionOptions& options,
               const std::string& problem);

  /// For its blocks and what else has nothing to do with pictures.
  Session& session() { return session_; }

  void set_grid(const Grid& grid, const VolumeNotes& notes) {
    check(grid, "the grid");
    session_.set_grid(grid);
    notes_ = notes;
  }
  void commit() {
    session_.commit();
    committed_notes_ = notes_;
  }

  /// Rank 0's words and views count. The pictures are returned on rank 0.
  std::vector<Picture> render(const std::vector<std::string>& words,
                              const std::vector<app::ViewAngles>& views, const Hooks& hooks);

  /// The same, of one view, which rank 0 writes to a file.
  void draw(const std::vector<std::string>& words, const std::string& file);

  /// Draws the pictures that a file asks for after a step, of the blocks as they are now:
  /// they are committed when there are any. What is wrong with one is warned of. Collective.
  void act(const std::string& file, std::int64_t step);

  /// Shows the volume in browsers from now on; `words` say what is seen first. Returns the page's address on
  /// rank 0. All ranks pass the same.
  std::string serve(const std::vector<std::string>& words, LiveOptions options);
  /// What is served. Throws InputError when nothing is.
  Live& live() {
    if (!live_) throw InputError("nothing is served", "call serve() first");
    return *live_;
  }
  /// A number that pages may change, or the number of one of `choices`, kept here.
  void offer(const std::string& name, double value, double low, double high,
             const std::optional<std::vector<std::string>>& choices);
  /// As Live::show(). Returns the numbers that are offered, by name.
  std::vector<std::pair<std::string, double>> show(std::int64_t step, double time) {
    live().show(step, time);
    return {offered_.begin(), offered_.end()};
  }

 private:
  /// What is wanted drawn.
  struct Request {
    app::RenderOptions options;
    std::vector<FrameSpec> frames;
    std::optional<app::Annotation> annotation;
  };

  Request request(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                  const ValueStatistics& values) const;

  Session session_;
  VolumeNotes notes_, committed_notes_;
  std::deque<std::pair<std::string, double>> offered_;  ///< at addresses that last
  std::optional<Live> live_;
  std::map<std::string, Actions> actions_;  ///< by file
};

}  // namespace ringsplat::words
