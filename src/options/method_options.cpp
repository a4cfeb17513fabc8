#include <fmt/format.h>

#include <cmath>
#include <type_traits>

#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// With plane and samples, which both methods have; a method on the screen has no samples.
template <class How>
How placed(How how, const MethodOptions& o) {
  how.image_plane = o.image_plane.value_or(how.image_plane);
  const double samples = how.image_plane == ImagePlane::screen ? 1 : o.samples.value_or(how.plane_samples);
  constexpr bool whole = std::is_integral_v<decltype(how.plane_samples)>;
  if (whole && !(samples == std::floor(samples) && std::abs(samples) < 1e6))
    throw InputError(fmt::format("--samples cannot be {} with splats", samples),
                     "use 1, 2 or 4 pixels a voxel, or --engine sheets");
  how.plane_samples = static_cast<decltype(how.plane_samples)>(samples);
  return how;
}

}  // namespace

void add_method_options(OptionList& list, RenderOptions& o) {
  list.below("Picture") += {
      {"--quality", nullptr, name(usual_quality),
       "Splats as in the paper, or sheets, from the fastest (draft) to the most exact (best); single options "
       "come first",
       choice(o.method.quality, named({Quality::paper, Quality::draft, Quality::normal, Quality::best}))},
      {"--engine", nullptr, nullptr,
       "Splats: voxels are classified and splatted; sheets: scalars are interpolated and then classified; "
       "without it --quality says",
       choice(o.method.engine, named({Engine::splats, Engine::sheets}))},
      {"--slabs", "1|2|3|4", nullptr,
       "Sheets: pre-integrated slabs from slice to slice; without it 2 for --quality draft and normal, else "
       "3",
       value(o.method.slabs), Mark::of_sheets},
      {"--light-points", "1|2", nullptr,
       "Sheets: points of a slab that are lit; without it 1 for --quality draft, else 2",
       value(o.method.light_points), Mark::of_sheets},
  };
}

Method method_for(const MethodOptions& o) {
  // The other options change its settings; without --quality those of the engine's best known.
  const Quality quality = o.quality.value_or(o.engine == Engine::splats ? Quality::paper : usual_quality);
  if (quality == Quality::paper) return placed(o.splats, o);
  Sheets sheets = sheets_of(quality);
  sheets.slabs = o.slabs.value_or(sheets.slabs);
  sheets.light_points = o.light_points.value_or(sheets.light_points);
  return placed(sheets, o);
}

const char* items_of(const Method& method) {
  return std::holds_alternative<Sheets>(method) ? "blocks" : "splats";
}

}  // namespace ringsplat::app
