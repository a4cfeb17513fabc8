#pragma once
#include <optional>
#include <string>
#include <vector>

#include "python/picture.hpp"
#include "ringsplat/session/session.hpp"

namespace ringsplat::python {

/// A session whose pictures are described by the command line's options. Calls are collective as a session's
/// are.
class BlockSession {
 public:
  /// `layout`: words for parse_layout(). Throws InputError on all ranks when one has a `problem` or wrong
  /// words.
  BlockSession(Processes processes, const std::vector<std::string>& layout, const SessionOptions& options,
               const std::string& problem);

  int rank() const { return session_.rank(); }
  int ranks() const { return session_.ranks(); }
  void set_grid(const Grid& grid, const VolumeNotes& notes);
  int add_block(const VoxelBox& extent, const void* first_voxel, const Strides& strides);
  void update_block(int block, const void* first_voxel, const Strides& strides);
  void clear_blocks();
  /// Has the next collective call throw it as InputError on all ranks.
  void note_problem(const std::string& problem);
  void commit();
  ValueRange range() { return session_.range(); }

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
