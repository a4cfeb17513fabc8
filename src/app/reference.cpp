#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/render_job.hpp"
#include "app/views.hpp"
#include "base/clock.hpp"
#include "base/log.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "frame/slices.hpp"
#include "images/image_file.hpp"
#include "images/image_io.hpp"
#include "options/option_tables.hpp"
#include "options/option_values.hpp"
#include "options/transfer_function_option.hpp"
#include "program/progress.hpp"
#include "program/text_output.hpp"
#include "study/error_budget.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

std::string settings_text(const FrameSpec& spec, const ReferenceOptions& o) {
  auto j = to_json(spec);
  j["volume"] = std::filesystem::path(o.picture.volume.path).filename().string();
  j["truth"] = name(o.truth);
  if (o.truth == TruthKind::field || o.truth == TruthKind::analytic) j["tolerance"] = o.tolerance;
  if (o.truth == TruthKind::analytic) j["formula"] = o.formula;
  return plain_json_text(std::move(j));
}

}  // namespace

ExitCode run(const ReferenceOptions& o) {
  if (o.truth == TruthKind::analytic) static_cast<void>(synth_field(o.formula));
  check_image_name(o.picture.output, "-o", true);
  check_outputs(o.picture);
  load_image_library(false).get();
  if (!o.without_effect.empty())
    log_warning("{} change{} nothing in the {} truth", joined(o.without_effect, ", "),
                o.without_effect.size() == 1 ? "s" : "", name(o.truth));
  const TransferFunctionChoice choice(o.picture.transfer_function, o.picture.colour);
  const auto source = open_volume(o.picture.volume);
  RenderOptions picture = o.picture;
  const std::string view_note = complete_view(picture, source->grid(), source->notes());
  if (!view_note.empty()) log_info("{}", view_note);
  const auto cameras = views_of(picture);
  WholeVolume volume = read_whole(*source);
  FrameSpec spec = picture.frame;
  spec.shown.clip = clip_box(o.picture.clip, source->grid(), source->notes());
  const MadeFunction made = choice.make(volume.statistics, spec.shown);
  spec.shown.tints = tints_of(o.picture.volume.mask, volume.labels);
  check(spec);
  if (!o.picture.transfer_function_out.empty())
    write_text_output(o.picture.transfer_function_out, to_paraview_json(spec.shown.transfer_function));
  truth::Scene& scene = volume.scene;
  const auto pixels = truth::all_pixels(spec.shown.width, spec.shown.height);
  std::FILE* const results = is_stdout(o.picture.transfer_function_out) ? stderr : stdout;
  Progress progress(false, results);
  if (!made.said.empty()) progress.print(made.said);
  scene.poll = [&](double done) { progress.at(done); };
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    spec.shown.camera = cameras[k];
    const double start = now_seconds();
    progress.begin("evaluating the truth", 1);
    const auto true_image = [&](const FrameSpec& frame) {
      scene.frame = frame;
      return truth::to_image(spec.shown.width, spec.shown.height,
                             evaluate(scene, {o.truth, o.tolerance, o.formula}, pixels));
    };
    const CutOpen parts = spec.shown.cut ? cut_open(spec, source->grid()) : CutOpen{spec, {}};
    Image image = true_image(parts.left);
    if (spec.shown.cut) lay_over(image.rgba.data(), true_image(parts.slice).rgba);
    if (spec.shown.depth) take_depths(image, true_image(depth_frame_of(spec)));
    progress.end();
    write_image(image, file_of_view(o.picture, o.picture.output, k), o.picture.background,
                settings_text(spec, o));
    progress.print(fmt::format("{}  {:.2f} s  {} truth",
                               file_of_view(o.picture, o.picture.output, k).string(), now_seconds() - start,
                               name(o.truth)));
  }
  return ExitCode::done;
}

}  // namespace ringsplat::app
