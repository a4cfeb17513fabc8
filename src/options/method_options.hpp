#pragma once
#include <optional>

#include "frame/quality.hpp"

namespace ringsplat::app {

/// What turns voxels into pixels.
enum class Engine { splats, sheets };
const char* name(Engine engine);

/// How pictures are drawn when neither --engine nor --quality says.
inline constexpr Quality usual_quality = Quality::best;

constexpr Engine engine_of(Quality quality) {
  return quality == Quality::paper ? Engine::splats : Engine::sheets;
}

/// What the user says of a frame's method; method_for() makes the frame's `how` of it.
struct MethodOptions {
  std::optional<Engine> engine;
  std::optional<Quality> quality;
  /// Its kernel, payload and precision count; plane and samples are below.
  Splats splats;
  std::optional<ImagePlane> image_plane;
  std::optional<double> samples;
  std::optional<int> slabs, light_points;
};

/// The quality whose settings the other options change: without --quality the engine's best known.
Quality quality_of(const MethodOptions& options);

/// The quality's method with all that `options` say instead. Throws InputError when an option has no effect
/// on that method, or contradicts another.
Method method_for(const MethodOptions& options);

/// The method that the same options mean for the engine that they do not choose, to compare with. They must
/// name neither engine nor quality, nor an option of one engine only.
Method method_for_other_engine(MethodOptions options);

/// What the method's payloads hold, for messages: "splats", or "blocks" of sheets.
const char* items_of(const Method& method);

}  // namespace ringsplat::app
