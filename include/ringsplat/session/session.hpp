#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/net/processes.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "ringsplat/volume/strides.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

struct SessionOptions {
  int threads_per_rank = 1;   ///< threads that share a rank's work; they never call MPI
  double stall_timeout = 60;  ///< seconds until a frame without progress fails, or a late rank is named
  /// In one process: called now and then while a frame is made; may throw to end it.
  std::function<void()> poll = {};
  /// The first so many ranks have no blocks, but alone draw; the others never wait for a picture. All ranks
  /// pass the same. 0: all ranks do both.
  int visualisation_ranks = 0;
};

/// Renders a volume that lies in blocks on the processes of a job, as often as wanted.
///
///     ringsplat::Session session(comm);
///     session.set_grid(grid);
///     session.add_block(extent, pointer, strides);
///     session.commit();
///     ringsplat::Image image = session.render(spec);
///
/// The picture has the same bits for any blocks, ranks and layout, and those of `ringsplat render` for the
/// same volume in a file.
///
/// commit(), transfer_function() and render() are collective: all processes make the same calls in the same
/// order. What one of them got wrong, in any call, they throw as the same InputError on all; the session can
/// be used on, with the volume that was committed last. After a RunError (a rank is lost, or stalls) it
/// cannot. Where ranks are set aside to draw only commit() is collective: range() and transfer_function() are
/// theirs, and the others return from render() at once, without a picture.
///
/// Calls leave as they were: the communicator and its error handler, signal handlers, and the thread's
/// floating point environment (rounding, traps, flags, denormals).
class Session {
 public:
  /// `processes`: an MPI_Comm, or nothing for this process alone. Collective. Without a layout every rank
  /// that draws hosts a GP and a Renderer.
  explicit Session(Processes processes = {}, const std::optional<Layout>& layout = std::nullopt,
                   const SessionOptions& options = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  int rank() const;
  int ranks() const;
  /// This rank is set aside to draw.
  bool visualises() const;

  /// The whole volume's lattice and type, the same on all processes. Removes the blocks.
  void set_grid(const Grid& grid);
  /// Adds one of this process's blocks: the voxels `extent` of the grid, without ghosts. `first_voxel` is
  /// that of extent.first, a scalar of the grid's type in native byte order; without strides x is the fastest
  /// and there are no gaps. Nothing is read before commit(), which the memory must outlive. Returns the
  /// block's number, from 0.
  int add_block(const VoxelBox& extent, const void* first_voxel,
                const std::optional<Strides>& strides = std::nullopt);
  /// Where the block's voxels of the next time step lie; without strides as before. Without it commit() reads
  /// them again where they were. The next collective call throws InputError when there is no such block.
  void update_block(int block, const void* first_voxel, const std::optional<Strides>& strides = std::nullopt);
  /// Removes this process's blocks.
  void clear_blocks();

  /// Reads all blocks and hands their voxels to the GPs that own their slices. Blocks must cover the grid
  /// exactly once; else the error names a hole, or the blocks that overlap and where. A process holds at most
  /// its blocks, its slices and messages of 64 KiB in either direction.
  void commit();

  /// The smallest and the largest finite value of the committed volume, and how many there are.
  ValueRange range();
  /// A transfer function for the committed volume: a preset by name (preset_names()), or "auto".
  TransferFunction transfer_function(const std::string& name);

  /// Draws the committed volume; the frame is rank 0's, the others may pass anything. The image is returned
  /// on rank 0; elsewhere it is empty. What a view needs and none before did (another axis' slices, normals)
  /// is made by its first frame and kept until the next commit().
  Image render(const FrameSpec& frame);
  /// Draws one frame after another and hands rank 0 each image as soon as it is finished; faster than single
  /// calls, as frames overlap. What `take` throws leaves the call when the other frames are drawn, too.
  void render(const std::vector<FrameSpec>& frames, const std::function<void(Image&&)>& take);

 private:
  friend struct SessionParts;  // what other rooms may know of a session
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ringsplat
