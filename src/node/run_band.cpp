#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>

#include "node/row_band.hpp"
#include "node/voxel_form.hpp"
#include "ringsplat/splat/voxel_run.hpp"

namespace ringsplat {
namespace {

/// Half-open range of a row's columns.
struct Columns {
  std::uint32_t first, end;
  bool empty() const { return first >= end; }
};

/// A row's positions along one screen axis.
class RowAxis {
 public:
  /// `step`: from column to column.
  explicit RowAxis(double step) : inverse_(1 / step) {}
  void begin_row(double start) { start_ = start; }
  /// Those of the columns whose positions lie within [low, high].
  Columns within(double low, double high, Columns columns) const {
    if (!std::isfinite(inverse_)) return start_ >= low && start_ <= high ? columns : Columns{0, 0};
    const double a = (low - start_) * inverse_, b = (high - start_) * inverse_;
    const double first = std::max(std::min(a, b), double(columns.first)),
                 last = std::min(std::max(a, b), double(columns.end) - 1);
    if (!(first <= last)) return {0, 0};
    const auto truncated = static_cast<std::uint32_t>(static_cast<std::int64_t>(first));
    return {truncated + (double(truncated) < first),
            static_cast<std::uint32_t>(static_cast<std::int64_t>(last)) + 1};
  }
  /// Whether positions fall from column to column.
  bool falls() const { return inverse_ < 0; }

 private:
  double inverse_, start_ = 0;
};

/// Runs of voxels: positions follow from the view and are found again by the Renderer.
template <class Voxel>
class RunBand final : public RowBand {
 public:
  explicit RunBand(const EncoderFrame& frame)
      : RowBand(frame),
        x_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].x),
        y_(geometry_.view.linear[in_plane(geometry_.traversal.axis).u].y),
        beyond_(double(reach_.x) + 0.51, double(reach_.y) + 0.51),
        parts_(frame.rects.size()) {}

 private:
  /// Written whole right after it grows.
  template <class T>
  using Buffer = std::vector<T, UninitialisedAllocator<T>>;
  struct Part {
    Buffer<VoxelRun> runs;
    Buffer<Voxel> voxels;
  };

  void encode_row(int row) override {
    const auto runs = rows_.runs();
    const Columns all{runs.front().first, runs.back().end()};
    const PixelWindow window = window_of(all.first, all.end - 1);
    const PixelRect touched = geometry_.regions.touched(window.x0, window.y0, window.x1, window.y1);
    x_.begin_row(dda_.row_start().x);
    y_.begin_row(dda_.row_start().y);
    for (int y = touched.y0; y < touched.y1; ++y) {
      const int first_region = y * geometry_.regions.columns();
      const PixelRect& pixels = rect(first_region);
      const Columns columns = y_.within(double(pixels.y0) - beyond_.y, double(pixels.y1) + beyond_.y, all);
      if (columns.empty()) continue;
      // In the order of the columns, so that the search for runs goes on where it was.
      next_run_ = std::partition_point(runs.begin(), runs.end(),
                                       [&](const VisibleRun& run) { return run.end() <= columns.first; });
      for (int k = 0; k < touched.width(); ++k) {
        const int x = x_.falls() ? touched.x1 - 1 - k : touched.x0 + k;
        encode_part(first_region + x, row, columns);
      }
    }
  }

  /// The row's visible voxels whose windows can meet the region. A voxel too many is clipped by the painter.
  void encode_part(int region, int row, Columns columns) {
    const PixelRect& pixels = rect(region);
    columns = x_.within(double(pixels.x0) - beyond_.x, double(pixels.x1) + beyond_.x, columns);
    if (!columns.empty()) append(region, row, columns);
  }

  /// Of the voxels in columns first … last: positions run straight.
  PixelWindow window_of(std::uint32_t first, std::uint32_t last) const {
    const PixelWindow a = window_of(first), b = window_of(last);
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
  }
  PixelWindow window_of(std::uint32_t column) const {
    const glm::dvec3 position = dda_.position(column);
    return pixel_window(anchor(position.x, position.y), reach_);
  }

  /// Of the windows of the voxels in columns first … last, whose positions run straight; wider by a rounding.
  OpaqueCover::Cover cover_of(int region, std::uint32_t first, std::uint32_t last) const {
    constexpr double rounding = 1e-6;
    const PixelRect& pixels = rect(region);
    const double x = dda_.row_start().x - pixels.x0 - 0.5, y = dda_.row_start().y - pixels.y0 - 0.5;
    const double xa = x + dda_.steps_x()[first], xb = x + dda_.steps_x()[last];
    const double ya = y + dda_.steps_y()[first], yb = y + dda_.steps_y()[last];
    const double before_x = double(reach_.x) + rounding, before_y = double(reach_.y) + rounding;
    return cover(region).of(std::min(xa, xb) - before_x, std::min(ya, yb) - before_y,
                            std::max(xa, xb) + before_x + 1, std::max(ya, yb) + before_y + 1);
  }

  /// Appends the row's visible voxels in these columns, those that are not hidden, run by run.
  void append(int region, int row, Columns columns) {
    const auto end = rows_.runs().end();
    while (next_run_ != end && next_run_->end() <= columns.first) ++next_run_;
    const bool culling = cover(region).worth_asking();
    kept_begin_ = kept_end_ = 0;
    for (auto run = next_run_; run != end && run->first < columns.end; ++run) {
      const std::uint32_t from = std::max(run->first, columns.first), to = std::min(run->end(), columns.end);
      if (culling)
        append_seen(region, row, *run, from, to);
      else
        append_run(region, row, *run, from, to);
    }
    pack_kept(region);
  }

  /// Those of a run's columns begin … end − 1 that are not hidden. Halves what is hidden in part only.
  void append_seen(int region, int row, const VisibleRun& run, std::uint32_t begin, std::uint32_t end) {
    const OpaqueCover::Cover seen = cover_of(region, begin, end - 1);
    if (seen == OpaqueCover::Cover::all) return;
    if (seen == OpaqueCover::Cover::none || end - begin == 1) {
      append_run(region, row, run, begin, end);
      return;
    }
    const std::uint32_t middle = begin + (end - begin) / 2;
    append_seen(region, row, run, begin, middle);
    append_seen(region, row, run, middle, end);
  }

  void append_run(int region, int row, const VisibleRun& run, std::uint32_t begin, std::uint32_t end) {
    auto& runs = parts_[std::size_t(region)].runs;
    if (!runs.empty() && runs.back().row == std::uint32_t(row) &&
        runs.back().first + runs.back().count == begin)
      runs.back().count += end - begin;
    else
      runs.push_back({std::uint32_t(row), begin, end - begin});
    count_run(region, int(begin), int(end - begin));
    const std::uint32_t sample = run.sample + (begin - run.first);
    if (sample != kept_end_) {
      pack_kept(region);
      kept_begin_ = sample;
    }
    kept_end_ = sample + (end - begin);
  }

  /// Packs the row's samples kept_begin_ … kept_end_ − 1, of runs that the part already has.
  void pack_kept(int region) {
    if (kept_begin_ == kept_end_) return;
    auto& voxels = parts_[std::size_t(region)].voxels;
    const auto samples = rows_.samples().subspan(kept_begin_, kept_end_ - kept_begin_);
    const std::size_t at = voxels.size();
    voxels.resize(at + samples.size());
    pack(&samples.front().r, samples.size(), voxels.data() + at);
  }

  std::size_t part_bytes(int region) const override {
    const Part& part = parts_[std::size_t(region)];
    return sizeof(RunGroup) + part.runs.size() * sizeof(VoxelRun) + part.voxels.size() * sizeof(Voxel);
  }

  void append_parts(int region, std::span<const std::unique_ptr<RowBand>> bands, Bytes& payload) override {
    const auto part_of = [region](const std::unique_ptr<RowBand>& band) -> Part& {
      return static_cast<RunBand&>(*band).parts_[std::size_t(region)];
    };
    RunGroup group{region, 0, 0};
    for (const auto& band : bands) {
      group.runs += std::uint32_t(part_of(band).runs.size());
      group.voxels += std::uint32_t(part_of(band).voxels.size());
    }
    ringsplat::append(payload, group);
    for (const auto& band : bands) move_values(part_of(band).runs, payload);
    for (const auto& band : bands) move_values(part_of(band).voxels, payload);
  }

  static void move_values(auto& values, Bytes& payload) {
    const auto raw = std::as_bytes(std::span(values));
    const std::size_t at = payload.size();
    payload.resize(at + raw.size());
    std::copy(raw.begin(), raw.end(), payload.begin() + std::ptrdiff_t(at));
    values.clear();
  }

  RowAxis x_, y_;
  /// A window meets pixels x0 … x1 − 1 when its position is at most reach + ½ beyond them; the rest is for
  /// rounding.
  glm::dvec2 beyond_;
  std::span<const VisibleRun>::iterator next_run_;  ///< the row's first that later regions can have
  std::vector<Part> parts_;                         ///< by region
  std::uint32_t kept_begin_ = 0,
                kept_end_ = 0;  ///< the row's samples that are still to be packed for a region
};

}  // namespace

std::unique_ptr<RowBand> make_run_band(const EncoderFrame& frame) {
  return make_for_voxels<RowBand, RunBand>(frame.spec.precision, frame);
}

}  // namespace ringsplat
