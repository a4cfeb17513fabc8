#include "sort_last/section_painter.hpp"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "classify/normals.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/charge.hpp"
#include "simulate/meter.hpp"
#include "splat_engine/splat_engine.hpp"
#include "volume/clipped.hpp"

namespace ringsplat::sort_last {
namespace {

VoxelBox box_of(const Grid& grid, const Section& section) {
  VoxelBox box = whole_box(grid);
  box.first.z = section.first;
  box.end.z = section.end;
  return box;
}

SliceStore read_section(VolumeSource& source, const Section& section, bool with_normals) {
  const Grid& whole = source.grid();
  const Grid grid = clipped_grid(whole, box_of(whole, section));
  SliceStore store(grid, 0, 1, {false, false, true}, with_normals);
  store.know_normals_within(whole_box(grid));
  const std::size_t bytes = whole.slice_bytes(Axis::z);
  std::vector<std::byte> below(bytes), here(bytes), above(bytes);
  const auto read = [&](int z, std::vector<std::byte>& slice) {
    if (z >= 0 && z < whole.dims.z) source.read_slices(z, 1, slice);
  };
  if (with_normals) read(section.first - 1, below);
  read(section.first, here);
  for (int z = section.first; z < section.end; ++z) {
    if (with_normals || z + 1 < section.end) read(z + 1, above);
    const int local = z - section.first;
    std::memcpy(store.values(Axis::z, local).data(), here.data(), bytes);
    // As in the whole volume: the section's faces are none of its own.
    if (with_normals)
      slice_normals(whole, z > 0 ? below.data() : nullptr, here.data(),
                    z + 1 < whole.dims.z ? above.data() : nullptr, store.normals(Axis::z, local));
    std::swap(below, here);
    std::swap(here, above);
  }
  return store;
}

class SplatSection final : public SectionPainter {
 public:
  SplatSection(const SectionSetup& setup, bool with_normals)
      : setup_(setup), whole_(setup.source.grid()), painter_(make_splat_painter(0, threads_)) {
    if (section().slices() > 0) store_ = read_section(setup.source, section(), with_normals);
  }

  Drawn draw(const FrameSpec& spec, Image& picture) override {
    const auto& machine = setup_.machine;
    Drawn drawn;
    drawn.costs.resize(std::size_t(whole_.dims.z));
    if (section().slices() < 1) return drawn;
    if (machine) charge(machine->gp.frame + machine->renderer.frame);
    const auto frame = frame_of(spec);
    // A described machine's costs are those of looking at every voxel.
    const auto encoder = make_splat_encoder(frame, 1, store_, space_, threads_, !machine);
    const Meter meter = machine ? make_splat_meter(frame) : nullptr;
    painter_->begin_frame(frame);
    for (const int step : encoder->shown()) {
      encoder->begin(step);
      while (!encoder->work()) continue;
      const EncodedStep encoded = encoder->finish();
      const double samples = meter ? double(meter(step, encoded.parts).front().samples) : 0;
      const double cost = cost_of(encoded, samples);
      if (machine) charge(cost);
      const int slice = section().first + frame->geometry.traversal.slice_at(step, section().slices());
      drawn.costs[std::size_t(slice)] = cost;
      for (const EncodedPart& part : encoded.parts) {
        if (part.payload.empty()) continue;
        drawn.items += double(part.items);
        painter_->begin(
            {step, part.passes, std::span<const std::byte>(part.payload).subspan(sizeof(Header))});
        while (!painter_->work()) continue;
      }
      Bytes news;
      painter_->news(0, news);
      if (!news.empty()) encoder->take_news(std::span<const std::byte>(news).subspan(sizeof(Header)));
    }
    finish(*painter_, frame->geometry.regions, setup_, picture, drawn);
    charge(drawn.seconds);
    return drawn;
  }

  std::uint64_t slice_memory() const override { return store_.allocated_bytes(); }

 private:
  const Section& section() const { return setup_.section; }

  std::shared_ptr<const SplatFrame> frame_of(const FrameSpec& spec) const {
    FrameSpec part = spec;
    part.shown.clip = box_of(whole_, section());
    auto frame = std::make_shared<SplatFrame>(part, make_geometry(part, whole_), 1, 1);
    if (frame->geometry.traversal.axis != Axis::z)
      throw InputError("the view does not traverse the z slices, of which the sections are",
                       "look from above: --elevation 60 to 90");
    // The store has the section only, as a volume of its own.
    frame->geometry.box = whole_box(frame->geometry.grid);
    return frame;
  }

  /// `samples`: pixels that its one Renderer composites.
  double cost_of(const EncodedStep& encoded, double samples) const {
    // Without a machine: as many as a visible voxel takes nanoseconds on one core, more or less.
    constexpr double visible_voxel = 80, transparent_voxel = 3;
    if (!setup_.machine)
      return visible_voxel * double(encoded.counts.visible) +
             transparent_voxel * double(encoded.counts.voxels);
    const Machine& machine = *setup_.machine;
    const double weight = setup_.voxel_weight;
    double seconds = encoding_seconds(machine, weight * double(encoded.counts.voxels),
                                      weight * double(encoded.counts.visible));
    for (const EncodedPart& part : encoded.parts)
      if (!part.payload.empty())
        seconds +=
            drawing_seconds(machine, weight * double(part.items), part.passes, setup_.pixel_weight * samples);
    return seconds;
  }

  SectionSetup setup_;
  Grid whole_;
  SliceStore store_;
  EmptySpace space_;
  ThreadTeam threads_;
  std::unique_ptr<FramePainter<SplatFrame>> painter_;
};

}  // namespace

std::unique_ptr<SectionPainter> make_splat_section(const SectionSetup& setup, bool with_normals) {
  return std::make_unique<SplatSection>(setup, with_normals);
}

void finish(Painter& painter, const Regions& regions, const SectionSetup& setup, Image& picture,
            Drawn& drawn) {
  bool first = true;
  painter.finish([&](int tile, const Bytes& bytes) {
    const PixelRect rect = regions.rect(tile);
    const std::size_t row = std::size_t(rect.width()) * 4 * sizeof(float);
    for (int y = 0; y < rect.height(); ++y)
      std::memcpy(picture.pixel(rect.x0, rect.y0 + y), bytes.data() + sizeof(Header) + std::size_t(y) * row,
                  row);
    PixelRect& reached = drawn.reached;
    reached = first ? rect
                    : PixelRect{std::min(reached.x0, rect.x0), std::min(reached.y0, rect.y0),
                                std::max(reached.x1, rect.x1), std::max(reached.y1, rect.y1)};
    first = false;
    if (setup.machine)
      drawn.seconds +=
          setup.machine->renderer.pixel * setup.pixel_weight * double(rect.width()) * double(rect.height());
  });
}

Section section_of(int rank, int ranks, int slices) {
  const auto begin = [&](int k) { return int(std::int64_t(slices) * k / ranks); };
  return {begin(rank), begin(rank + 1)};
}

Section section_of(int rank, int ranks, const std::vector<double>& costs) {
  std::vector<double> before{0};
  for (const double cost : costs) before.push_back(before.back() + cost);
  const auto begin = [&](int k) {
    if (k == ranks) return int(costs.size());
    const double share = before.back() * k / ranks;
    const auto at = std::lower_bound(before.begin(), before.end(), share) - before.begin();
    // The nearer of the two borders.
    return int(at > 0 && share - before[std::size_t(at - 1)] < before[std::size_t(at)] - share ? at - 1 : at);
  };
  return {begin(rank), begin(rank + 1)};
}

}  // namespace ringsplat::sort_last
