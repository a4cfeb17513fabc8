// Every check of arriving payloads and news of opaque tiles, by changed ones.
#include <fmt/format.h>

#include <cstring>
#include <set>

#include "classify/empty_space.hpp"
#include "frame/frame_geometry.hpp"
#include "net/message.hpp"
#include "raster/opaque_tiles.hpp"
#include "ringsplat/base/error.hpp"
#include "splat/splat.hpp"
#include "splat/voxel_run.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

template <class T>
T at(const Bytes& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// A slice of 70 × 20 voxels as sent to one of two Renderers, and that Renderer.
class Sent {
 public:
  Sent() : threads_(1) {
    const Grid grid = make_grid({70, 20, 5});
    spec_.shown.camera = {.azimuth = 10, .elevation = 75};
    spec_.shown.width = spec_.shown.height = 96;
    spec_.division.region_size = 20;
    spec_.division.dealt_to = 2;
    spec_.shown.transfer_function = constant_opacity(0.4);
    frame_ = std::make_shared<SplatFrame>(spec_, make_geometry(spec_, grid), 1, 2);
    REQUIRE(geometry().traversal.axis == Axis::z);
    const auto source = synth_source("constant", grid);
    const auto stores = dealt(*source, 1);
    EmptySpace empty_space;
    const auto encoder = make_splat_encoder(frame_, 2, stores.at(0), empty_space, threads_);
    encoder->begin(2);
    while (!encoder->work()) {
    }
    body = encoder->finish().parts.at(0).payload;
    body.erase(body.begin(), body.begin() + sizeof(Header));
    painter_ = make_splat_painter(0, threads_);
    painter_->begin_frame(frame_);
  }

  bool accepts(const Bytes& changed) {
    try {
      painter_->begin({.step = 2, .body = changed});
    } catch (const RunError&) {
      return false;
    }
    return true;
  }
  template <class T>
  bool accepts_with(std::size_t offset, T value) {
    Bytes changed = body;
    std::memcpy(changed.data() + offset, &value, sizeof value);
    return accepts(changed);
  }
  /// A region of the other Renderer.
  std::int32_t foreign_region() const {
    const auto owners = geometry().owners(2);
    for (int region = 0; region < geometry().regions.count(); ++region)
      if (owners[std::size_t(region)] == 1) return region;
    return -1;
  }
  int regions() const { return geometry().regions.count(); }

  Bytes body;

 private:
  const FrameGeometry& geometry() const { return frame_->geometry; }

  FrameSpec spec_{.how = Splats{}};
  std::shared_ptr<const SplatFrame> frame_;
  ThreadTeam threads_;
  std::unique_ptr<FramePainter<SplatFrame>> painter_;
};

/// Offsets of the groups of runs, and of the end.
std::set<std::size_t> run_groups(const Bytes& body) {
  std::set<std::size_t> begins;
  std::size_t offset = 0;
  while (offset < body.size()) {
    begins.insert(offset);
    const auto group = at<BlockGroup>(body, offset);
    offset += sizeof group + group.blocks * sizeof(VoxelRun) + group.voxels * sizeof(PackedVoxel);
  }
  begins.insert(offset);
  return begins;
}

/// Lengths at which a cut payload is accepted.
std::set<std::size_t> accepted_lengths(Sent& sent) {
  std::set<std::size_t> lengths;
  for (std::size_t length = 0; length <= sent.body.size(); ++length)
    if (sent.accepts(Bytes(sent.body.begin(), sent.body.begin() + std::ptrdiff_t(length))))
      lengths.insert(length);
  return lengths;
}

Bytes twice(const Bytes& body) {
  Bytes both = body;
  both.insert(both.end(), body.begin(), body.end());
  return both;
}

}  // namespace

TEST_CASE("runs that do not lie in the slice or are not as many as they say are refused") {
  Sent sent;
  REQUIRE(sent.accepts(sent.body));
  const auto groups = run_groups(sent.body);
  REQUIRE(groups.size() > 3);
  CHECK(accepted_lengths(sent) == groups);
  CHECK_FALSE(sent.accepts(twice(sent.body)));  // regions ascend

  for (const std::int32_t region : {-1, sent.regions(), sent.foreign_region()})
    CHECK_FALSE(sent.accepts_with(offsetof(BlockGroup, region), region));
  const auto group = at<BlockGroup>(sent.body, 0);
  for (const std::uint32_t blocks : {0U, group.blocks - 1, group.blocks + 1, ~0U})
    CHECK_FALSE(sent.accepts_with(offsetof(BlockGroup, blocks), blocks));
  for (const std::uint32_t voxels : {0U, group.voxels - 1, group.voxels + 1, ~0U})
    CHECK_FALSE(sent.accepts_with(offsetof(BlockGroup, voxels), voxels));

  // Some block of the slice's last six columns.
  std::size_t first = 0, last = 0;
  for (const std::size_t begin : groups) {
    if (begin == sent.body.size()) continue;
    const auto blocks = at<BlockGroup>(sent.body, begin).blocks;
    for (std::uint32_t k = 0; k < blocks; ++k) {
      const std::size_t offset = begin + sizeof(BlockGroup) + k * sizeof(VoxelRun);
      (at<VoxelRun>(sent.body, offset).first == 0 ? first : last) = offset;
    }
  }
  REQUIRE(first > 0);
  REQUIRE(last > 0);
  for (const std::size_t block : {first, last}) {
    CHECK_FALSE(sent.accepts_with(block + offsetof(VoxelRun, row), 20U));
    for (const std::uint32_t column : {3U, 63U, 65U, 70U, 128U})
      CHECK_FALSE(sent.accepts_with(block + offsetof(VoxelRun, first), column));
    const auto mask = at<VoxelRun>(sent.body, block).mask;
    CHECK_FALSE(sent.accepts_with(block + offsetof(VoxelRun, mask), std::uint64_t{0}));
    CHECK_FALSE(sent.accepts_with(block + offsetof(VoxelRun, mask), mask & (mask - 1)));
  }
  // The same number of voxels, but one in column 70.
  const auto mask = at<VoxelRun>(sent.body, last).mask;
  CHECK_FALSE(sent.accepts_with(last + offsetof(VoxelRun, mask), (mask & (mask - 1)) | 1U << 6));
}

TEST_CASE("news of opaque tiles arrive as they were sent, and cut ones or of no region are refused") {
  std::vector<OpaqueTiles> told{{40, 33}, {16, 16}, {200, 70}}, known = told;
  for (const int column : {0, 3, 7, 12})
    for (const int row : {1, 4}) told[2].set_opaque(column, row);
  told[0].set_opaque(2, 2);
  Bytes news;
  append_opaque_news(2, told[2], news);
  const std::size_t of_one = news.size();
  append_opaque_news(0, told[0], news);
  for (std::size_t length = 0; length < news.size(); ++length) {
    const std::span cut = std::span<const std::byte>(news).first(length);
    INFO(length << " of " << news.size() << " bytes");
    auto copy = known;
    if (length == 0 || length == of_one)
      CHECK_NOTHROW(read_opaque_news(cut, copy));
    else
      CHECK_THROWS_AS(read_opaque_news(cut, copy), RunError);
  }
  read_opaque_news(news, known);
  for (std::size_t region = 0; region < told.size(); ++region) {
    CHECK(known[region].opaque() == told[region].opaque());
    for (int row = 0; row < told[region].rows(); ++row)
      for (int column = 0; column < told[region].columns(); ++column)
        CHECK(known[region].is_opaque(column, row) == told[region].is_opaque(column, row));
  }
  for (const std::int32_t region : {-1, 3}) {
    Bytes wrong = news;
    std::memcpy(wrong.data(), &region, sizeof region);
    CHECK_THROWS_AS(read_opaque_news(wrong, known), RunError);
  }
}

TEST_CASE("every frame tells anew which tiles are opaque, and a GP each of them once") {
  const Grid grid = make_grid({40, 40, 40});
  const auto source = synth_source("constant", grid);
  const auto stores = dealt(*source, 1);
  FrameSpec spec = oblique_view(96, 96, 48);
  spec.shown.transfer_function = constant_opacity(1.0);
  spec.division.dealt_to = 1;
  const auto frame = std::make_shared<SplatFrame>(spec, make_geometry(spec, grid), 1, 1);
  ThreadTeam threads(1);
  EmptySpace empty_space;
  const auto encoder = make_splat_encoder(frame, 1, stores.at(0), empty_space, threads);
  const auto painter = make_splat_painter(0, threads);
  const auto news_of_frame = [&] {
    painter->begin_frame(frame);
    Bytes all;
    for (int step = 0; step < frame->geometry.slices; ++step) {
      encoder->begin(step);
      while (!encoder->work()) {
      }
      const Bytes payload = encoder->finish().parts.at(0).payload;
      painter->begin({.step = step, .body = std::span<const std::byte>(payload).subspan(sizeof(Header))});
      while (!painter->work()) {
      }
      Bytes news;
      painter->news(0, news);
      all.insert(all.end(), news.begin() + std::min<std::ptrdiff_t>(sizeof(Header), std::ssize(news)),
                 news.end());
      Bytes again;
      painter->news(0, again);
      CHECK(again.empty());
    }
    return all;
  };
  const Bytes first = news_of_frame();
  REQUIRE_FALSE(first.empty());
  CHECK(news_of_frame() == first);
}
