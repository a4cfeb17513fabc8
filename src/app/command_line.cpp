#include "app/command_line.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/option_values.hpp"
#include "app/settled_options.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* program_footer = R"(Examples:
  ringsplat render head.nrrd -o head.png
  mpirun -n 6 ringsplat render head.nrrd -o head.png --gps 4 --renderers 2 --tf mr-surface --azimuth 30
  ringsplat info head_256x256x128_uint8.raw
  ringsplat render --help

Exit codes: 0 done, 1 a comparison failed, 2 wrong usage or bad input, 3 a failure while running.)";

constexpr const char* render_examples =
    R"(  ringsplat render head.nrrd -o face.png --tf mr-surface --background slate
  mpirun -n 6 ringsplat render head.nrrd -o turn.png --gps 4 --renderers 2 --orbit 36 --elevation 15
  ringsplat render ct_512x512x300_int16.raw -o bone.exr --spacing 0.7x0.7x1 --tf ct-bone --stats bone.json)";

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

/// What a subcommand's help ends with; `config` is a line of a configuration for it.
std::string footer_with(const char* config, const char* examples) {
  return fmt::format(
      "Any option can be put into a TOML file and read with --config FILE: a line such as {}.\n"
      "What the command line says comes first. --verbose says more, on every rank.\n\nExamples:\n{}",
      config, examples);
}

/// TOML whose keys outside of any [section] are options of the subcommand on the command line.
class SubcommandToml : public CLI::ConfigTOML {
 public:
  explicit SubcommandToml(const CLI::App& program) : program_(program) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    auto read = CLI::ConfigTOML::from_config(in);
    const auto chosen = program_.get_subcommands();
    for (auto& item : read)
      if (item.parents.empty() && !chosen.empty() &&
          program_.get_option_no_throw("--" + item.name) == nullptr)
        item.parents = {chosen.front()->get_name()};
    return read;
  }

 private:
  const CLI::App& program_;
};

/// "--zoom NUMBER [1]": CLI11's own line glues the default to the type and counts values.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string text = option->get_type_name().empty() ? "" : " " + option->get_type_name();
    if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + "]";
    return option->get_required() && !option->get_positional() ? text + " (required)" : text;
  }
};

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (text.ends_with(' ') || text.ends_with('.')) text.pop_back();
  return text;
}

std::string with_hint(const std::string& problem, const std::string& hint) {
  return one_line(problem) + "; hint: " + hint;
}

/// All names a subcommand's options go by.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// A word too many; without a subcommand CLI11 only says that one is missing, though it may be misspelt.
bool is_about_extras(const CLI::App& program, const CLI::ParseError& error) {
  return dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
         (program.get_subcommands().empty() && program.remaining_size(true) > 0);
}

/// Where to look: the help of the subcommand that was being parsed, or an option much like the unknown one.
std::string hint_for(const CLI::App& program, const CLI::ParseError& error) {
  const auto chosen = program.get_subcommands();
  const std::string help =
      chosen.empty() ? "ringsplat --help shows the subcommands"
                     : fmt::format("ringsplat {} --help shows the options", chosen.front()->get_name());
  if (!is_about_extras(program, error)) return help;
  for (const auto& extra : program.remaining(true)) {
    auto known = chosen.empty() ? std::vector<std::string>() : option_names(*chosen.front());
    if (!extra.starts_with("-") && chosen.empty())
      for (const auto* subcommand : program.get_subcommands({})) known.push_back(subcommand->get_name());
    const std::string alike = closest(extra.substr(0, extra.find('=')), known);
    if (!alike.empty()) return fmt::format("did you mean {}? {}", alike, help);
  }
  return help;
}

/// CLI11's words where they are clear, ours where they are not.
std::string problem_of(const CLI::App& program, const CLI::ParseError& error) {
  if (dynamic_cast<const CLI::ConfigError*>(&error) != nullptr)
    return fmt::format("the --config file has a key that is no option: {}", error.what());
  if (dynamic_cast<const CLI::FileError*>(&error) != nullptr)
    return fmt::format("the --config file cannot be read: {}", error.what());
  if (is_about_extras(program, error)) {
    std::string extras;
    for (const auto& extra : program.remaining(true)) extras += (extras.empty() ? "" : " ") + extra;
    return fmt::format("'{}' is not expected here", extras);
  }
  return error.what();
}

/// A run that only counts has no picture, and one that is only timed needs none.
void require_output(const RenderOptions& render) {
  const SimulationOptions& simulation = render.run.engine.simulation;
  if (render.output.empty() && render.stats.empty() && !simulation.count_only)
    throw InputError("--output is required: the picture to write (or --stats, for the time that it takes)",
                     fmt::format("for instance ringsplat render {} -o out.png", render.volume.path));
  if (simulation.voxel_weight != 1 && !simulation.count_only)
    throw InputError("--voxel-weight has no effect on pictures", "add --count-only, or leave it out");
}

void require_volume(const CLI::App& subcommand, const VolumeOptions& volume) {
  if (volume.path.empty())
    throw InputError("the VOLUME to work on is missing",
                     fmt::format("for instance ringsplat {} head.nrrd", subcommand.get_name()));
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  RenderOptions render;
  InfoOptions info;
  CompareOptions compare;
  SynthOptions synth;
  ReferenceOptions reference;
  StudyOptions study;

  CLI::App program(
      "ringsplat renders volumes on one process or on many MPI ranks: GPs hold slices and make splats,\n"
      "Renderers own parts of the screen, tokens keep the slices in order.",
      "ringsplat");
  program.set_version_flag("--version", "ringsplat " RINGSPLAT_VERSION);
  program.set_help_flag("-h,--help", "Print this help");
  auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(34);
  program.formatter(formatter);
  program.footer(program_footer);
  program.fallthrough();
  program.require_subcommand(1);
  program.add_flag("--verbose", line.verbose, "Say more, on every rank");
  program.set_config("--config", "", "A TOML file with options")->type_name("FILE");
  program.config_formatter(std::make_shared<SubcommandToml>(program));
  program.allow_config_extras(CLI::config_extras_mode::error);

  auto* render_app =
      program.add_subcommand("render", "Render a volume: one view, an orbit or a path of views");
  add_volume_options(*render_app, render.volume);
  add_render_output_options(*render_app, render);
  add_view_options(*render_app, render);
  add_picture_options(*render_app, render);
  add_shortcut_options(*render_app, render);
  add_run_options(*render_app, render.run);
  add_error_options(*render_app, render.error);
  add_error_budget_options(*render_app, render.budget);
  render_app->footer(footer_with("gps = 4, size = \"640x480\" or light = [-0.4, 0.6, 0.7]", render_examples));
  auto* info_app = program.add_subcommand(
      "info", "Say what is in a volume, how much memory its GPs need and how ranks render it soonest");
  add_volume_options(*info_app, info.volume);
  add_info_options(*info_app, info);
  add_view_options(*info_app, info.picture);
  add_picture_options(*info_app, info.picture);
  info_app->remove_option(info_app->get_option("--tf-out"));  // a prediction writes no file
  add_shortcut_options(*info_app, info.picture);
  info_app->footer(footer_with("gps = 4 or size = \"640x480\"", info_examples));
  auto* compare_app =
      program.add_subcommand("compare", "Compare two pictures; exit with 1 when they differ too much");
  add_compare_options(*compare_app, compare);
  compare_app->footer(footer_with("threshold = 2", compare_examples));
  auto* synth_app = program.add_subcommand("synth", "Write an analytic test volume");
  add_synth_options(*synth_app, synth);
  synth_app->footer(footer_with("dims = \"64x64x32\"", synth_examples));
  auto* reference_app =
      program.add_subcommand("reference", "Compute the true picture in double precision, to compare with");
  add_volume_options(*reference_app, reference.picture.volume);
  add_reference_options(*reference_app, reference);
  add_view_options(*reference_app, reference.picture);
  add_picture_options(*reference_app, reference.picture);
  reference_app->footer(footer_with("size = \"640x480\" or truth = \"field\"", reference_examples));
  auto* study_app = program.add_subcommand("study", "Measure speed and error of many settings");
  add_study_options(*study_app, study);
  study_app->footer(footer_with("output = \"study.csv\"", study_examples));

  try {
    program.parse(argc, argv);
    line.options = settled_options(program);
    refuse_contradictions(program);
    for (const auto* subcommand : program.get_subcommands()) refuse_contradictions(*subcommand);
    if (render_app->parsed()) {
      require_volume(*render_app, render.volume);
      require_output(render);
      note_fixed_shortcuts(*render_app, render.budget);
      if (render.budget.max_error) render.error.truth = TruthKind::method;
      line.command = render;
    } else if (info_app->parsed()) {
      if (!info.presets) require_volume(*info_app, info.volume);
      line.command = info;
    } else if (compare_app->parsed()) {
      line.command = compare;
    } else if (reference_app->parsed()) {
      require_volume(*reference_app, reference.picture.volume);
      note_options_without_effect(*reference_app, reference);
      line.command = reference;
    } else if (study_app->parsed()) {
      line.command = study;
    } else {
      line.command = synth;
    }
  } catch (const CLI::CallForHelp&) {
    const auto chosen = program.get_subcommands();
    line.command = Say{chosen.empty() ? program.help() : chosen.front()->help("ringsplat")};
  } catch (const CLI::CallForVersion& e) {
    line.command = Say{std::string(e.what()) + "\n"};
  } catch (const CLI::ParseError& e) {
    line.error = with_hint(problem_of(program, e), hint_for(program, e));
  } catch (const InputError& e) {
    line.error = one_line(e.what());
  } catch (const std::exception& e) {
    line.error = with_hint(fmt::format("an option's value cannot be understood: {}", e.what()),
                           "--help shows the options");
  }
  return line;
}

}  // namespace ringsplat::app
