#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "ringsplat/base/bytes.hpp"

/// The seam between the protocol and what it carries. An engine makes payloads of slices (Encoder, on a GP),
/// tiles of payloads (Painter, on a Renderer) and a picture of tiles (Canvas, at the frame buffer). The
/// protocol knows only who may send what when: no voxel, no colour, no grid.
namespace ringsplat {

/// A frame as rank 0 announces it. Only engines read the body.
struct Announcement {
  std::int64_t frame = 0;
  Bytes body;
};

/// What the protocol needs to know of a frame; the same on every rank.
struct FramePlan {
  static constexpr int nobody = -1;
  struct Tile {
    int renderer = nobody;  ///< the Renderer that delivers it
    std::size_t bytes = 0;
  };
  bool ascending = true;    ///< whether slice numbers ascend from step to step
  std::vector<int> owners;  ///< by traversal step: the GP that has its slice, or its bundle of slices
  std::vector<Tile> tiles;
  /// What a Renderer has to do with layers of slices, which it draws for others' tiles.
  struct Share {
    int first = 0, end = 0;        ///< the steps whose slices it draws; none: it gets no token
    std::vector<int> takers = {};  ///< ascending: Renderers that deliver tiles of which it draws layers
  };
  std::vector<Share> shares;         ///< by Renderer; empty: each draws its own tiles, of all slices
  int first_slice = 0;               ///< number of the first step's slice, or of its bundle's first
  std::vector<int> slices_of_steps;  ///< where steps are bundles: how many slices each has; empty: one

  int slices() const {  ///< of all steps
    return slices_of_steps.empty() ? int(owners.size())
                                   : std::accumulate(slices_of_steps.begin(), slices_of_steps.end(), 0);
  }
  /// By Renderer: whether it draws anything. Those that do not get no token.
  std::vector<bool> drawing(int renderers) const {
    if (!shares.empty()) {
      std::vector<bool> has_steps;
      for (const Share& share : shares) has_steps.push_back(share.first < share.end);
      return has_steps;
    }
    std::vector<bool> has_tile(std::size_t(renderers), false);
    for (const Tile& tile : tiles)
      if (tile.renderer != nobody) has_tile[std::size_t(tile.renderer)] = true;
    return has_tile;
  }
};

/// One step's part for one Renderer.
struct EncodedPart {
  Bytes payload;             ///< made in Message::body_buffer(); empty: nothing to draw
  std::uint64_t items = 0;   ///< items in the payload; a Painter draws, clips or hides each
  std::uint64_t kept = 0;    ///< of these, ones that the Renderer keeps from earlier frames
  std::uint32_t passes = 0;  ///< non-empty (tile, pass) pairs (Neumann 1992, Fig. 3)
  std::vector<int> tiles;    ///< tiles with items, ascending
};

struct EncodeCounts {
  std::uint64_t voxels = 0;   ///< of the slice, transparent ones included
  std::uint64_t visible = 0;  ///< of these, visible ones
  std::uint64_t outside = 0;  ///< skipped, because they lie outside the image
  std::uint64_t blocks = 0;   ///< of the slice, looked through for what can be seen; splats have none
};

struct EncodedStep {
  std::vector<EncodedPart> parts;  ///< by Renderer
  EncodeCounts counts;
  int slices = 1;  ///< that were encoded
};

/// Makes a GP's payloads of one frame. Used by one thread.
class Encoder {
 public:
  virtual ~Encoder() = default;
  /// The steps that tokens go through, ascending; slices of other steps show nothing. The same on every GP.
  virtual std::vector<int> shown() = 0;
  /// Voxels of `steps` steps of this GP, all that are shown, when no Renderer has a tile.
  virtual std::uint64_t left_out(std::size_t steps) const = 0;
  /// Does a bounded piece of work that belongs to no step; false when there is none.
  virtual bool prepare() { return false; }
  /// Begins a step whose slice this GP owns.
  virtual void begin(int step) = 0;
  /// Does a bounded piece of the step (well under a millisecond a thread); true once the step is complete.
  virtual bool work() = 0;
  virtual EncodedStep finish() = 0;
  /// Takes what a Painter's news() wrote. Throws RunError when the bytes are no such news.
  virtual void take_news(std::span<const std::byte> news) = 0;
  /// Bytes of slices that the GP holds.
  virtual std::uint64_t slice_memory() const = 0;
};

struct ItemCounts {
  std::uint64_t drawn = 0, clipped = 0, hidden = 0;
  std::uint64_t kept = 0;     ///< of those drawn, ones that were kept from earlier frames
  std::uint64_t blocks = 0;   ///< of slices, looked through for what can be seen; splats have none
  std::uint64_t samples = 0;  ///< pixels of a slice that are composited, or of what lies between two slices
};

/// A payload for a Renderer to draw; `body` stays valid until then.
struct PayloadToDraw {
  int step = 0;
  std::uint32_t passes = 0;
  std::span<const std::byte> body = {};
};

/// Draws one frame's payloads on a Renderer, in the order of their steps. Used by one thread.
class Painter {
 public:
  virtual ~Painter() = default;
  /// While no payload is there: does a small piece of work that belongs to none; false when there is none.
  virtual bool prepare() { return false; }
  /// Begins a payload. Throws RunError when the bytes are no payload for this Renderer.
  virtual void begin(const PayloadToDraw& payload) = 0;
  /// Does a bounded piece of the payload on each thread; true once its memory and its slot may go to another.
  virtual bool work() = 0;
  /// Instead of drawing a payload, in a frame that nobody wants: takes what later payloads rely on. Throws as
  /// begin().
  virtual void skip(const PayloadToDraw&) {}
  /// Called until false, once all payloads are done: does a bounded piece of what they left to do.
  virtual bool conclude() { return false; }
  /// Appends to `news` what GP `gp` has not yet been told of this Renderer's tiles in this frame.
  virtual void news(int gp, Bytes& news) = 0;
  virtual ItemCounts counts() const = 0;  ///< of this frame so far
  /// Wall-clock seconds of compositing in this frame so far.
  virtual double composite_seconds() const { return 0; }
  /// Of layers (FramePlan::shares): what the given taker gets, once all is drawn; in a
  /// Message::body_buffer(), or empty.
  virtual Bytes hand_over(int) { return {}; }
  /// Takes what the given Renderer has handed over, which stays valid until finish() is done. Throws RunError
  /// when the bytes are no layers for this Renderer.
  virtual void gather(int, std::span<const std::byte>) {}
  /// Calls `deliver(tile, bytes)` for each tile that is not empty; the bytes come in a
  /// Message::body_buffer().
  virtual void finish(const std::function<void(int tile, Bytes bytes)>& deliver) = 0;
};

/// Assembles one frame's tiles at the frame buffer.
class Canvas {
 public:
  virtual ~Canvas() = default;
  /// Takes a tile. Each comes at most once, in any order; those that never come are empty.
  virtual void take(int tile, std::span<const std::byte> bytes) = 0;
  /// Makes the picture: no more tiles come.
  virtual void finish() = 0;
};

/// One rank's engine. Frames are asked for in ascending order.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual FramePlan plan(const Announcement& announcement) = 0;
  virtual std::unique_ptr<Encoder> encoder(int gp, const Announcement& announcement) = 0;
  /// Valid until the Renderer's next frame is asked for.
  virtual std::shared_ptr<Painter> painter(int renderer, const Announcement& announcement) = 0;
  virtual std::unique_ptr<Canvas> canvas(const Announcement& announcement) = 0;
};

}  // namespace ringsplat
