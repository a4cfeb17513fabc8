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
  double slices = 1;           ///< slices traversed
  double gp = 0;               ///< classify, shade and encode all of them
  std::vector<double> region;  ///< draw, composite and deliver, by region
  int columns = 1;             ///< regions in a row of the picture
  double frame = 0;            ///< each GP's setup before its first slice
  double visible_voxels = 0, splats = 0;
  const char* items = "splats";  ///< what `splats` counts: these, or sheets' blocks
  double renderer() const;       ///< the sum over all regions
};

/// Where the ranks run.
struct RankCosts {
  int cores = 1;                   ///< shared by all ranks
  double hop = 2.5e-6;             ///< seconds from sending a message to receiving it
  double message_software = 2e-6;  ///< core seconds for one message, both sides together
  double sharing = 1;              ///< factor on a frame's time when ranks share cores
  double token = 0;                ///< a GP's seconds for passing on a token, besides messages
};

enum class Limit { gps, renderers, cores };
const char* name(Limit limit);  ///< "the GPs", "the Renderers", "the cores"

struct Prediction {
  Layout layout;
  double gp = 0;        ///< seconds of the busiest GP, or rank
  double renderer = 0;  ///< seconds of the busiest Renderer; colocated: of the rank's Renderer
  double shared = 0;    ///< all work over all cores
  double tokens = 0;    ///< passing the tokens through all slices
  double seconds = 0;   ///< of a frame
  Limit limit = Limit::gps;
};

/// Predicts a frame's time: that of the busier side plus the cost of tokens. A token passes a slice with
/// three messages one after another (payload, accept, token), each with as many hops as the topology needs;
/// all Renderers' tokens move at once as far as there are cores for their software. Overlap of frames, which
/// hides some of it, is ignored: it helps all layouts alike.
Prediction predict(const FrameCosts& costs, const RankCosts& ranks, const Layout& layout);

/// Mean hops of messages between neighbours in the order of slices, and between a GP and a Renderer, there
/// and back.
struct MeanHops {
  double token = 1, payload = 1, accept = 1;
};
MeanHops mean_hops(const Layout& layout);

/// All ways to give `ranks` ranks their roles: rings with every dedicated split or with all ranks colocated;
/// with `meshes` also every mesh of at least 2x2 GPs that uses all ranks, with a Renderer at the left end or
/// at both ends of each row. When `cores` is not 0 and there are more ranks, also rings of `cores` ranks with
/// the others idle.
std::vector<Layout> possible_layouts(int ranks, bool meshes, int cores = 0);

/// These layouts with bundles of so many slices.
std::vector<Layout> in_bundles(std::vector<Layout> layouts, int bundle);

/// Predictions for these layouts, the fastest first. Among equals fewer Renderers come first, then fewer GPs,
/// then dedicated, then a ring.
std::vector<Prediction> predict_all(const FrameCosts& costs, const RankCosts& ranks,
                                    const std::vector<Layout>& layouts);

/// The layout for sheets among `layouts`: the colocated ring, with idle ranks where that is allowed. Nearly
/// all work is the Renderers', so every working rank should be one, and its GP only copies. Nothing when none
/// is colocated.
std::optional<Layout> colocated_ring(const std::vector<Layout>& layouts);

/// "4 GPs + 2 Renderers", "3 colocated ranks, 5 idle", "mesh of 4x3 + 6 Renderers".
std::string describe(const Layout& layout);
/// "668005 visible voxels of 39.5 ns on a GP, 725382 splats of 59.1 ns on a Renderer, ...", for messages.
std::string describe(const FrameCosts& costs);
/// A line for each prediction, with a heading.
std::string to_table(const std::vector<Prediction>& predictions);

}  // namespace ringsplat::app
