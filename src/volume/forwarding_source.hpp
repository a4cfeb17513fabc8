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
  /// Of a source that it owns. `notes`: what it says of its volume instead.
  explicit ForwardingSource(std::unique_ptr<VolumeSource> source, const std::optional<Grid>& grid = {},
                            std::optional<VolumeNotes> notes = {})
      : ForwardingSource(*source, grid) {
    owned_ = std::move(source);
    notes_ = std::move(notes);
  }
  const Grid& grid() const final { return grid_; }
  bool concurrent() const override { return source_.concurrent(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_.read_slices(first, count, out);
  }
  int layer_depth() const override { return source_.layer_depth(); }
  VolumeNotes notes() const final { return notes_ ? *notes_ : source_.notes(); }
  Facts facts() const override { return source_.facts(); }
  VolumeSource* labels() override { return source_.labels(); }

 protected:
  VolumeSource& source_;

 private:
  std::unique_ptr<VolumeSource> owned_;
  Grid grid_;
  std::optional<VolumeNotes> notes_;
};

/// A source that says `notes` of its volume.
inline std::unique_ptr<VolumeSource> with_notes(std::unique_ptr<VolumeSource> source, VolumeNotes notes) {
  return std::make_unique<ForwardingSource>(std::move(source), std::nullopt, std::move(notes));
}

}  // namespace ringsplat
