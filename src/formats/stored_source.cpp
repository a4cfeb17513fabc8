#include "formats/stored_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "formats/inflate_stream.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

class StoredSource final : public VolumeSource {
 public:
  StoredSource(const Grid& grid, StoredVoxels stored)
      : grid_(grid), stored_(std::move(stored)), file_(stored_.file) {
    const auto bytes = std::uint64_t(grid.voxels()) * size_of(stored_.type);
    if (stored_.compressed)
      require_compressed_bytes(stored_.file, file_.size() - std::min(file_.size(), stored_.offset), bytes,
                               deflate_best_ratio);
    else
      require_bytes(stored_.file, file_.size(), stored_.offset, bytes);
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return !stored_.compressed; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    if (!stored_.rescale) return read_stored(first, count, out);
    const auto values = grid_.slice_voxels(Axis::z) * std::size_t(count);
    std::vector<std::byte> raw(values * size_of(stored_.type));
    read_stored(first, count, raw);
    apply(*stored_.rescale, stored_.type, raw, grid_.type, out);
  }

  Facts facts() const override {
    Facts facts{{"encoding", stored_.compressed ? "compressed" : "raw"},
                {"stored type", to_string(stored_.type)}};
    if (size_of(stored_.type) > 1) facts.push_back({"byte order", stored_.big_endian ? "big" : "little"});
    if (stored_.rescale)
      facts.push_back({"rescaling", fmt::format("slope {}, intercept {}", stored_.rescale->slope,
                                                stored_.rescale->intercept)});
    facts.push_back({"offset", fmt::format("{} bytes", stored_.offset)});
    const auto voxel_bytes = std::uint64_t(grid_.voxels()) * size_of(stored_.type);
    add_facts_of(file_, stored_.offset, stored_.compressed ? file_.size() - stored_.offset : voxel_bytes,
                 facts);
    return facts;
  }

 private:
  void read_stored(int first, int count, std::span<std::byte> out) {
    const auto slice_bytes = grid_.slice_voxels(Axis::z) * size_of(stored_.type);
    const auto wanted = out.first(std::size_t(count) * slice_bytes);
    const auto position = std::uint64_t(first) * slice_bytes;
    if (stored_.compressed)
      decode(stored_.skip + position, wanted);
    else
      file_.read(stored_.offset + position, wanted);
    file_.require_unchanged();
    to_native_order(wanted, size_of(stored_.type), stored_.big_endian);
  }

  void decode(std::uint64_t position, std::span<std::byte> out) {
    if (!stream_ || stream_->position() > position)
      stream_ = std::make_unique<InflateStream>(file_, stored_.offset);
    stream_->skip(position - stream_->position());
    stream_->read(out);
    const auto voxel_bytes = std::uint64_t(grid_.voxels()) * size_of(stored_.type);
    if (position + out.size() == stored_.skip + voxel_bytes) stream_->verify_end();
  }

  Grid grid_;
  StoredVoxels stored_;
  InputFile file_;
  std::unique_ptr<InflateStream> stream_;
};

}  // namespace

void apply(const Rescale& rescale, ScalarType from, std::span<const std::byte> in, ScalarType to,
           std::span<std::byte> out) {
  visit_type(from, [&](auto stored) {
    visit_type(to, [&](auto wanted) {
      using Stored = decltype(stored);
      using Wanted = decltype(wanted);
      const auto* values = reinterpret_cast<const Stored*>(in.data());
      auto* results = reinterpret_cast<Wanted*>(out.data());
      for (std::size_t i = 0; i < in.size() / sizeof(Stored); ++i)
        results[i] = Wanted(rescale.slope * double(values[i]) + rescale.intercept);
    });
  });
}

std::unique_ptr<VolumeSource> stored_source(const Grid& grid, StoredVoxels stored) {
  return std::make_unique<StoredSource>(grid, std::move(stored));
}

}  // namespace ringsplat::detail
