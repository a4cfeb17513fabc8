#pragma once
#include <cstddef>
#include <memory>

namespace ringsplat {

struct FreeAlignedFloats {
  void operator()(float* floats) const;
};
/// Floats of which the first is aligned for any vector, 64 bytes at least.
using AlignedFloats = std::unique_ptr<float[], FreeAlignedFloats>;

/// Leaves the floats uninitialised. Throws std::bad_alloc.
AlignedFloats allocate_floats(std::size_t count);

}  // namespace ringsplat
