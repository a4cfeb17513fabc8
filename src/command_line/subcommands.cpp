#include "command_line/command_line.hpp"

#include <algorithm>
#include <limits>

#include "base/text.hpp"
#include "options/option_tables.hpp"
#include "options/transfer_function_option.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/access.hpp"

namespace ringsplat::app {
namespace {

/// True when the user asks for the names of colour maps instead of work on a volume, which must not be
/// missing.
bool asks_for_colour_maps(const char* subcommand, const RenderOptions& o) {
  if (o.colour.colours == "list") return true;
  if (o.volume.path.empty())
    throw InputError("the VOLUME to work on is missing",
                     fmt::format("for instance ringsplat {} head.nrrd", subcommand));
  return false;
}

void refuse_several_channels(const char* subcommand, const VolumeOptions& volume) {
  if (names_channels(volume.choice.channel))
    throw InputError(
        fmt::format("--channel {}: ringsplat {} shows one channel", volume.choice.channel, subcommand),
        "choose one; ringsplat render and serve draw several");
}

void add_volume(OptionList& list, RenderOptions& o, bool series) {
  add_volume_options(list, o.volume);
  add_clip_options(list, o);
  if (series) add_series_options(list, o);
}

void add_picture(OptionList& list, RenderOptions& o, bool writes_function) {
  add_camera_options(list, o);
  add_view_options(list, o);
  add_size_options(list, o);
  if (writes_function) add_tf_output_options(list, o);
  add_method_options(list, o);
  add_shading_options(list, o);
  add_picture_options(list, o);
}

void add_ranks(OptionList& list, RunOptions& o) {
  add_layout_options(list, o);
  add_rank_options(list, o);
  add_protocol_options(list, o);
}

void add_render(OptionList& list, RenderOptions& o) {
  add_volume(list, o, true);
  add_render_output_options(list, o);
  add_picture(list, o, true);
  add_shortcut_options(list, o);
  add_ranks(list, o.run);
  add_machine_options(list, o.run);
  add_error_options(list, o);
}

/// Sheets run ahead of tokens; described machines keep to the paper's protocol, but for layers.
void settle_protocol(const OptionList& list, RenderOptions& o) {
  const auto* const sheets = std::get_if<Sheets>(&o.frame.how);
  if (sheets == nullptr || (!o.run.machine.empty() && sheets->layers == 0)) return;
  const auto unless_given = [&list](const char* option, int& value, int usual) {
    if (!list.is_given(option)) value = usual;
  };
  ProtocolOptions& protocol = o.run.protocol;
  const ProtocolOptions ahead = running_ahead(o.run.topology);
  unless_given("--slots", protocol.slots, ahead.slots);
  // Slices of different layers go to different Renderers: none should wait for another's token.
  unless_given("--look-ahead", protocol.look_ahead, sheets->layers > 0 ? INT_MAX : ahead.look_ahead);
  unless_given("--send-ahead", protocol.send_ahead, ahead.send_ahead);
}

Command settle_render(const OptionList& list, RenderOptions& o) {
  if (asks_for_colour_maps("render", o)) return Say{list_of_colour_maps()};
  // A run that only counts has no picture; a run for statistics needs none.
  if (o.output.empty() && o.stats.empty() && !o.run.simulation.count_only)
    throw InputError("--output is required: the picture to write (or --stats, for the time that it takes)",
                     fmt::format("for instance ringsplat render {} -o out.png", o.volume.path));
  settle_picture(list, o);
  settle_protocol(list, o);
  return o;
}

void add_serve(OptionList& list, ServeOptions& options) {
  RenderOptions& o = options.picture;
  // Less waiting for tokens, also of splats; no picture changes (docs/performance.md).
  o.run.protocol.look_ahead = o.run.protocol.send_ahead = 4;
  add_volume(list, o, true);
  add_server_options(list, options);
  add_camera_options(list, o);
  add_size_options(list, o);
  add_shading_options(list, o);
  add_ranks(list, o.run);
}

Command settle_serve(const OptionList& list, ServeOptions& options) {
  RenderOptions& o = options.picture;
  if (asks_for_colour_maps("serve", o)) return Say{list_of_colour_maps()};
  settle_picture(list, o);
  o.frame.shown.camera.fit = Fit::sphere;  // turning changes no sizes
  static_cast<void>(serve::frame_ancestors(options.allowed_frames));
  if (o.run.topology == Topology::mesh && !list.is_given("--send-ahead")) o.run.protocol.send_ahead = 0;
  settle_protocol(list, o);
  return options;
}

void add_info(OptionList& list, InfoOptions& o) {
  add_volume(list, o.picture, false);
  add_info_options(list, o);
  add_picture(list, o.picture, false);
  add_shortcut_options(list, o.picture);
}

Command settle_info(const OptionList& list, InfoOptions& o) {
  if (!o.presets && asks_for_colour_maps("info", o.picture)) return Say{list_of_colour_maps()};
  refuse_several_channels("info", o.picture.volume);
  settle_picture(list, o.picture);
  if (o.machine.empty()) settle_protocol(list, o.picture);
  return o;
}

void add_reference(OptionList& list, ReferenceOptions& o) {
  add_volume(list, o.picture, false);
  add_reference_options(list, o);
  add_picture(list, o.picture, true);
}

Command settle_reference(const OptionList& list, ReferenceOptions& o) {
  if (asks_for_colour_maps("reference", o.picture)) return Say{list_of_colour_maps()};
  refuse_several_channels("reference", o.picture.volume);
  settle_picture(list, o.picture);
  note_options_without_effect(list, o);
  return o;
}

void add_pyramid(OptionList& list, PyramidOptions& o) {
  add_volume_options(list, o.volume);
  add_pyramid_options(list, o);
}

Command settle_pyramid(const OptionList&, PyramidOptions& o) {
  refuse_several_channels("pyramid", o.volume);
  if (o.volume.mask.covered != Covered::alone)
    throw InputError("--mask-as: a pyramid holds no labels over its voxels", "make one of the segmentation");
  return o;
}

template <class Options>
Command as_read(const OptionList&, Options& options) {
  return options;
}

template <class Options, void (*add)(OptionList&, Options&),
          Command (*settle)(const OptionList&, Options&) = as_read<Options>>
Settle bound(OptionList& list) {
  const auto options = std::make_shared<Options>();
  add(list, *options);
  return [options](const OptionList& given) { return settle(given, *options); };
}

constexpr const char* render_examples =
    R"(  ringsplat render head.nrrd -o face.png --tf mr-surface --background slate
  mpirun -n 6 ringsplat render head.nrrd -o turn.png --gps 4 --renderers 2 --orbit 36 --elevation 15
  ringsplat render ct_512x512x300_int16.raw -o bone.exr --spacing 0.7x0.7x1 --tf ct-bone --stats bone.json
  ringsplat render 'step_*.nrrd' --frames all -o film.png --tf mr-soft)";

/// All others are below --help-all.
constexpr const char* everyday_render =
    "--frame --frames --channel --clip --output --background --annotate --stats --view --azimuth --elevation "
    "--zoom --orbit --size --tf --shading --quality --range --opacity --colours --threads-per-rank";
constexpr const char* everyday_serve =
    "--frame --frames --channel --clip --port --open --background --view --azimuth --elevation --zoom --size "
    "--tf --shading --range --opacity --colours --threads-per-rank";
constexpr const char* everyday_info =
    "--frame --channel --series --dims --type --offset --spacing --clip --gps --json --presets --ranks";
constexpr const char* everyday_reference =
    "--frame --channel --clip --truth --formula --output --view --azimuth --elevation --zoom --orbit --size "
    "--tf --shading --quality --range --opacity --colours";

constexpr const char* serve_examples = R"(  ringsplat serve head.nrrd --open
  mpirun -n 4 ringsplat serve head.nrrd --port 8080 --tf mr-surface
  ringsplat serve before.nrrd after.nrrd)";

constexpr const char* info_examples = R"(  ringsplat info head.nrrd
  ringsplat info ct_512x512x300_int16.raw --gps 12 --json
  ringsplat info head.nrrd --ranks 6 --size 1024 --tf mr-surface
  ringsplat info --presets)";

constexpr const char* compare_examples = R"(  ringsplat compare face.png before.png
  ringsplat compare face.exr truth.exr --fail-above 2.5 --diff difference.png --diff-scale 10)";

constexpr const char* synth_examples = R"(  ringsplat synth --list
  ringsplat synth shell -o shell.nrrd --dims 128
  ringsplat synth marschner-lobb -o ml.raw --dims 41x41x41 --type float32)";

constexpr const char* pyramid_examples = R"(  ringsplat pyramid scan.mha scan.zarr
  mpirun -n 8 ringsplat pyramid ct_4096x4096x4096_uint16.raw ct.zarr --spacing 0.002
  ringsplat render ct.zarr -o part.png --crop 1000:1512,800:1312,0:512)";

constexpr const char* reference_examples =
    R"(  ringsplat reference head.nrrd -o truth.exr --tf mr-soft --size 256
  ringsplat reference ml_41x41x41_float32.raw -o truth.exr --truth analytic --formula marschner-lobb
  ringsplat reference head.nrrd -o turn.exr --truth method --orbit 4)";

constexpr Subcommand all_subcommands[] = {
    {"render", "Render a volume: one view, an orbit or a path of views",
     "gps = 4, size = \"640x480\" or light = [-0.4, 0.6, 0.7]", render_examples, everyday_render,
     bound<RenderOptions, add_render, settle_render>},
    {"serve", "Show a volume in a browser, drawn by the ranks while it is turned",
     "port = 8080, target-ms = 60 or size = \"640x480\"", serve_examples, everyday_serve,
     bound<ServeOptions, add_serve, settle_serve>},
    {"info", "Say what is in a volume, how much memory its GPs need and how ranks render it soonest",
     "gps = 4 or size = \"640x480\"", info_examples, everyday_info,
     bound<InfoOptions, add_info, settle_info>},
    {"compare", "Compare two pictures; exit with 1 when they differ too much", "threshold = 2",
     compare_examples, "", bound<CompareOptions, add_compare_options>},
    {"synth", "Write an analytic test volume", "dims = \"64x64x32\"", synth_examples, "",
     bound<SynthOptions, add_synth_options>},
    {"pyramid",
     "Write a volume in coarser and coarser levels, as OME-Zarr, for when it is too large as a whole",
     "labels = true", pyramid_examples, "", bound<PyramidOptions, add_pyramid, settle_pyramid>},
    {"reference", "Compute the true picture in double precision, to compare with",
     "size = \"640x480\" or truth = \"field\"", reference_examples, everyday_reference,
     bound<ReferenceOptions, add_reference, settle_reference>},
};

/// Writes "1", "1.0" and "1e0" alike. Integers that a double cannot hold stay as they are.
std::string plain(const std::string& word) {
  const auto number = detail::number_in<double>(word);
  const bool exact = word.size() <= std::numeric_limits<double>::digits10;
  return number && exact ? fmt::format("{}", *number + 0) : word;
}

std::string value_of(const Option& option) {
  std::string value = option.is_flag() ? "false" : option.fallback;
  if (option.is_given()) value = option.is_flag() ? option.given.back() : joined(option.given, " ");
  // Names of files are compared letter by letter.
  if (!option.is_positional() && option.form.find("FILE") == std::string::npos) {
    auto words = detail::words_of(value);
    for (std::string& word : words) word = plain(word);
    value = joined(words, " ");
  }
  return value.empty() ? "(none)" : value;
}

}  // namespace

std::span<const Subcommand> subcommands() { return all_subcommands; }

Facts settled_options(const char* subcommand, const OptionList& options, const OptionList& program) {
  constexpr std::string_view may_differ[] = {"--config", "--verbose", "--help", "--help-all"};
  Facts facts{{"subcommand", subcommand}};
  for (const OptionList* list : {&options, &program})
    for (const Option& option : *list)
      if (std::ranges::find(may_differ, option.name()) == std::end(may_differ))
        facts.push_back({option.is_positional() ? option.form : option.name(), value_of(option)});
  return facts;
}

}  // namespace ringsplat::app
