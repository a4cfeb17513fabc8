#pragma once
#include <span>
#include <string>
#include <vector>

#include "options/options.hpp"
#include "truth/sampling.hpp"
#include "truth/scene.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::app {

/// A whole volume in one process, as truths need it: 8 bytes a voxel. It is read once for many frames, which
/// the scene's owner sets.
struct WholeVolume {
  truth::Scene scene;
  ValueStatistics statistics;  ///< the same as load_scene's, so that presets are the same
};
/// Throws InputError when the volume is unreadable or exceeds this machine's memory.
WholeVolume read_whole(VolumeSource& source);

struct Evaluation {
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula = {};
};
std::vector<truth::Rgba> evaluate(const truth::Scene& scene, const Evaluation& evaluation,
                                  std::span<const truth::Pixel> pixels);

/// A sample of a picture's pixels and the truth there; it serves other pictures of the scene, too.
struct SampledTruth {
  truth::PixelSample sample;
  std::vector<truth::Rgba> colours;
};
/// Samples where `picture` differs most (truth::draw_sample) and evaluates the truth there.
SampledTruth sample_truth(const Image& picture, const truth::Scene& scene, const Evaluation& evaluation,
                          std::size_t pixels, std::uint64_t seed);

struct MeasuredError {
  TruthKind truth;
  std::uint64_t seed;
  truth::SampledError error;
  double seconds;  ///< spent on the truth
};
MeasuredError measure(const Image& image, const truth::Scene& scene, const ErrorOptions& options);

/// "error against the method's truth: 0.0021/255 rms (95 %: 0.0019 to 0.0023), …".
std::string to_text(const MeasuredError& error);

}  // namespace ringsplat::app
