#pragma once
#include <functional>
#include <span>
#include <vector>

#include "engine_parts/frame_engine.hpp"
#include "protocol/engine.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// What Renderers have to do with a frame's layers, when drawers and tiles are known. A layer's
/// slabs lie behind its slices, the first layer's also before its first; they are drawn with slices up to
/// SheetFrame::reach() away.
std::vector<FramePlan::Share> shares_of_layers(const SheetFrame& frame, int renderers);

/// Appends what one Renderer has drawn of the layers of the tiles that another one delivers: pixels that are
/// not transparent, as halves, 8 bytes each.
void append_layers(const SheetFrame& frame, OwnedImages& images, int tiles_of, Bytes& out);

/// Layers of a Renderer's tiles, composited from the front: C += (1 − A) c, A += (1 − A) a, in floats, pixels
/// below the frame's threshold being final. A picture depends on its layers, not on who drew them.
class LayerSum {
 public:
  /// `frame` must outlive the calls below.
  void begin_frame(const SheetFrame& frame, int renderer);
  /// Takes what append_layers() wrote, which must outlive deliver(). Throws RunError when it is no such
  /// thing.
  void add(std::span<const std::byte> bytes);
  /// As Painter::finish().
  void deliver(const std::function<void(int tile, Bytes bytes)>& deliver);

 private:
  /// A region's pixels in a layer.
  struct Piece {
    int tile, order;  ///< order: of its layer, from the front
    std::span<const std::byte> runs;
  };
  void composite(const Piece& piece, std::span<float> rgba) const;

  const SheetFrame* frame_ = nullptr;
  int renderer_ = 0;
  std::vector<Piece> pieces_;
};

}  // namespace ringsplat
