#include "options/subcommands.hpp"

#include <fmt/format.h>

#include "options/first_view.hpp"
#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/access.hpp"

namespace ringsplat::app {
namespace {

void require_volume(const CLI::App& app, const VolumeOptions& volume) {
  if (volume.path.empty())
    throw InputError("the VOLUME to work on is missing",
                     fmt::format("for instance ringsplat {} head.nrrd", app.get_name()));
}

void add_render_options(CLI::App& app, AllOptions& all) {
  RenderOptions& o = all.render;
  add_options(app, volume_options, o.volume);
  add_options(app, clip_options, o);
  add_options(app, series_options, o);
  add_options(app, raw_options, o.volume);
  add_options(app, render_output_options, o);
  add_options(app, camera_options, o);
  add_options(app, view_options, o);
  add_options(app, size_options, o);
  add_options(app, colour_options, o);
  add_options(app, tf_output_options, o);
  add_options(app, method_options, o);
  add_options(app, shading_options, o);
  add_options(app, picture_options, o);
  add_options(app, shortcut_options, o);
  add_options(app, rank_options, o.run);
  add_options(app, protocol_options, o.run);
  add_options(app, machine_options, o.run);
  add_options(app, error_options, o.error);
  add_options(app, error_budget_options, o.budget);
}

Command settle_render(const CLI::App& app, AllOptions& all) {
  RenderOptions& o = all.render;
  if (o.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume(app, o.volume);
  // A run that only counts has no picture; a run for statistics needs none.
  if (o.output.empty() && o.stats.empty() && !o.run.engine.simulation.count_only)
    throw InputError("--output is required: the picture to write (or --stats, for the time that it takes)",
                     fmt::format("for instance ringsplat render {} -o out.png", o.volume.path));
  settle_picture(app, o);
  return o;
}

void add_serve_options(CLI::App& app, AllOptions& all) {
  ServeOptions& o = all.serve;
  // Less waiting for tokens; no picture changes (docs/performance.md).
  o.picture.run.protocol.look_ahead = o.picture.run.protocol.send_ahead = 4;
  o.picture.frame.how = sheets_of(Quality::best);
  add_options(app, volume_options, o.picture.volume);
  add_options(app, clip_options, o.picture);
  add_options(app, series_options, o.picture);
  add_options(app, raw_options, o.picture.volume);
  add_options(app, server_options, o);
  add_options(app, camera_options, o.picture);
  add_options(app, size_options, o.picture);
  add_options(app, colour_options, o.picture);
  add_options(app, shading_options, o.picture);
  add_options(app, rank_options, o.picture.run);
  add_options(app, protocol_options, o.picture.run);
}

Command settle_serve(const CLI::App& app, AllOptions& all) {
  RunOptions& run = all.serve.picture.run;
  if (all.serve.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume(app, all.serve.picture.volume);
  static_cast<void>(serve::frame_ancestors(all.serve.allowed_frames));
  note_direction(app, all.serve.picture);  // it fits the sphere: turning changes no sizes
  if (run.topology == Topology::mesh && app.get_option("--send-ahead")->empty()) run.protocol.send_ahead = 0;
  return all.serve;
}

void add_info_options(CLI::App& app, AllOptions& all) {
  InfoOptions& o = all.info;
  add_options(app, volume_options, o.volume);
  add_options(app, clip_options, o.picture);
  add_options(app, raw_options, o.volume);
  add_options(app, info_output_options, o);
  add_options(app, prediction_options, o);
  add_options(app, camera_options, o.picture);
  add_options(app, view_options, o.picture);
  add_options(app, size_options, o.picture);
  add_options(app, colour_options, o.picture);
  add_options(app, method_options, o.picture);
  add_options(app, shading_options, o.picture);
  add_options(app, picture_options, o.picture);
  add_options(app, shortcut_options, o.picture);
}

Command settle_info(const CLI::App& app, AllOptions& all) {
  if (all.info.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  if (!all.info.presets) require_volume(app, all.info.volume);
  settle_fit(app, all.info.picture);
  all.info.picture.frame.how = method_for(all.info.picture.method);
  return all.info;
}

void add_compare_options(CLI::App& app, AllOptions& all) { add_options(app, compare_options, all.compare); }

Command settle_compare(const CLI::App&, AllOptions& all) { return all.compare; }

void add_synth_options(CLI::App& app, AllOptions& all) { add_options(app, synth_options, all.synth); }

Command settle_synth(const CLI::App&, AllOptions& all) { return all.synth; }

void add_reference_options(CLI::App& app, AllOptions& all) {
  ReferenceOptions& o = all.reference;
  add_options(app, volume_options, o.picture.volume);
  add_options(app, clip_options, o.picture);
  add_options(app, raw_options, o.picture.volume);
  add_options(app, truth_options, o);
  add_options(app, reference_output_options, o);
  add_options(app, camera_options, o.picture);
  add_options(app, view_options, o.picture);
  add_options(app, size_options, o.picture);
  add_options(app, colour_options, o.picture);
  add_options(app, tf_output_options, o.picture);
  add_options(app, method_options, o.picture);
  add_options(app, shading_options, o.picture);
  add_options(app, picture_options, o.picture);
}

Command settle_reference(const CLI::App& app, AllOptions& all) {
  if (all.reference.picture.colour.colours == "list") return Say{list_of_colour_maps()};
  require_volume(app, all.reference.picture.volume);
  settle_fit(app, all.reference.picture);
  all.reference.picture.frame.how = method_for(all.reference.picture.method);
  note_options_without_effect(app, all.reference);
  return all.reference;
}

void add_study_options(CLI::App& app, AllOptions& all) { add_options(app, study_options, all.study); }

Command settle_study(const CLI::App&, AllOptions& all) { return all.study; }

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

void settle_picture(const CLI::App& app, RenderOptions& o) {
  settle_fit(app, o);
  o.frame.how = method_for(o.method);
  note_fixed_shortcuts(app, o.budget);
  if (o.budget.max_error && !o.error.truth) o.error.truth = TruthKind::method;
  o.budget.to_field = o.budget.max_error && *o.error.truth == TruthKind::field;
  // A method's truth is its own, so that only the field's tells which engine is nearer.
  if (o.budget.to_field && !engine_is_chosen(app)) o.budget.other_engine = method_for_other_engine(o.method);
}

std::span<const Subcommand> subcommands() { return all_subcommands; }

}  // namespace ringsplat::app
