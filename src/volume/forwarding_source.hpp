#pragma once
#include <memory>
#include <optional>
#include <utility>

#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// Passes everything on to a source, for derived classes that change one thing.
class ForwardingSource : public VolumeSource {
 public:
  /// `source` must outlive it. `grid`: what it says of the lattice instead.
  explicit ForwardingSource(VolumeSource& source, const std::optional<Grid>& grid = {})
      : source_(source), grid_(grid.value_or(source.grid())) {}
  /// Of a source that it owns.
  explicit ForwardingSource(std::unique_ptr<VolumeSource> source, const std::optional<Grid>& grid = {})
      : ForwardingSource(*source, grid) {
    owned_ = std::move(source);
  }
  const Grid& grid() const final { return grid_; }
  bool concurrent() const override { return source_.concurrent(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_.read_slices(first, count, out);
  }
  int layer_depth() const override { return source_.layer_depth(); }
  VolumeNotes notes() const override { return source_.notes(); }
  Facts facts() const override { return source_.facts(); }

 protected:
  VolumeSource& source_;

 private:
  std::unique_ptr<VolumeSource> owned_;
  Grid grid_;
};

/// A source that says `notes` of its volume.
class NotedSource final : public ForwardingSource {
 public:
  NotedSource(std::unique_ptr<VolumeSource> source, VolumeNotes notes)
      : ForwardingSource(std::move(source)), notes_(std::move(notes)) {}
  VolumeNotes notes() const override { return notes_; }

 private:
  VolumeNotes notes_;
};
inline std::unique_ptr<VolumeSource> with_notes(std::unique_ptr<VolumeSource> source, VolumeNotes notes) {
  return std::make_unique<NotedSource>(std::move(source), std::move(notes));
}

}  // namespace ringsplat
