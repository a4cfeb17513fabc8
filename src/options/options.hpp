#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/label_notes.hpp"
#include "frame/quality.hpp"
#include "options/option_values.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/net/layout.hpp"
#include "session/render.hpp"
#include "simulate/simulation.hpp"

/// Settings of the subcommands. option_tables.hpp has the options that set them.
namespace ringsplat::app {

/// The sides of --view. Left and right are the patient's where a file says that there is one, else those of
/// the view from the front.
enum class Side { front, back, left, right, top, bottom };
constexpr const char* name(Side side) {
  constexpr const char* names[] = {"front", "back", "left", "right", "top", "bottom"};
  return names[static_cast<int>(side)];
}

enum class TransportChoice { automatic, mpi, loopback };

/// The volume's file, the description of a raw file, which of a file's volumes, and what is shown of it.
struct VolumeOptions {
  std::string path;
  RawDescription raw;
  VolumeChoice choice;
  ShownLabels mask;
  /// Opens it where it is no file; `path` is then its name for people.
  std::function<std::unique_ptr<VolumeSource>(const VolumeChoice&)> opener = {};
};

/// True when --channel means channels that are drawn together: a list, or one with a colour.
inline bool names_channels(const std::string& channel) {
  return channel == "all" || channel.find_first_of(",=") != std::string::npos;
}

std::unique_ptr<VolumeSource> open_volume(const VolumeOptions& volume);
/// Chooses a part of what `volume` does.
inline VolumeOptions part_of(VolumeOptions volume, const VoxelBox& part) {
  volume.choice.crop = [before = volume.choice.crop, part](const Grid& whole) {
    const glm::ivec3 first = before ? before(whole).first : glm::ivec3(0);
    return VoxelBox{part.first + first, part.end + first};
  };
  return volume;
}

/// What a segmentation's file says of its labels, by the bytes that stand for them.
std::map<double, detail::LabelNotes> notes_of(const ShownLabels& mask);
/// Those of the labels that --mask tints or outlines, `labels` but 0, in the file's colours or usual ones.
std::vector<Tint> tints_of(const ShownLabels& mask, const std::vector<double>& labels);

/// Where the nodes run and how they talk.
struct RunOptions {
  TransportChoice transport = TransportChoice::automatic;
  std::optional<int> gps, renderers;  ///< an omitted number follows from the number of ranks
  bool choose_roles = false;   ///< one of them is "auto": chosen by the time that a frame is foreseen to take
  std::optional<int> bundle;   ///< without it 1, or what is chosen with the roles of a described machine
  bool choose_bundle = false;  ///< it is "auto"
  std::optional<Placement> placement;
  Topology topology = Topology::ring;
  std::optional<glm::ivec2> mesh;        ///< columns and rows of GPs
  Routing routing = Routing::manhattan;  ///< in a mesh
  ProtocolOptions protocol;
  std::optional<int> threads_per_rank;  ///< without it the rank's share of the cores
  EngineOptions engine;                 ///< its threads are settled when the ranks' cores are known
  SimulationOptions simulation;
  std::function<void()> poll = {};  ///< in one process: called between turns; may throw to end the run
  std::string machine;              ///< a file; empty: none. Read into `simulation`.
};

/// One of several views: azimuth, elevation, roll and zoom that it has instead of the options' camera's.
using ViewAngles = std::array<std::optional<double>, 4>;

/// Changes of the transfer function that --tf chooses.
struct ColourOptions {
  std::optional<DataRange> range;  ///< what it spans
  double opacity = 1;              ///< as dense so many times
  std::string colours;             ///< a colour map's name; empty: its own colours
  bool log = false;                ///< on a logarithmic axis
  bool labels = false;             ///< a colour for each value instead
  /// The display colour of a channel that is drawn with others: colours go from black to it.
  std::optional<glm::dvec3> tint;
  /// Between voxels; without a value nearest for labels, else linear.
  std::optional<Interpolation> interpolation;
  Mode mode = Mode::composite;
  std::optional<double> isovalue;  ///< of Mode::surface; without a value one that parts the volume's values
  bool values = false;             ///< instead of colours
  bool slice = false;              ///< of a single slice, where labels are told apart
};

/// Which truth a picture is measured against (docs/accuracy.md).
enum class TruthKind { method, field, analytic, certified };
constexpr const char* name(TruthKind kind) {
  constexpr const char* names[] = {"method", "field", "analytic", "certified"};
  return names[static_cast<int>(kind)];
}
/// Throws InputError that lists the names; `option` is the option that was given.
TruthKind truth_from(const std::string& name, const std::string& option);

/// What turns voxels into pixels.
enum class Engine { splats, sheets };
constexpr const char* name(Engine engine) { return engine == Engine::splats ? Splats::name : Sheets::name; }

/// How pictures are drawn when neither --engine nor --quality says: by sheets.
inline constexpr Quality usual_quality = Quality::best;

/// What the user says of a frame's method; method_for() makes the frame's `how` of it.
struct MethodOptions {
  std::optional<Engine> engine;
  std::optional<Quality> quality;
  /// Its kernel and payload count; plane and samples are below.
  Splats splats;
  std::optional<ImagePlane> image_plane;
  std::optional<double> samples;
  std::optional<int> slabs, light_points, layers;
};

/// The quality's method with all that `options` say instead, as far as the method has it (contradictions.hpp
/// has the rules). Throws InputError for samples that splats cannot have.
Method method_for(const MethodOptions& options);

/// What the method's payloads hold, for messages: "splats", or "blocks" of sheets.
const char* items_of(const Method& method);

/// What `render --error` measures.
struct ErrorOptions {
  std::optional<TruthKind> truth;  ///< nothing: measure nothing
  std::size_t pixels = 4096;       ///< pixels at which the truth is evaluated
  std::uint64_t seed = 1;
  bool all = false;      ///< pictures, though no calibrations, are measured at all pixels
  std::string map = {};  ///< the file of a picture of the errors; empty: none
  std::optional<double> guaranteed =
      {};  ///< of certified pictures: what errs more becomes the truth, in 1/255
};

struct ErrorBudgetOptions {
  std::optional<double> max_error;   ///< RMSE in 1/255 against the chosen truth; nothing: choose nothing
  bool guarantee = false;            ///< each pixel is to be proved within it
  std::set<std::string> fixed = {};  ///< the options of settings that the user gave, so they are not chosen
  bool to_field = false;             ///< the error is against the field's truth or bounds, not the method's
};

struct RenderOptions {
  VolumeOptions volume;
  std::optional<FrameRange> frames;       ///< of a series of volumes
  std::vector<std::string> more_volumes;  ///< of the viewer's series, beside the first
  RunOptions run;
  /// Without its transfer function, which may depend on the volume's histogram, and its clip box, which
  /// follows from `clip` and the volume's grid. Its `how` follows from `method`.
  FrameSpec frame;
  BoxOf clip;
  std::optional<Axis> slice;   ///< one slice across it is shown, which `clip` tells
  bool oblique_slice = false;  ///< what lies in the frame's clip plane is shown
  /// The volume is cut open along this slice, of which complete_view() makes the frame's cut.
  BoxOf cut_at;
  std::optional<Axis> cut_across;
  MethodOptions method;
  std::string transfer_function = "auto", transfer_function_out;
  ColourOptions colour;
  int orbit = 0;
  std::string path;
  std::vector<ViewAngles> views;  ///< of a caller in this process, instead of an orbit or a path
  std::optional<Side> side;       ///< complete_view() makes angles of it
  bool direction_chosen = false;  ///< some option says from where the volume is seen
  std::optional<Fit> fit;         ///< empty: chosen by the other options
  bool annotate = false;
  std::string output, stats, trace;
  bool stats_as_table = false;
  ErrorOptions error;
  ErrorBudgetOptions budget;
  std::optional<glm::dvec3> background;  ///< linear light
};

/// Each of its pictures needs a second frame of a volume.
inline bool in_several_frames(const RenderOptions& o) {
  return o.frame.shown.depth || o.frame.shown.cut || o.cut_across;
}

struct ServeOptions {
  /// The volume, the run, and the view that is shown first. Its method is the viewer's to choose.
  RenderOptions picture;
  double target_ms = 40;
  double coarse_above_mib = 128;
  std::string address = "127.0.0.1";
  int port = 0;
  std::vector<std::string> allowed_hosts, allowed_origins, allowed_frames;
  bool open = false;
};

struct InfoOptions {
  int gps = 0;     ///< 0: several usual numbers
  int bundle = 1;  ///< slices of a bundle
  bool json = false, presets = false;
  int ranks = 0;          ///< ranks to predict frame times for; 0: no prediction
  int cores = 0;          ///< cores that the ranks share; 0: this machine's
  std::string machine;    ///< a file: predict for it; empty: for this machine
  RenderOptions picture;  ///< the volume, and the picture to predict for
};

struct CompareOptions {
  std::string a, b, difference;
  double threshold = 1;  ///< in 1/255
  double difference_scale = 1;
  std::optional<double> fail_above;  ///< RMSE in 1/255
  bool json = false;
};

struct SynthOptions {
  std::string name, output;
  glm::ivec3 dims{64};
  ScalarType type = ScalarType::uint8;
  glm::dvec3 spacing{1.0};
  bool no_compression = false, list = false;
};

struct PyramidOptions {
  VolumeOptions volume;
  std::string output;   ///< the folder
  bool labels = false;  ///< the values must not be mixed
};

struct ReferenceOptions {
  RenderOptions picture;  ///< volume, views, transfer function, shading, output
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula;  ///< analytic truth: the field in synth_names() that the volume samples
  std::vector<std::string> without_effect;  ///< given options that this truth ignores
};

}  // namespace ringsplat::app
