#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ringsplat/live/live.hpp"
#include "ringsplat/session/session.hpp"
#include "words/actions.hpp"
#include "words/picture.hpp"

namespace ringsplat::words {

/// A session whose pictures are described by the command line's options.
class BlockSession {
 public:
  /// `layout`: words for parse_layout(). Throws InputError on all ranks when one has a `problem` or wrong
  /// words.
  BlockSession(Processes processes, const std::vector<std::string>& layout, const SessionOptions& options,
               const std::string& problem);

  /// For its blocks and what else has nothing to do with pictures.
  Session& session() { return session_; }

  void set_grid(const Grid& grid, const VolumeNotes& notes);
  void commit();

  /// Rank 0's words and views count. The pictures are returned on rank 0.
  std::vector<Picture> render(const std::vector<std::string>& words,
                              const std::vector<app::ViewAngles>& views, const Hooks& hooks);

  /// The same, of one view, which rank 0 writes to a file.
  void draw(const std::vector<std::string>& words, const std::string& file);

  /// Draws the pictures that a file asks for (words/actions.hpp) after a step, of the blocks as they are now:
  /// they are committed when there are any. What is wrong with one is warned of. Collective.
  void act(const std::string& file, std::int64_t step);

  /// Shows the volume in browsers from now on; `words` say what is seen first. Returns the page's address on
  /// rank 0. All ranks pass the same.
  std::string serve(const std::vector<std::string>& words, LiveOptions options);
  /// What is served. Throws InputError when nothing is.
  Live& live();
  /// A number that pages may change, kept here.
  void offer(const std::string& name, double value, double low, double high);
  /// As Live::show(). Returns the numbers that are offered, by name.
  std::vector<std::pair<std::string, double>> show(std::int64_t step, double time);

 private:
  /// What is wanted drawn.
  struct Request {
    app::RenderOptions options;
    std::vector<FrameSpec> frames;
    std::optional<app::Annotation> annotation;
  };

  Request request(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                  const ValueStatistics& values) const;

  Collectives& collectives_;  ///< the session's
  Session session_;
  Grid grid_, committed_;
  VolumeNotes notes_, committed_notes_;
  std::deque<std::pair<std::string, double>> offered_;  ///< at addresses that last
  std::optional<Live> live_;
  std::map<std::string, Actions> actions_;  ///< by file
};

}  // namespace ringsplat::words
