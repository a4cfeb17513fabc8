#include "frame/frame_geometry.hpp"
#include "session/render_frames.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/sheet_rays.hpp"

namespace ringsplat {

void check_frame(const FrameSpec& spec, const Grid& grid) {
  check(spec);
  if (std::holds_alternative<Sheets>(spec.how))
    static_cast<void>(make_sheet_rays(*make_sheet_frame(spec, grid, 1, 1)));
  else
    static_cast<void>(make_geometry(spec, grid));
}

}  // namespace ringsplat
