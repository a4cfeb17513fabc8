#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "options/options.hpp"
#include "options/transfer_function_option.hpp"
#include "ringsplat/classify/transfer_function.hpp"

/// Channels of one volume that are drawn one after another, each in its colour, and added.
namespace ringsplat::app {

struct DrawnChannel {
  std::string choice;                ///< what --channel calls it by itself
  std::string name;                  ///< for people
  glm::dvec3 colour{1};              ///< display (sRGB) values, 0 to 1
  std::optional<glm::dvec2> window;  ///< the file's own
  TransferFunction function = {};    ///< on rank 0, once it is chosen
};

/// The channels that --channel, `wanted`, means in the volume; none where "all" is one. Their colours are
/// those given with them, else the file's, else the usual ones. Throws InputError for a channel that is not
/// there and for too many of them.
std::vector<DrawnChannel> find_channels(VolumeOptions volume, const std::string& wanted);

/// Makes the channel's function of what --tf and others say, in its colour, and over the file's window unless
/// there is another. As TransferFunctionChoice::make().
MadeFunction make_function(DrawnChannel& channel, const RenderOptions& options, const ValueStatistics& values,
                           Shown& shown);

}  // namespace ringsplat::app
