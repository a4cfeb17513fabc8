#pragma once
#include "options/option_list.hpp"
#include "options/options.hpp"

/// All options of subcommands as tables, which fill `o`, and what completes it once they are read.
/// subcommands.cpp gives each subcommand its options; contradictions.hpp has the rules between them.
namespace ringsplat::app {

void add_volume_options(OptionList& list, VolumeOptions& o);
void add_layout_options(OptionList& list, RunOptions& o);
void add_rank_options(OptionList& list, RunOptions& o);
void add_protocol_options(OptionList& list, RunOptions& o);
void add_machine_options(OptionList& list, RunOptions& o);
// In the order of --help, which puts size, transfer function and the rest of a picture below one heading.
void add_clip_options(OptionList& list, RenderOptions& o);
void add_series_options(OptionList& list, RenderOptions& o);
void add_render_output_options(OptionList& list, RenderOptions& o);
void add_camera_options(OptionList& list, RenderOptions& o);
void add_view_options(OptionList& list, RenderOptions& o);
void add_size_options(OptionList& list, RenderOptions& o);
void add_tf_output_options(OptionList& list, RenderOptions& o);
void add_method_options(OptionList& list, RenderOptions& o);
void add_shading_options(OptionList& list, RenderOptions& o);
void add_picture_options(OptionList& list, RenderOptions& o);
void add_shortcut_options(OptionList& list, RenderOptions& o);
void add_error_options(OptionList& list, RenderOptions& o);
void add_server_options(OptionList& list, ServeOptions& o);
void add_info_options(OptionList& list, InfoOptions& o);
void add_compare_options(OptionList& list, CompareOptions& o);
void add_reference_options(OptionList& list, ReferenceOptions& o);
void add_synth_options(OptionList& list, SynthOptions& o);
void add_pyramid_options(OptionList& list, PyramidOptions& o);

/// Completes what all pictures have in common: the method, the mode of several channels where none is given,
/// what --zoom 1 fits, whether some option says from where the volume is seen, and what an error budget may
/// change. Throws InputError when options do not fit together.
void settle_picture(const OptionList& list, RenderOptions& o);
/// Records which given options change nothing: `reference` takes render's, and not all concern a truth.
void note_options_without_effect(const OptionList& list, ReferenceOptions& o);

/// Makes angles of --view. Without any option that says from where, a patient is seen from the front, all
/// else from above and the right; but what would be seen from one of its narrow sides is seen from its broad
/// one: returns a line that says so, or an empty text. Call it once the volume is open.
[[nodiscard]] std::string complete_view(RenderOptions& o, const Grid& grid, const VolumeNotes& notes);

}  // namespace ringsplat::app
