#include "formats/stored_source.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t most_read = 1 << 20;  // bytes at a time

class TransposedSource final : public VolumeSource {
 public:
  TransposedSource(const Grid& grid, const std::filesystem::path& file, std::uint64_t offset, bool big_endian,
                   std::uint64_t most_held)
      : grid_(grid), file_(file), offset_(offset), big_endian_(big_endian) {
    require_bytes(file, file_.size(), offset, grid.bytes());
    const auto slices = most_held / std::max<std::uint64_t>(1, grid.slice_bytes(Axis::z));
    depth_ = int(std::clamp<std::uint64_t>(slices, 1, std::uint64_t(grid.dims.z)));
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return false; }
  int layer_depth() const override { return depth_; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int z = first; z < first + count; ++z) {
      hold(z / depth_);
      std::memcpy(out.data() + std::size_t(z - first) * bytes, held_.data() + std::size_t(z % depth_) * bytes,
                  bytes);
    }
  }

  Facts facts() const override {
    Facts facts{{"encoding", "raw, z fastest"}, {"byte order", big_endian_ ? "big" : "little"}};
    add_facts_of(file_, offset_, grid_.bytes(), facts);
    return facts;
  }

 private:
  /// Reads all columns along z within a layer, many at once where they are short.
  void hold(int layer) {
    if (layer == held_layer_) return;
    const auto size = size_of(grid_.type);
    const int first = layer * depth_, count = std::min(depth_, grid_.dims.z - first);
    const auto column = std::uint64_t(grid_.dims.z) * size;
    const auto columns = std::uint64_t(grid_.dims.x) * std::uint64_t(grid_.dims.y);
    const auto step = std::clamp<std::uint64_t>(most_read / column, 1, columns);
    held_layer_ = -1;
    held_.resize(std::size_t(count) * grid_.slice_bytes(Axis::z));
    std::vector<std::byte> window;
    for (std::uint64_t begin = 0; begin < columns; begin += step) {
      const auto end = std::min(begin + step, columns);
      window.resize(std::size_t((end - begin - 1) * column) + std::size_t(count) * size);
      file_.read(offset_ + begin * column + std::uint64_t(first) * size, window);
      for (auto at = begin; at < end; ++at)
        scatter(at, std::span(window).subspan(std::size_t((at - begin) * column), std::size_t(count) * size));
    }
    file_.require_unchanged();
    to_native_order(held_, size, big_endian_);
    held_layer_ = layer;
  }

  /// `number`: y + dims.y * x.
  void scatter(std::uint64_t number, std::span<const std::byte> column) {
    const auto size = size_of(grid_.type), slice = grid_.slice_voxels(Axis::z);
    const auto x = number / std::uint64_t(grid_.dims.y), y = number % std::uint64_t(grid_.dims.y);
    auto to = std::size_t(x + y * std::uint64_t(grid_.dims.x));
    for (std::size_t at = 0; at < column.size(); at += size, to += slice)
      std::memcpy(held_.data() + to * size, column.data() + at, size);
  }

  Grid grid_;
  InputFile file_;
  std::uint64_t offset_;
  bool big_endian_;
  int depth_ = 1, held_layer_ = -1;
  std::vector<std::byte> held_;
};

}  // namespace

std::unique_ptr<VolumeSource> transposed_source(const Grid& grid, const std::filesystem::path& file,
                                                std::uint64_t offset, bool big_endian,
                                                std::uint64_t most_held) {
  return std::make_unique<TransposedSource>(grid, file, offset, big_endian, most_held);
}

}  // namespace ringsplat::detail
