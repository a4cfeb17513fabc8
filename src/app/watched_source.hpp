#pragma once
#include <memory>
#include <utility>

#include "app/progress.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::app {

/// A source that tells a progress bar how far it was read.
class WatchedSource final : public VolumeSource {
 public:
  WatchedSource(std::unique_ptr<VolumeSource> source, Progress& progress)
      : source_(std::move(source)), progress_(progress) {}
  const Grid& grid() const override { return source_->grid(); }
  bool concurrent() const override { return source_->concurrent(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_->read_slices(first, count, out);
    progress_.at(first + count);
  }
  Facts facts() const override { return source_->facts(); }

 private:
  std::unique_ptr<VolumeSource> source_;
  Progress& progress_;
};

}  // namespace ringsplat::app
