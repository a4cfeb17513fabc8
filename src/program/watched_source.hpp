#pragma once
#include <memory>
#include <utility>

#include "program/progress.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::app {

/// A source that tells a progress bar how far it was read.
class WatchedSource final : public ForwardingSource {
 public:
  WatchedSource(std::unique_ptr<VolumeSource> source, Progress& progress)
      : ForwardingSource(std::move(source)), progress_(progress) {}
  void read_slices(int first, int count, std::span<std::byte> out) override {
    ForwardingSource::read_slices(first, count, out);
    progress_.at(first + count);
  }

 private:
  Progress& progress_;
};

}  // namespace ringsplat::app
