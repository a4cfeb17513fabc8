#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat::app {

/// What --tf names: a preset, which is made to fit a volume's histogram, or a file.
class TransferFunctionChoice {
 public:
  /// Reads a file at once; throws InputError when `text` is neither a preset nor a readable transfer
  /// function.
  explicit TransferFunctionChoice(const std::string& text);
  TransferFunction make(const Histogram& histogram) const;

 private:
  std::string preset_;
  std::optional<TransferFunction> from_file_;
};

/// Why a frame without a splat shows nothing, and what to do about it: the transfer function and the volume's
/// values do not meet, no voxel has one of those values where they do, or all `visible_voxels`, which are or
/// may be visible, are outside.
std::string why_nothing_is_visible(const TransferFunction& tf, const ValueRange& range,
                                   std::uint64_t visible_voxels);

}  // namespace ringsplat::app
