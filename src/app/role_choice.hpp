#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/net/layout.hpp"

/// Which ranks should be GPs and which Renderers: pure functions of what a frame costs.
namespace ringsplat::app {

/// What a frame costs, in seconds of one core (app/probe.hpp measures it).
struct FrameCosts {
  double slices = 1;           ///< that are traversed
  double gp = 0;               ///< classify, shade and encode all of them
  std::vector<double> region;  ///< draw, composite and deliver, by region
  int columns = 1;             ///< regions in a row of the picture
  double frame = 0;            ///< what every GP spends on a frame before its first slice
  double visible_voxels = 0, splats = 0;
  double renderer() const;  ///< the sum over all regions
};

/// Where the ranks run.
struct RankCosts {
  int cores = 1;                   ///< that all ranks share
  double hop = 2.5e-6;             ///< seconds from sending a message to having it
  double message_software = 2e-6;  ///< seconds of a core for one message, on both sides together
  double sharing = 1;              ///< times as long a frame takes where ranks share cores
  double token = 0;                ///< seconds of a GP for a token that it passes on, besides messages
};

enum class Limit { gps, renderers, cores };
const char* name(Limit limit);  ///< "the GPs", "the Renderers", "the cores"

struct Prediction {
  Layout layout;
  double gp = 0;        ///< seconds of the GP, or rank, that has most to do
  double renderer = 0;  ///< of the Renderer that has most to do; colocated: of the rank's Renderer
  double shared = 0;    ///< all work over all cores
  double tokens = 0;    ///< passing the tokens through all slices
  double seconds = 0;   ///< of a frame
  Limit limit = Limit::gps;
};

/// A frame's time: that of the side that has most to do, then what the tokens cost. A token passes a slice by
/// three messages, one after another (payload, accept, token), each as many hops as the topology asks for;
/// all Renderers' tokens move at once as far as there are cores for their software. What the longest side
/// hides of it, when frames overlap, is not counted: it would be so for all layouts alike.
Prediction predict(const FrameCosts& costs, const RankCosts& ranks, const Layout& layout);

/// Every way to give `ranks` ranks their roles: in a ring all dedicated splits and all ranks colocated; with
/// `meshes` also every mesh of at least two columns and two rows that fills them, with a Renderer at the left
/// end or at both ends of every row. Of more ranks than `cores`, if not 0, also rings of as many as there are
/// cores, in which the others are idle.
std::vector<Layout> possible_layouts(int ranks, bool meshes, int cores = 0);

/// Predictions of these layouts, the fastest first; of equals the one with fewer Renderers, then with fewer
/// GPs, then dedicated, then a ring.
std::vector<Prediction> predict_all(const FrameCosts& costs, const RankCosts& ranks,
                                    const std::vector<Layout>& layouts);

/// "4 GPs + 2 Renderers", "3 colocated ranks, 5 idle", "mesh of 4x3 + 6 Renderers".
std::string describe(const Layout& layout);
/// "668005 visible voxels of 39.5 ns on a GP, 725382 splats of 59.1 ns on a Renderer", for messages.
std::string describe(const FrameCosts& costs);
/// A line for each prediction, with a heading.
std::string to_table(const std::vector<Prediction>& predictions);

}  // namespace ringsplat::app
