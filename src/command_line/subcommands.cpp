#include "command_line/subcommands.hpp"

#include <fmt/format.h>

#include "options/first_view.hpp"
#include "options/option_tables.hpp"
#include "options/settle_picture.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/access.hpp"

namespace ringsplat::app {
namespace {

void require_volume(const char* subcommand, const VolumeOptions& volume) {
  if (volume.path.empty())
    throw InputError("the VOLUME to work on is missing",
                     fmt::format("for instance ringsplat {} head.nrrd", subcommand));
}

void add_render_options(OptionList& list, AllOptions& all) {
  RenderOptions& o = all.render;
  add_options(list, volume_options, o.volume);
  add_options(list, clip_options, o);
  add_options(list, series_options, o);
  add_options(list, raw_options, o.volume);
  add_options(list, render_output_options, o);
  add_options(list, camera_options, o);
  add_options(list, view_options, o);
  add_options(list, size_options, o);
  add_options(list, colour_options, o);
  add_options(list, tf_output_options, o);
  add_options(list, method_options, o);
  add_options(list, shading_options, o);
  add_options(list, picture_options, o);
  add_options(list, shortcut_options, o);
  add_options(list, layout_options, o.run);
  add_options(list, rank_options, o.run);
  add_options(list, protocol_options, o.run);
  add_options(list, machine_options, o.run);
  add_options(list, error_options, o.error);
  add_options(list, error_budget_options, o.budget);
}

Command settle_render(const OptionList& list, AllOptions& all) {
  RenderOptions& o = all.render;
  if (o.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume("render", o.volume);
  // A run that only counts has no picture; a run for statistics needs none.
  if (o.output.empty() && o.stats.empty() && !o.run.simulation.count_only)
    throw InputError("--output is required: the picture to write (or --stats, for the time that it takes)",
                     fmt::format("for instance ringsplat render {} -o out.png", o.volume.path));
  settle_picture(list, o);
  return o;
}

void add_serve_options(OptionList& list, AllOptions& all) {
  ServeOptions& o = all.serve;
  // Less waiting for tokens; no picture changes (docs/performance.md).
  o.picture.run.protocol.look_ahead = o.picture.run.protocol.send_ahead = 4;
  o.picture.frame.how = sheets_of(Quality::best);
  add_options(list, volume_options, o.picture.volume);
  add_options(list, clip_options, o.picture);
  add_options(list, series_options, o.picture);
  add_options(list, raw_options, o.picture.volume);
  add_options(list, server_options, o);
  add_options(list, camera_options, o.picture);
  add_options(list, size_options, o.picture);
  add_options(list, colour_options, o.picture);
  add_options(list, shading_options, o.picture);
  add_options(list, layout_options, o.picture.run);
  add_options(list, rank_options, o.picture.run);
  add_options(list, protocol_options, o.picture.run);
}

Command settle_serve(const OptionList& list, AllOptions& all) {
  RunOptions& run = all.serve.picture.run;
  if (all.serve.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume("serve", all.serve.picture.volume);
  static_cast<void>(serve::frame_ancestors(all.serve.allowed_frames));
  note_direction(list, all.serve.picture);  // it fits the sphere: turning changes no sizes
  if (run.topology == Topology::mesh && !list.is_given("--send-ahead")) run.protocol.send_ahead = 0;
  return all.serve;
}

void add_info_options(OptionList& list, AllOptions& all) {
  InfoOptions& o = all.info;
  add_options(list, volume_options, o.volume);
  add_options(list, clip_options, o.picture);
  add_options(list, raw_options, o.volume);
  add_options(list, info_output_options, o);
  add_options(list, prediction_options, o);
  add_options(list, camera_options, o.picture);
  add_options(list, view_options, o.picture);
  add_options(list, size_options, o.picture);
  add_options(list, colour_options, o.picture);
  add_options(list, method_options, o.picture);
  add_options(list, shading_options, o.picture);
  add_options(list, picture_options, o.picture);
  add_options(list, shortcut_options, o.picture);
}

Command settle_info(const OptionList& list, AllOptions& all) {
  if (all.info.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  if (!all.info.presets) require_volume("info", all.info.volume);
  settle_fit(list, all.info.picture);
  all.info.picture.frame.how = method_for(all.info.picture.method);
  return all.info;
}

void add_compare_options(OptionList& list, AllOptions& all) {
  add_options(list, compare_options, all.compare);
}

Command settle_compare(const OptionList&, AllOptions& all) { return all.compare; }

void add_synth_options(OptionList& list, AllOptions& all) { add_options(list, synth_options, all.synth); }

Command settle_synth(const OptionList&, AllOptions& all) { return all.synth; }

void add_reference_options(OptionList& list, AllOptions& all) {
  ReferenceOptions& o = all.reference;
  add_options(list, volume_options, o.picture.volume);
  add_options(list, clip_options, o.picture);
  add_options(list, raw_options, o.picture.volume);
  add_options(list, truth_options, o);
  add_options(list, reference_output_options, o);
  add_options(list, camera_options, o.picture);
  add_options(list, view_options, o.picture);
  add_options(list, size_options, o.picture);
  add_options(list, colour_options, o.picture);
  add_options(list, tf_output_options, o.picture);
  add_options(list, method_options, o.picture);
  add_options(list, shading_options, o.picture);
  add_options(list, picture_options, o.picture);
}

Command settle_reference(const OptionList& list, AllOptions& all) {
  if (all.reference.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume("reference", all.reference.picture.volume);
  settle_fit(list, all.reference.picture);
  all.reference.picture.frame.how = method_for(all.reference.picture.method);
  note_options_without_effect(list, all.reference);
  return all.reference;
}

void add_study_options(OptionList& list, AllOptions& all) { add_options(list, study_options, all.study); }

Command settle_study(const OptionList&, AllOptions& all) { return all.study; }

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
  mpirun -n 4 ringsplat serve head.nrrd --port 8080 --tf mr-surface)";

constexpr const char* info_examples = R"(  ringsplat info head.nrrd
  ringsplat info ct_512x512x300_int16.raw --gps 12 --json
  ringsplat info head.nrrd --ranks 6 --size 1024 --tf mr-surface
  ringsplat info --presets)";

constexpr const char* compare_examples = R"(  ringsplat compare face.png before.png
  ringsplat compare face.exr truth.exr --fail-above 2.5 --diff difference.png --diff-scale 10)";

constexpr const char* synth_examples = R"(  ringsplat synth --list
  ringsplat synth shell -o shell.nrrd --dims 128
  ringsplat synth marschner-lobb -o ml.raw --dims 41x41x41 --type float32)";

constexpr const char* reference_examples =
    R"(  ringsplat reference head.nrrd -o truth.exr --tf mr-soft --size 256
  ringsplat reference ml_41x41x41_float32.raw -o truth.exr --truth analytic --formula marschner-lobb
  ringsplat reference head.nrrd -o turn.exr --truth method --orbit 4)";

constexpr const char* study_examples = R"(  ringsplat study -o study.csv
  ringsplat study --list
  ringsplat study list.toml -o study.csv --keep-images pictures)";

constexpr Subcommand all_subcommands[] = {
    {"render", "Render a volume: one view, an orbit or a path of views",
     "gps = 4, size = \"640x480\" or light = [-0.4, 0.6, 0.7]", render_examples, everyday_render,
     add_render_options, settle_render},
    {"serve", "Show a volume in a browser, drawn by the ranks while it is turned",
     "port = 8080, target-ms = 60 or size = \"640x480\"", serve_examples, everyday_serve, add_serve_options,
     settle_serve},
    {"info", "Say what is in a volume, how much memory its GPs need and how ranks render it soonest",
     "gps = 4 or size = \"640x480\"", info_examples, everyday_info, add_info_options, settle_info},
    {"compare", "Compare two pictures; exit with 1 when they differ too much", "threshold = 2",
     compare_examples, "", add_compare_options, settle_compare},
    {"synth", "Write an analytic test volume", "dims = \"64x64x32\"", synth_examples, "", add_synth_options,
     settle_synth},
    {"reference", "Compute the true picture in double precision, to compare with",
     "size = \"640x480\" or truth = \"field\"", reference_examples, everyday_reference, add_reference_options,
     settle_reference},
    {"study", "Measure speed and error of many settings", "output = \"study.csv\"", study_examples, "",
     add_study_options, settle_study},
};

}  // namespace

std::span<const Subcommand> subcommands() { return all_subcommands; }

}  // namespace ringsplat::app
