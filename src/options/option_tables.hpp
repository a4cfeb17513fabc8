#pragma once
#include "options/option_list.hpp"
#include "options/options.hpp"

/// All options of subcommands as tables, which fill `o`, and what completes it once they are read.
/// subcommands.cpp gives each subcommand its options; contradictions.hpp has the rules between them.
namespace ringsplat::app {

template <class Options>
using AddOptions = void(OptionList& list, Options& o);

AddOptions<VolumeOptions> add_volume_options;
AddOptions<RunOptions> add_layout_options, add_rank_options, add_protocol_options, add_machine_options;
// In the order of --help, which puts size, transfer function and the rest of a picture below one heading.
AddOptions<RenderOptions> add_clip_options, add_series_options, add_render_output_options, add_camera_options,
    add_view_options, add_size_options, add_tf_output_options, add_method_options, add_shading_options,
    add_picture_options, add_shortcut_options, add_error_options;
AddOptions<ServeOptions> add_server_options;
AddOptions<InfoOptions> add_info_options;
AddOptions<CompareOptions> add_compare_options;
AddOptions<ReferenceOptions> add_reference_options;
AddOptions<SynthOptions> add_synth_options;
AddOptions<PyramidOptions> add_pyramid_options;

/// Completes what all pictures have in common: the method, the mode of several channels where none is given,
/// what --zoom 1 fits, whether some option says from where the volume is seen, and what an error budget may
/// change. Throws InputError when options do not fit together.
void settle_picture(const OptionList& list, RenderOptions& o);
/// Records which given options change nothing: `reference` takes render's, and not all concern a truth.
void note_options_without_effect(const OptionList& list, ReferenceOptions& o);

/// Makes angles of --view, has --slice seen from straight before it, and --cut be a plane. Without any option
/// that says from where, a patient is seen from the front, all else from above and the right; but what would
/// be seen from one of its narrow sides is seen from its broad one: returns a line that says so, or an empty
/// text. Call it once the volume is open.
[[nodiscard]] std::string complete_view(RenderOptions& o, const Grid& grid, const VolumeNotes& notes);

}  // namespace ringsplat::app
