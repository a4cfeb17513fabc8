#pragma once
#include <memory>
#include <vector>

#include "forecast/role_choice.hpp"
#include "frame/work_estimate.hpp"
#include "options/transfer_function_option.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/source.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::app {

/// Foresees frames on a described machine, of either method, from a sketch of the volume: it deals regions as
/// the program will, then follows every Renderer's token from slice to slice with what encoding, messages and
/// drawing cost, by layers of the sketch. Of links it knows how many bytes they carry, where ranks fill hosts
/// one after another, not what meets on them.
class MachineForecast {
 public:
  /// `views`: the run's, or some of them. `voxel_weight`: as SimulationOptions'. `ranks`: about as many
  /// Renderers get regions. Throws InputError when voxels cannot be read or no view can be drawn.
  MachineForecast(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                  const std::vector<Camera>& views, const Machine& machine, double voxel_weight, int ranks,
                  const ProtocolOptions& protocol);
  ~MachineForecast();

  /// What a frame costs, whatever the layout; splats are not counted.
  FrameCosts costs() const;
  Prediction predict(const Layout& layout) const;
  /// The fastest first. Of many it first looks at some, then at those next to the fastest.
  std::vector<Prediction> predict_all(const std::vector<Layout>& layouts) const;
  /// The same with bundles of 1, 2, 4 … slices: of the fewest with which the fastest is within 1 % of the
  /// best.
  std::vector<Prediction> predict_bundles(const std::vector<Layout>& layouts) const;

 private:
  struct View;
  Prediction predict(const View& view, const Layout& layout) const;
  /// Of the busiest link, which at best is busy all the time.
  double link_seconds(const View& view, const Layout& layout) const;
  void deal(const View& view, const Layout& layout, FrameGeometry& geometry) const;

  Machine machine_;
  ProtocolOptions protocol_;
  FrameSpec frame_;
  double bytes_of_voxel_ = 0;  ///< of a visible one's payload
  std::vector<std::unique_ptr<View>> views_;
};

/// Rings of all `ranks` ranks: every dedicated split, and all of them GPs, of which some or all are
/// Renderers, too.
std::vector<Layout> rings_on_machine(int ranks);

}  // namespace ringsplat::app
