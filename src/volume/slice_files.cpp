#include "volume/slice_files.hpp"

#include <algorithm>
#include <utility>

#include "volume/byte_order.hpp"
#include "volume/input_file.hpp"
#include "volume/limits.hpp"

namespace ringsplat::detail {
namespace {

class SliceFilesSource final : public VolumeSource {
 public:
  SliceFilesSource(const Grid& grid, SliceFiles slices)
      : grid_(grid), slices_(std::move(slices)), slices_per_file_(grid.dims.z / int(slices_.files.size())) {
    for (const auto& path : slices_.files)
      require_bytes(path, InputFile(path).size(), least_offset(), file_bytes());
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int z = first; z < first + count; ++z)
      read_slice(z, out.subspan(std::size_t(z - first) * bytes, bytes));
  }

 private:
  std::uint64_t file_bytes() const { return std::uint64_t(slices_per_file_) * grid_.slice_bytes(Axis::z); }
  std::uint64_t least_offset() const { return std::uint64_t(std::max<std::int64_t>(0, slices_.header_size)); }

  void read_slice(int z, std::span<std::byte> out) const {
    const InputFile file(slices_.files[std::size_t(z / slices_per_file_)]);
    // It may have become shorter since it was checked.
    require_bytes(file.path(), file.size(), least_offset(), file_bytes());
    const auto begin = slices_.header_size < 0 ? file.size() - file_bytes() : least_offset();
    file.read(begin + std::uint64_t(z % slices_per_file_) * out.size(), out);
    to_native_order(out, size_of(grid_.type), slices_.big_endian);
  }

  Grid grid_;
  SliceFiles slices_;
  int slices_per_file_;
};

}  // namespace

std::unique_ptr<VolumeSource> slice_files_source(const Grid& grid, SliceFiles slices) {
  return std::make_unique<SliceFilesSource>(grid, std::move(slices));
}

}  // namespace ringsplat::detail
