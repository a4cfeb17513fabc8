#pragma once
#include <algorithm>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "frame/slices.hpp"
#include "protocol/frame_source.hpp"
#include "session/measured_pace.hpp"
#include "session/render_frames.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// Supplies the protocol with a director's frames.
class DirectedFrames final : public FrameSource {
 public:
  DirectedFrames(Director director, const Grid& grid, const Layout& layout)
      : director_(std::move(director)),
        grid_(grid),
        pace_(layout),
        sum_([this](FrameResult&& sum, std::size_t) { director_.frame_done(std::move(sum)); }) {
    if (director_.next_picture) return;
    director_.next_picture = [next = director_.next_frame] {
      auto spec = next();
      return spec ? std::vector{VolumeFrame{0, std::move(*spec)}} : std::vector<VolumeFrame>();
    };
  }

  std::optional<Bytes> next(std::int64_t frame) override {
    if (parts_.empty()) parts_ = with_slices(director_.next_picture());
    if (parts_.empty()) return std::nullopt;
    const Joins joins = parts_.front().joins;
    const auto cut = parts_.front().spec.shown.cut;
    auto together = take_together(frame);
    Bytes body = encode(together);
    auto& [volume, spec] = together.front();
    if (spec.shown.depth && !spec.shown.values) parts_.insert(parts_.begin(), {volume, depth_frame_of(spec)});
    spec.frame = picture_;
    spec.shown.cut = cut;
    frames_[frame] = {std::move(spec), {}, parts_.empty(), joins};
    if (parts_.empty()) ++picture_;
    return body;
  }
  bool may_come() override { return director_.may_come && director_.may_come(); }
  /// With a picture all its frames are dropped.
  bool unwanted(std::int64_t frame) override {
    const Announced& asked = frames_.at(frame);
    const std::int64_t picture = asked.spec.frame;
    if (asked.dropped) return true;
    if (!director_.unwanted || !director_.unwanted(asked.spec)) return false;
    for (auto& [number, announced] : frames_) announced.dropped |= announced.spec.frame == picture;
    if (picture == picture_) {
      parts_.clear();
      ++picture_;
    }
    return true;
  }
  void done(FrameStats&& stats) override {
    Announced frame = std::move(frames_.extract(stats.frame).mapped());
    const auto picture = std::size_t(frame.spec.frame);
    if (stats.dropped) return sum_.forget(picture);
    pace_.learn(frame.spec.division, stats);
    const Axis axis = traversed_axis(frame.spec, grid_);
    sum_.add({std::move(frame.spec), std::move(frame.image), std::move(stats), axis}, picture, frame.last,
             frame.joins);
  }
  void pause(std::chrono::nanoseconds most) override {
    if (director_.pause)
      director_.pause(most);
    else
      FrameSource::pause(most);
  }
  /// Keeps the picture of a frame until done().
  void take_picture(std::int64_t frame, Image&& picture) { frames_.at(frame).image = std::move(picture); }

 private:
  struct Announced {
    FrameSpec spec;  ///< with its picture's number
    Image image;
    bool last = true;  ///< of its picture
    Joins joins = Joins::added;
    bool dropped = false;
  };

  /// With the slices of volumes that are cut open, behind all volumes that they lie over.
  std::vector<VolumeFrame> with_slices(std::vector<VolumeFrame> parts) const {
    std::vector<VolumeFrame> all, slices;
    const auto lay_slices = [&] {
      std::ranges::move(slices, std::back_inserter(all));
      slices.clear();
    };
    for (VolumeFrame& part : parts) {
      if (part.joins == Joins::below) lay_slices();
      if (part.spec.shown.cut) {
        CutOpen made = cut_open(part.spec, grid_);
        slices.push_back({part.volume, std::move(made.slice), slices.empty() ? Joins::over : Joins::added});
        part.spec = std::move(made.left);
      }
      all.push_back(std::move(part));
    }
    lay_slices();
    return all;
  }

  /// The next frame, of one volume or of all those behind it that are drawn as one with it.
  std::vector<FrameOfVolume> take_together(std::int64_t frame) {
    std::vector<FrameOfVolume> frames;
    for (const auto& [volume, spec, joins] : parts_) {
      if (!frames.empty() && joins != Joins::added) break;
      frames.push_back({volume, spec});
      frames.back().spec.frame = frame;
      frames.back().spec.shown.cut.reset();  // that is drawn as clip planes
      pace_.tell(frames.back().spec.division);
      if (frames.size() > 1 && !drawn_together(frames)) {
        frames.pop_back();
        break;
      }
    }
    parts_.erase(parts_.begin(), parts_.begin() + std::ptrdiff_t(frames.size()));
    return frames;
  }

  Director director_;
  Grid grid_;
  MeasuredPace pace_;
  std::int64_t picture_ = 0;                  ///< whose parts are announced now
  std::vector<VolumeFrame> parts_;            ///< of it that are not yet announced
  std::map<std::int64_t, Announced> frames_;  ///< announced and not done
  FrameSum sum_;
};

}  // namespace ringsplat
