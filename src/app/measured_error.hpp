#pragma once
#include <span>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "app/truth_scene.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "truth/sampling.hpp"

namespace ringsplat::app {

/// A whole volume in one process, as the truths need it: 8 bytes a voxel.
struct WholeVolume {
  Grid grid;
  std::vector<double> values;
  ValueRange range;
  Histogram histogram;  ///< as load_scene makes it, so that presets come out the same
};
/// Throws InputError: unreadable, no finite value, larger than this machine's memory.
WholeVolume read_whole(VolumeSource& source);

/// The volume's values are moved into the scene and stay there from frame to frame; set_frame
/// (ringsplat/app/truth_scene.hpp) changes the rest.
truth::Scene make_scene(WholeVolume&& volume);

struct Evaluation {
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula = {};
};
std::vector<truth::Rgba> evaluate(const truth::Scene& scene, const Evaluation& evaluation,
                                  std::span<const truth::Pixel> pixels);

/// Where the truth may be other than transparent.
truth::ScreenBounds bounds_of(const truth::Scene& scene, TruthKind truth);

/// A sample of a picture's pixels and what is true there: it serves other pictures of the scene, too.
struct SampledTruth {
  truth::PixelSample sample;
  std::vector<truth::Rgba> colours;
};
/// Draws where `picture` differs most (truth::draw_sample) and evaluates there.
SampledTruth sample_truth(const Image& picture, const truth::Scene& scene, const Evaluation& evaluation,
                          std::size_t pixels, std::uint64_t seed);

struct MeasuredError {
  TruthKind truth;
  std::uint64_t seed;
  truth::SampledError error;
  double seconds;  ///< that the truth took
};
MeasuredError measure(const Image& image, const truth::Scene& scene, const ErrorOptions& options);

/// "error against the method's truth: 0.0021/255 rms (95 %: 0.0019 to 0.0023), …".
std::string to_text(const MeasuredError& error);

}  // namespace ringsplat::app
