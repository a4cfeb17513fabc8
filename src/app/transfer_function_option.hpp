#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat::app {

/// The choice of --tf: a preset, fitted to the volume's histogram, or a file.
class TransferFunctionChoice {
 public:
  /// Reads a file immediately. Throws InputError when `text` is neither a preset nor a readable transfer
  /// function.
  explicit TransferFunctionChoice(const std::string& text);
  TransferFunction make(const Histogram& histogram) const;

 private:
  std::string preset_;
  std::optional<TransferFunction> from_file_;
};

/// Explains why a frame without splats shows nothing, and what to do: the transfer function's visible values
/// lie outside the volume's range, no voxel has such a value, or all `visible_voxels` (an upper bound) lie
/// outside the picture.
std::string why_nothing_is_visible(const TransferFunction& tf, const ValueRange& range,
                                   std::uint64_t visible_voxels);

}  // namespace ringsplat::app
