#include <algorithm>
#include <array>
#include <cstring>

#include "splat/voxel_run.hpp"

namespace ringsplat {
void pack(const float* rgba, std::size_t count, PackedVoxel* voxels) {
  // Words are computed together, which compilers vectorise.
  constexpr std::size_t together = 64;
  std::array<std::int32_t, 4 * together> words;
  for (; count > 0;) {
    const std::size_t some = std::min(count, together);
    for (std::size_t i = 0; i < 4 * some; ++i)
      words[i] =
          static_cast<std::int32_t>(rgba[i] * 65535.0F + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
    for (std::size_t k = 0; k < some; ++k) {
      std::memcpy(voxels[k].opacity, rgba + 4 * k + 3, sizeof voxels[k].opacity);
      for (std::size_t c = 0; c < 3; ++c) voxels[k].rgb[c] = static_cast<std::uint16_t>(words[4 * k + c]);
    }
    rgba += 4 * some;
    voxels += some;
    count -= some;
  }
}

}  // namespace ringsplat
