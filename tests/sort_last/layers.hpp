#pragma once
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::sort_last {

struct LayersSetup {
  VolumeSource& source;
  std::optional<Machine> machine;
  double low, high;      ///< the whole volume's values lie between them
  int slices = 16;       ///< of a layer
  bool halves = true;    ///< how pixels of layers travel; the finished ones are floats
  double per_byte = 0;   ///< seconds charged for each byte of floats that is composited or put together
  double per_pixel = 0;  ///< and for each pixel of an own picture that is looked at
};

/// What a frame took on this rank.
struct LayersDrawn {
  double painting = 0, items = 0, pixels = 0, messages = 0, bytes = 0;
};

/// Sheets drawn in layers of a fixed number of slices. Each layer is a premultiplied picture of its own,
/// whoever draws it, and pixels are composited layer by layer, so the picture has the same bits on any number
/// of ranks. Ranks draw runs of a layer's regions that cost the same; what is in them goes straight to the
/// ranks that own these regions of the picture, which composite it and send it to rank 0.
class Layers {
 public:
  virtual ~Layers() = default;
  /// On rank 0 `picture` is the frame's afterwards.
  virtual LayersDrawn draw(const FrameSpec& spec, Image& picture) = 0;
  virtual std::uint64_t slice_memory() const = 0;
};

/// Side of a region, in pixels; frames must have regions of this size.
inline constexpr int layer_region = 16;

/// Deals layers and regions by what a frame of `spec` costs; later frames must traverse the same axis.
std::unique_ptr<Layers> make_layers(const LayersSetup& setup, const FrameSpec& spec, MPI_Comm comm);

}  // namespace ringsplat::sort_last
