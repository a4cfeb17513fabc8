#include <algorithm>
#include <cmath>

#include "node/slice_encoder.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {
namespace {

/// Columns of a row whose positions lie within [low, high] along one screen axis.
struct ColumnInterval {
  double first, last;
  void clip(double start, double step, double low, double high) {
    if (step == 0) {
      if (start < low || start > high) last = first - 1;
      return;
    }
    const double a = (low - start) / step, b = (high - start) / step;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
};

/// Runs of voxels: positions follow from the view and are found again by the Renderer.
template <class Voxel>
class RunEncoder final : public SliceEncoder {
 public:
  RunEncoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers, EmptySpace& empty_space)
      : SliceEncoder(spec, geometry, renderers, empty_space), parts_(std::size_t(geometry.regions.count())) {}

 private:
  struct Part {
    std::vector<VoxelRun> runs;
    std::vector<Voxel> voxels;
  };

  void encode_row(int row) override {
    const auto columns = rows_.columns();
    const PixelWindow begin = window_of(columns.front()), end = window_of(columns.back());
    const PixelRect touched = geometry_.regions.touched(std::min(begin.x0, end.x0), std::min(begin.y0, end.y0), std::max(begin.x1, end.x1),
                                                        std::max(begin.y1, end.y1));
    for (int y = touched.y0; y < touched.y1; ++y) {
      for (int x = touched.x0; x < touched.x1; ++x) encode_part(y * geometry_.regions.columns() + x, row);
    }
  }

  PixelWindow window_of(std::uint32_t column) const {
    const glm::dvec3 position = dda_.position(column);
    return pixel_window(anchor(position.x, position.y), reach_);
  }

  /// The row's visible voxels whose windows can meet the region. A voxel too many is clipped by the painter.
  void encode_part(int region, int row) {
    const auto columns = rows_.columns();
    const PixelRect rect = geometry_.regions.rect(region);
    const glm::dvec3 start = dda_.position(0), step = geometry_.view.linear[in_plane(geometry_.traversal.axis).u];
    ColumnInterval interval{double(columns.front()), double(columns.back())};
    // A window meets pixels x0 … x1 − 1 when its position is at most reach + ½ beyond them; the rest is for rounding.
    constexpr double beyond = 0.51;
    interval.clip(start.x, step.x, rect.x0 - double(reach_.x) - beyond, rect.x1 + double(reach_.x) + beyond);
    interval.clip(start.y, step.y, rect.y0 - double(reach_.y) - beyond, rect.y1 + double(reach_.y) + beyond);
    if (!(interval.first <= interval.last)) return;
    const auto first = std::lower_bound(columns.begin(), columns.end(), static_cast<std::uint32_t>(std::ceil(interval.first)));
    const auto last = std::upper_bound(first, columns.end(), static_cast<std::uint32_t>(std::floor(interval.last)));
    append(region, row, int(first - columns.begin()), int(last - columns.begin()));
  }

  /// Appends the row's visible voxels begin … end − 1, those that are not hidden, run by run.
  void append(int region, int row, int begin, int end) {
    const auto columns = rows_.columns();
    const bool culling = knows_opaque(region);
    const auto left_out = [&](int k) { return culling && hidden(region, window_of(columns[std::size_t(k)])); };
    for (int k = begin; k < end;) {
      if (left_out(k)) {
        ++k;
        continue;
      }
      int next = k + 1;
      while (next < end && columns[std::size_t(next)] == columns[std::size_t(next - 1)] + 1 && !left_out(next)) ++next;
      append_run(region, row, k, next - k);
      k = next;
    }
  }

  void append_run(int region, int row, int begin, int voxels) {
    Part& part = parts_[std::size_t(region)];
    const std::uint32_t first = rows_.columns()[std::size_t(begin)];
    part.runs.push_back({std::uint32_t(row), first, std::uint32_t(voxels)});
    const std::size_t at = part.voxels.size();
    part.voxels.resize(at + std::size_t(voxels));
    for (int k = 0; k < voxels; ++k) {
      const ClassifiedSample sample = rows_.shaded(begin + k);
      pack(sample.r, sample.g, sample.b, sample.opacity, part.voxels[at + std::size_t(k)]);
    }
    count_run(region, int(first), voxels, row);
  }

  std::size_t part_bytes(int region) const override {
    const Part& part = parts_[std::size_t(region)];
    return sizeof(RunGroup) + part.runs.size() * sizeof(VoxelRun) + part.voxels.size() * sizeof(Voxel);
  }

  void move_part(int region, Bytes& payload) override {
    Part& part = parts_[std::size_t(region)];
    ringsplat::append(payload, RunGroup{region, std::uint32_t(part.runs.size()), std::uint32_t(part.voxels.size())});
    const auto bytes = [&](const auto& values) {
      const auto raw = std::as_bytes(std::span(values));
      payload.insert(payload.end(), raw.begin(), raw.end());
    };
    bytes(part.runs);
    bytes(part.voxels);
    part.runs.clear();
    part.voxels.clear();
  }

  std::vector<Part> parts_;  ///< by region
};

}  // namespace

std::unique_ptr<Encoder> make_run_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                          EmptySpace& empty_space) {
  switch (spec.precision) {
    case Precision::half: return std::make_unique<RunEncoder<HalfVoxel>>(spec, geometry, renderers, empty_space);
    case Precision::u8: return std::make_unique<RunEncoder<ByteVoxel>>(spec, geometry, renderers, empty_space);
    case Precision::float32: break;
  }
  return std::make_unique<RunEncoder<FloatVoxel>>(spec, geometry, renderers, empty_space);
}

}  // namespace ringsplat
