#include "formats/slice_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "formats/limits.hpp"
#include "formats/slice_by_slice.hpp"

namespace ringsplat::detail {
namespace {

class SliceFilesSource final : public SliceBySlice {
 public:
  SliceFilesSource(const Grid& volume, SliceFiles slices)
      : SliceBySlice(volume, slices.files,
                     {{"encoding", "raw, in several files"},
                      {"bytes before the voxels", fmt::format("{}", slices.header_size)},
                      {"byte order", slices.big_endian ? "big" : "little"}}),
        slices_(std::move(slices)),
        slices_per_file_(volume.dims.z / int(slices_.files.size())) {
    for (const auto& path : slices_.files)
      require_bytes(path, InputFile(path).size(), least_offset(), file_bytes());
  }

 private:
  std::uint64_t file_bytes() const { return std::uint64_t(slices_per_file_) * grid().slice_bytes(Axis::z); }
  std::uint64_t least_offset() const { return std::uint64_t(std::max<std::int64_t>(0, slices_.header_size)); }

  void read_slice(int z, std::span<std::byte> out) override {
    const auto& path = slices_.files[std::size_t(z / slices_per_file_)];
    require_unchanged(path);
    const InputFile file(path);
    const auto begin = slices_.header_size < 0 ? file.size() - file_bytes() : least_offset();
    file.read(begin + std::uint64_t(z % slices_per_file_) * out.size(), out);
    to_native_order(out, size_of(grid().type), slices_.big_endian);
  }

  SliceFiles slices_;
  int slices_per_file_;
};

}  // namespace

std::unique_ptr<VolumeSource> slice_files_source(const Grid& grid, SliceFiles slices) {
  return std::make_unique<SliceFilesSource>(grid, std::move(slices));
}

}  // namespace ringsplat::detail
