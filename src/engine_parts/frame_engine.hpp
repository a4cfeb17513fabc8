#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/thread_team.hpp"
#include "frame/engine_setup.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "protocol/engine.hpp"
#include "raster/region_image.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "volume/slice_dealing.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// Puts the tiles of frame `number` into the picture, by a warp where the image plane is not the screen.
/// Tiles are rows of premultiplied RGBA floats.
std::unique_ptr<Canvas> make_picture_canvas(std::int64_t number, const Shown& shown,
                                            std::shared_ptr<const FrameGeometry> geometry, TakePicture take);

/// A rank's frames' regions, dealt by the work that the volume's sketch lets foresee
/// (frame/work_estimate.hpp).
class RegionDealer {
 public:
  explicit RegionDealer(const EngineSetup& setup) : setup_(setup) {}
  /// From now on for these ranks and costs; the sketch is the same.
  void use(const EngineSetup& setup) { setup_ = setup; }
  /// Of a frame's geometry, before its plan is made.
  void deal(const FrameSpec& spec, FrameGeometry& geometry);

 private:
  EngineSetup setup_;
  ShownPoints shown_;
};

/// A frame as the nodes of a rank share it: what was announced, and what follows from it.
struct SharedFrame {
  SharedFrame() = default;
  /// `geometry` must be made of `spec`; without a `dealer` regions are dealt in turn.
  SharedFrame(const FrameSpec& spec, FrameGeometry geometry, SliceDealing dealing, int renderers,
              RegionDealer* dealer);

  std::int64_t number = 0;
  std::size_t volume = 0;  ///< that it shows
  Shown shown;
  FrameGeometry geometry;
  std::vector<int> drawers;  ///< by region of the geometry: the Renderer that draws it, or nobody
  FramePlan plan;
};

/// A GP's encoder of one frame of slices in a store, which must outlive it. Throws RunError when the slices
/// that the frame traverses were not loaded.
template <class Frame>
class FrameEncoder : public Encoder {
 public:
  FrameEncoder(std::shared_ptr<const Frame> frame, const SliceStore& store)
      : frame_(std::move(frame)), whole_store_(store), store_(store.level(frame_->shown.reduction.factor)) {
    if (!store_.keeps(axis()))
      throw RunError(fmt::format("frame {} traverses the {} axis, whose slices were not loaded",
                                 frame_->number, name(axis())));
  }

  std::uint64_t left_out(std::size_t steps) const override {
    return steps * std::uint64_t(geometry().grid.slice_voxels(axis()));
  }
  std::uint64_t slice_memory() const override { return whole_store_.allocated_bytes(); }

 protected:
  const FrameGeometry& geometry() const { return frame_->geometry; }
  Axis axis() const { return geometry().traversal.axis; }
  SliceView slice(int step) const { return store_.slice(axis(), geometry().slice_at(step), geometry().box); }
  int drawer_of(int region) const { return frame_->drawers[std::size_t(region)]; }

  std::shared_ptr<const Frame> frame_;
  const SliceStore& whole_store_;
  const SliceStore& store_;  ///< the frame's level
};

/// The images of the regions that one Renderer draws in a frame, and what GPs were told of their opaque
/// tiles.
class OwnedImages {
 public:
  explicit OwnedImages(int renderer) : renderer_(renderer) {}

  /// Clears all images; their memory stays while the regions do. `drawers`: by region, its Renderer.
  void begin_frame(const Regions& regions, const std::vector<int>& drawers, double opaque_threshold);

  std::size_t count() const { return images_.size(); }
  RegionImage& image(std::size_t slot) { return images_[slot]; }
  bool owns(int region) const { return std::ranges::binary_search(owned_, region); }
  const std::vector<int>& owned() const { return owned_; }  ///< ascending, by their images
  /// Index of an owned region's image.
  std::size_t slot_of(int region) const {
    return std::size_t(std::ranges::lower_bound(owned_, region) - owned_.begin());
  }

  /// Appends to `news` the opaque tiles that GP `gp` has not been told of (Painter::news).
  void news(int gp, Bytes& news);
  /// Hands over the tiles that are not empty (Painter::finish).
  void deliver(const std::function<void(int tile, Bytes bytes)>& deliver) const;

 private:
  int renderer_;
  Regions regions_;
  std::vector<int> owned_;                ///< regions
  std::vector<RegionImage> images_;       ///< one for each owned region
  std::map<int, std::vector<int>> told_;  ///< by GP: for each owned region, the opaque tiles it knows of
};

/// A Renderer's painter, which keeps its buffers from frame to frame.
template <class Frame>
class FramePainter : public Painter {
 public:
  /// `threads` must outlive it.
  FramePainter(int renderer, ThreadTeam& threads)
      : renderer_(renderer), threads_(threads), images_(renderer) {}

  /// Clears the image.
  virtual void begin_frame(std::shared_ptr<const Frame> frame) {
    frame_ = std::move(frame);
    images_.begin_frame(geometry().regions, frame_->drawers, frame_->shown.opaque_threshold);
    counts_ = {};
  }
  void news(int gp, Bytes& news) override { images_.news(gp, news); }
  ItemCounts counts() const override { return counts_; }
  void finish(const std::function<void(int, Bytes)>& deliver) override { images_.deliver(deliver); }

 protected:
  const FrameGeometry& geometry() const { return frame_->geometry; }
  /// Calls `read`, whose RunError gets the payload's place. Throws RunError when the traversal has no such
  /// step.
  template <class Read>
  void read_payload(int step, const Read& read) const {
    try {
      if (step < 0 || step >= geometry().slices)
        throw OtherBuild(fmt::format("the traversal has {} steps", geometry().slices));
      read();
    } catch (const RunError& e) {
      throw RunError(fmt::format("Renderer {}, step {}: {}", renderer_, step, e.what()));
    }
  }

  int renderer_;
  ThreadTeam& threads_;
  std::shared_ptr<const Frame> frame_;
  OwnedImages images_;
  ItemCounts counts_;
};

/// One rank's engine of one method, whose frames are SharedFrames and more. `Kept`: what a GP keeps from
/// frame to frame, one for each volume and each level of its store.
template <class Frame, class Kept>
class FrameEngine : public Engine {
 public:
  explicit FrameEngine(const EngineSetup& setup) : setup_(setup) {
    EngineSetup one = setup;
    dealers_.emplace_back(one);
    for (const auto& other : setup.others) {
      one.sketch = other.sketch;
      dealers_.emplace_back(one);
    }
  }

  FramePlan plan(const Announcement& a) override { return frame(a)->plan; }

  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override { return encoder_of(frame(a)); }

  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    auto& painter = painters_[renderer];
    if (!painter) painter = make_painter(renderer);
    painter->begin_frame(frame(a));
    return painter;
  }

  std::unique_ptr<Canvas> canvas(const Announcement& a) override {
    const auto its = frame(a);
    return make_picture_canvas(its->number, its->shown, {its, &its->geometry}, setup_.take);
  }

 protected:
  /// Of one volume, or of several that are drawn as one.
  virtual std::shared_ptr<const Frame> make_frame(const std::vector<FrameOfVolume>& frames) = 0;
  virtual std::unique_ptr<Encoder> make_encoder(std::shared_ptr<const Frame> frame, Kept& kept) = 0;
  virtual std::unique_ptr<FramePainter<Frame>> make_painter(int renderer) = 0;

  virtual std::unique_ptr<Encoder> encoder_of(std::shared_ptr<const Frame> frame) {
    auto& kept = kept_[{frame->volume, frame->shown.reduction.factor}];
    if (!kept) kept = std::make_unique<Kept>();
    return make_encoder(std::move(frame), *kept);
  }
  const SliceStore& slices_of(const Frame& frame) const {
    return frame.volume == 0 ? *setup_.slices : *setup_.others[frame.volume - 1].slices;
  }

  const EngineSetup setup_;
  std::vector<RegionDealer> dealers_;  ///< by volume

 private:
  /// The announced frame, which is made when it is new. Throws RunError when the bytes are no description of
  /// it, or when it cannot be: another rank announced it, so no input of this one is to blame.
  std::shared_ptr<const Frame> frame(const Announcement& a) {
    for (const auto& known : frames_)
      if (known->number == a.frame) return known;
    constexpr std::size_t most_remembered = 4;
    if (frames_.size() == most_remembered) frames_.pop_front();
    try {
      const auto frames = decode_frames(a.body);
      for (const auto& [volume, spec] : frames) {
        if (spec.frame != a.frame)
          throw RunError(
              fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
        if (volume >= dealers_.size()) throw RunError(fmt::format("rank 0 told of volume {}", volume));
        check(spec);
      }
      return frames_.emplace_back(make_frame(frames));
    } catch (const InputError& e) {
      throw RunError(std::string("rank 0 told of a frame that cannot be: ") + e.what());
    }
  }

  std::deque<std::shared_ptr<const Frame>> frames_;  ///< in flight; the rank's nodes share them
  std::map<std::pair<std::size_t, int>, std::unique_ptr<Kept>> kept_;  ///< by volume and level
  std::map<int, std::shared_ptr<FramePainter<Frame>>> painters_;       ///< by Renderer
};

}  // namespace ringsplat
