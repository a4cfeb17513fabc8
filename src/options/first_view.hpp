#pragma once
#include "options/option_list.hpp"
#include "options/options.hpp"

/// From where a volume is seen, and how large, where single options leave it open.
namespace ringsplat::app {

/// Chooses what --zoom 1 fits, and notes whether some option says from where the volume is seen. Throws
/// InputError for a --fit without effect.
void settle_fit(const OptionList& list, RenderOptions& o);
void note_direction(const OptionList& list, RenderOptions& o);

/// Makes angles of --view. Without any option that says from where, a patient is seen from the front, all
/// else from above and the right; but what would be seen from one of its narrow sides is seen from its broad
/// one: returns a line that says so, or an empty text. Call it once the volume is open.
[[nodiscard]] std::string complete_view(RenderOptions& o, const Grid& grid, const VolumeNotes& notes);

}  // namespace ringsplat::app
