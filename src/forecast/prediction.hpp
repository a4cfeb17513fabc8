#pragma once
#include <string>
#include <vector>

#include "ringsplat/net/layout.hpp"

/// What a forecast says.
namespace ringsplat::app {

/// What a frame's work takes, in seconds of one core, with one GP and one Renderer.
struct FrameWork {
  double visible_voxels = 0, items = 0;
  const char* items_name = "splats";  ///< or "blocks"
  double gp = 0;                      ///< to classify, shade and encode all slices
  double frame = 0;                   ///< a GP's setup before its first slice
  double renderer = 0;                ///< to draw, composite and deliver
};

enum class Limit { gps, renderers, cores };
const char* name(Limit limit);  ///< "the GPs", "the Renderers", "the cores"

struct Prediction {
  Layout layout;
  double gp = 0;        ///< seconds of the busiest GP
  double renderer = 0;  ///< seconds of the busiest Renderer
  double shared = 0;    ///< the work of all ranks of a host over its cores
  double tokens = 0;    ///< passing the tokens through all slices
  double seconds = 0;   ///< of a frame
  Limit limit = Limit::gps;
};

/// "668005 visible voxels of 39.5 ns on a GP, 725382 splats of 59.1 ns on a Renderer, ...", for messages.
std::string describe(const FrameWork& work);
/// A line for each prediction, with a heading.
std::string to_table(const std::vector<Prediction>& predictions);

}  // namespace ringsplat::app
