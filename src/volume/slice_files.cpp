#include "volume/slice_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "volume/byte_order.hpp"
#include "volume/input_file.hpp"
#include "volume/limits.hpp"
#include "volume/volume_files.hpp"

namespace ringsplat::detail {
namespace {

class SliceFilesSource final : public VolumeSource {
 public:
  SliceFilesSource(const Grid& grid, SliceFiles slices)
      : grid_(grid),
        slices_(std::move(slices)),
        slices_per_file_(grid.dims.z / int(slices_.files.size())),
        files_(slices_.files) {
    for (const auto& path : slices_.files)
      require_bytes(path, InputFile(path).size(), least_offset(), file_bytes());
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  Facts facts() const override {
    Facts facts = files_.facts();
    facts.insert(facts.begin(), {{"encoding", "raw, in several files"},
                                 {"bytes before the voxels", fmt::format("{}", slices_.header_size)},
                                 {"byte order", slices_.big_endian ? "big" : "little"}});
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    for (int z = first; z < first + count; ++z)
      read_slice(z, out.subspan(std::size_t(z - first) * bytes, bytes));
  }

 private:
  std::uint64_t file_bytes() const { return std::uint64_t(slices_per_file_) * grid_.slice_bytes(Axis::z); }
  std::uint64_t least_offset() const { return std::uint64_t(std::max<std::int64_t>(0, slices_.header_size)); }

  void read_slice(int z, std::span<std::byte> out) const {
    const auto& path = slices_.files[std::size_t(z / slices_per_file_)];
    files_.require_unchanged(path);
    const InputFile file(path);
    const auto begin = slices_.header_size < 0 ? file.size() - file_bytes() : least_offset();
    file.read(begin + std::uint64_t(z % slices_per_file_) * out.size(), out);
    to_native_order(out, size_of(grid_.type), slices_.big_endian);
  }

  Grid grid_;
  SliceFiles slices_;
  int slices_per_file_;
  VolumeFiles files_;
};

}  // namespace

std::unique_ptr<VolumeSource> slice_files_source(const Grid& grid, SliceFiles slices) {
  return std::make_unique<SliceFilesSource>(grid, std::move(slices));
}

}  // namespace ringsplat::detail
