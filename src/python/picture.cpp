#include "python/picture.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/frame_output.hpp"
#include "app/loading.hpp"
#include "app/render_job.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "images/image_io.hpp"
#include "study/measured_error.hpp"

namespace ringsplat::python {
namespace {

/// The volume, of which a hook is called at each piece that is read.
app::VolumeOptions polled(const app::VolumeOptions& volume, const Hooks& hooks) {
  if (!hooks.poll) return volume;
  app::VolumeOptions result = volume;
  const auto progress = std::make_shared<app::Progress>(
      app::Progress::Listener{[poll = hooks.poll](auto&&...) { poll(); }, {}});
  result.opener = [volume, progress] {
    return std::make_unique<app::WatchedSource>(open_volume(volume), *progress);
  };
  return result;
}

app::Progress::Listener listener(const Hooks& hooks) {
  const auto at = [&hooks](const std::string& what, double done, double total) {
    if (hooks.poll) hooks.poll();
    if (hooks.told) hooks.told(what, done, total);
  };
  return {at, [](const std::string& line) { log_info("{}", line); }};
}

std::vector<FrameSpec> frames_of(const FrameSpec& frame, const std::vector<Camera>& cameras) {
  std::vector<FrameSpec> frames(cameras.size(), frame);
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k].shown.camera = cameras[k];
  return frames;
}

truth::Scene read_scene(const app::VolumeOptions& volume, const Hooks& hooks) {
  const auto source = open_volume(volume);
  truth::Scene scene = app::make_scene(app::read_whole(*source));
  scene.poll = hooks.poll;
  return scene;
}

app::MeasuredError measured(const Picture& picture, truth::Scene& scene, const app::ErrorOptions& error) {
  FrameSpec asked = picture.spec;
  asked.how = picture.asked;
  app::set_frame(scene, asked);
  return app::measure(picture.image, scene, error);
}

}  // namespace

Picture picture_of(FrameResult&& result, const app::RenderOptions& options, const ValueRange& range,
                   const std::optional<app::Annotation>& annotation) {
  std::string why = app::why_empty(result, range);
  if (why.empty()) why = app::why_nearly_empty(result);
  if (!why.empty()) log_warning("{}", why);
  Picture picture;
  picture.image = std::move(result.image);
  picture.spec = std::move(result.spec);
  picture.asked = options.frame.how;
  picture.seconds = result.stats.seconds;
  picture.settings = app::picture_settings(picture.spec, options.volume.path, options.annotate);
  picture.background = options.background;
  if (annotation) picture.overlay = annotation->overlay(picture.spec, range);
  return picture;
}

std::vector<std::uint8_t> display(const Picture& picture) {
  return display_bytes(picture.image, picture.background, picture.overlay);
}

Bytes png(const Picture& picture) {
  return image_bytes(picture.image, ".png", picture.background, picture.settings, picture.overlay);
}

void save(const Picture& picture, const std::filesystem::path& file) {
  check_image_name(file, "the picture's file", !picture.background);
  write_image(picture.image, file, picture.background, picture.settings, picture.overlay);
}

std::vector<Picture> render_pictures(app::RenderOptions options, const Hooks& hooks) {
  const PlainFloats floats;
  options.volume = polled(options.volume, hooks);
  options.run.loopback.poll = hooks.poll;
  app::Launch launch;
  app::Progress progress(listener(hooks));
  app::Job job = app::prepare(options, launch);
  const app::RenderOptions& o = job.options;
  const Wiring wiring = launch.wiring(o.run.loopback);
  Scene scene = app::load(job.volume, job.load, job.layout, wiring, progress);
  const FrameSpec frame = app::choose_frame(job, scene, wiring, progress, launch);
  const ValueRange range = scene.values.range;
  std::vector<Picture> pictures;
  const auto take = [&](FrameResult&& result) {
    pictures.push_back(picture_of(std::move(result), o, range, job.annotation));
    progress.at(double(pictures.size()));
  };
  const auto frames = frames_of(frame, job.cameras);
  progress.begin("rendering", double(frames.size()));
  app::render_all(std::move(scene), job.layout, o.run.protocol, director_of(frames, take), wiring,
                  o.run.engine);
  progress.end();
  const auto judge = [&] {
    std::vector<app::Judged> judged;
    truth::Scene truth = read_scene(o.volume, hooks);
    for (Picture& picture : pictures) {
      if (picture.error) continue;
      picture.error = measured(picture, truth, o.error);
      picture.settings = app::picture_settings(picture.spec, o.volume.path, o.annotate, &*picture.error);
      const std::string name = fmt::format("picture {}", picture.spec.frame);
      judged.push_back({picture.spec, name, picture.error->error.rmse});
    }
    return judged;
  };
  const auto replace = [&](FrameResult&& result) {
    Picture& picture = pictures[std::size_t(result.spec.frame)];
    picture = picture_of(std::move(result), o, range, job.annotation);
  };
  if (o.budget.max_error)
    app::hold_budget(job, {judge, replace}, wiring, progress, launch);
  else if (o.error.truth)
    judge();
  return pictures;
}

app::MeasuredError measure(const Picture& picture, const app::VolumeOptions& volume,
                           const app::ErrorOptions& error, const Hooks& hooks) {
  const PlainFloats floats;
  truth::Scene scene = read_scene(polled(volume, hooks), hooks);
  return measured(picture, scene, error);
}

}  // namespace ringsplat::python
