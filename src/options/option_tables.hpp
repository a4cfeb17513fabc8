#pragma once
#include "options/option_list.hpp"
#include "options/reference_options.hpp"

/// All options of subcommands as data. subcommands.cpp gives each subcommand its groups; contradictions.hpp
/// has the rules between options.
namespace ringsplat::app {

extern const OptionGroup<VolumeOptions> volume_options, raw_options;
extern const OptionGroup<RunOptions> layout_options, rank_options, protocol_options, machine_options;
/// In the order of --help, which puts size, transfer function and the rest of a picture below one heading.
extern const OptionGroup<RenderOptions> render_output_options, view_options, size_options, tf_output_options,
    method_options, picture_options, shortcut_options, clip_options, series_options;
/// Parts of the above that a viewer has, too.
extern const OptionGroup<RenderOptions> camera_options, shading_options;
/// Changes of the transfer function.
extern const OptionGroup<RenderOptions> colour_options;
extern const OptionGroup<ErrorOptions> error_options;
extern const OptionGroup<ErrorBudgetOptions> error_budget_options;
extern const OptionGroup<ServeOptions> server_options;
extern const OptionGroup<InfoOptions> info_output_options, prediction_options;
extern const OptionGroup<CompareOptions> compare_options;
extern const OptionGroup<ReferenceOptions> truth_options, reference_output_options;
extern const OptionGroup<StudyOptions> study_options;
extern const OptionGroup<SynthOptions> synth_options;

}  // namespace ringsplat::app
