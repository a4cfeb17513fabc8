#pragma once
#include <optional>
#include <string>
#include <vector>

#include "python/picture.hpp"
#include "ringsplat/session/session.hpp"

namespace ringsplat::python {

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

 private:
  struct Request;
  Request request(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                  const ValueStatistics& values) const;

  Collectives& collectives_;  ///< the session's
  Session session_;
  Grid grid_, committed_;
  VolumeNotes notes_, committed_notes_;
};

}  // namespace ringsplat::python
