#include "options/method_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>

#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

[[noreturn]] void refuse(const char* what, Engine engine) {
  throw InputError(fmt::format("{} no effect on {}", what, name(engine)),
                   engine == Engine::splats ? "use --quality best" : "use --quality paper");
}

/// Sets plane and samples, which both methods have; a method on the screen has no samples.
template <class How>
void place(How& how, const MethodOptions& o) {
  how.image_plane = o.image_plane.value_or(how.image_plane);
  if (how.image_plane == ImagePlane::screen) {
    if (o.samples)
      throw InputError("--samples has no effect on the screen, whose pixels --size counts",
                       "leave out --samples or use --image-plane slices");
    how.plane_samples = 1;
    return;
  }
  const double samples = o.samples.value_or(how.plane_samples);
  constexpr bool whole = std::is_integral_v<decltype(how.plane_samples)>;
  if (whole && !(samples == std::floor(samples) && std::abs(samples) < 1e6))
    throw InputError(fmt::format("--samples cannot be {} with splats", samples),
                     "use 1, 2 or 4 pixels a voxel, or --engine sheets");
  how.plane_samples = static_cast<decltype(how.plane_samples)>(samples);
}

Splats splats_for(const MethodOptions& o) {
  if (o.slabs || o.light_points) refuse(o.slabs ? "--slabs has" : "--light-points has", Engine::splats);
  Splats splats = o.splats;
  place(splats, o);
  return splats;
}

Sheets sheets_for(const MethodOptions& o) {
  if (o.splats != Splats{}) refuse("a kernel, payload or precision has", Engine::sheets);
  Sheets sheets = sheets_of(quality_of(o));
  sheets.slabs = o.slabs.value_or(sheets.slabs);
  sheets.light_points = o.light_points.value_or(sheets.light_points);
  place(sheets, o);
  return sheets;
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

const char* name(Engine engine) { return engine == Engine::splats ? Splats::name : Sheets::name; }

Quality quality_of(const MethodOptions& o) {
  if (o.quality) return *o.quality;
  if (!o.engine || *o.engine == engine_of(usual_quality)) return usual_quality;
  return *o.engine == Engine::splats ? Quality::paper : Quality::best;
}

Method method_for(const MethodOptions& o) {
  const Quality quality = quality_of(o);
  if (o.engine && *o.engine != engine_of(quality))
    throw InputError(
        fmt::format("--engine {} and --quality {} contradict each other", name(*o.engine), name(quality)),
        fmt::format("--quality {} draws {}: leave one out", name(quality), name(engine_of(quality))));
  if (engine_of(quality) == Engine::splats) return splats_for(o);
  return sheets_for(o);
}

Method method_for_other_engine(MethodOptions o) {
  o.engine = engine_of(usual_quality) == Engine::splats ? Engine::sheets : Engine::splats;
  return method_for(o);
}

const char* items_of(const Method& method) {
  return std::holds_alternative<Sheets>(method) ? "blocks" : "splats";
}

}  // namespace ringsplat::app
