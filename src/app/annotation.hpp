#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/channels.hpp"
#include "images/drawing.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/statistics.hpp"

/// What --annotate draws into pictures.
namespace ringsplat::app {

/// Orientation letters at the sides of a patient's picture, the lattice's axes in a corner of others; a scale
/// bar in an orthographic picture; a bar of the colours that the transfer function makes visible. Sizes go
/// with the picture's shorter side; what has no room is left out.
class Annotation {
 public:
  /// `background` (linear light; none: transparent) decides between dark and light ink; `window`: the colour
  /// bars span what is visible of it; `channels`: that are drawn together, of which a legend tells instead.
  /// Throws InputError when there is no font that can be used.
  Annotation(const Grid& grid, const VolumeNotes& notes, const std::optional<glm::dvec3>& background,
             const std::optional<DataRange>& window = std::nullopt, std::vector<DrawnChannel> channels = {});
  /// The colour bars of all pictures span what is visible of `range`, unless there is a window.
  void keep_range(const ValueRange& range) {
    if (!bar_) bar_ = {range.low, range.high};
  }
  /// Of a frame's picture; `range` is the volume's.
  Overlay overlay(const FrameSpec& spec, const ValueRange& range) const;

 private:
  Grid grid_;
  VolumeNotes notes_;
  bool dark_ink_;
  std::optional<DataRange> bar_;
  std::vector<DrawnChannel> channels_;
};

/// For a picture of this size: what colours over `span` mean, at its right side.
Overlay colour_bar(int width, int height, const TransferFunction& tf, const DataRange& span,
                   const std::string& quantity);

/// 1, 2 or 5 times a power of ten: the largest that is at most `most`, which is above 0.
double round_length(double most);

/// Where a patient's direction (left, posterior, superior) points, in letters, the strongest part first: "L",
/// "LP", "HA".
std::string patient_letters(const glm::dvec3& direction);

/// The values from the lowest to the highest one that is visible; nothing when none is.
std::optional<DataRange> visible_span(const TransferFunction& tf, const DataRange& range);

}  // namespace ringsplat::app
