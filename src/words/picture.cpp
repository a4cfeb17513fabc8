#include "words/picture.hpp"

#include <nlohmann/json.hpp>

#include "app/frame_output.hpp"
#include "app/render_job.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "options/contradictions.hpp"
#include "options/option_tables.hpp"
#include "program/launch.hpp"

namespace ringsplat::words {
namespace {

using app::Option;
using app::OptionList;
using app::RenderOptions;

OptionList options_for(RenderOptions& o, From from) {
  OptionList list;
  if (from == From::volume) app::add_volume_options(list, o.volume);
  for (const auto add : {app::add_clip_options, app::add_render_output_options, app::add_camera_options,
                         app::add_view_options, app::add_size_options, app::add_method_options,
                         app::add_shading_options, app::add_picture_options, app::add_shortcut_options})
    add(list, o);
  if (from == From::volume) {
    app::add_error_options(list, o);
    app::add_rank_options(list, o.run);
  }
  list.leave_out(app::Mark::of_program);
  return list;
}

InputError unexpected(const std::string& what) {
  return {what, "help(ringsplat.render) describes the options"};
}

/// "--name", "--name=value" or "--name=value" and further words of the value.
void read(OptionList& list, const app::Words& words) {
  for (std::size_t k = 0; k < words.size();) {
    const auto equals = words[k].find('=');
    const std::string name = words[k].substr(0, equals);
    const auto option = std::ranges::find_if(list, [&](const Option& o) { return o.has_name(name); });
    if (option == list.end()) throw unexpected(fmt::format("'{}' is not expected here", words[k]));
    app::Words given{equals == std::string::npos ? "true" : words[k].substr(equals + 1)};
    for (++k; k < words.size() && !words[k].starts_with("--"); ++k) given.push_back(words[k]);
    const std::size_t wanted = option->is_flag() ? 1 : std::size_t(option->reader.words);
    if (given.size() != wanted)
      throw unexpected(fmt::format("{} needs {} values, not {}", name, wanted, given.size()));
    option->given = given;
  }
  list.read();
  refuse_contradictions(list);
}

/// The volume, of which a hook is called at each piece that is read.
app::VolumeOptions polled(const app::VolumeOptions& volume, const Hooks& hooks) {
  if (!hooks.poll) return volume;
  app::VolumeOptions result = volume;
  result.opener = [volume, poll = hooks.poll](const VolumeChoice& choice) {
    app::VolumeOptions chosen = volume;
    chosen.choice = choice;
    return std::make_unique<app::WatchedSource>(open_volume(chosen), [poll](int) { poll(); });
  };
  return result;
}

truth::Scene read_scene(const app::VolumeOptions& volume, const Hooks& hooks) {
  const auto source = open_volume(volume);
  truth::Scene scene = app::read_whole(*source).scene;
  if (hooks.poll) scene.poll = [poll = hooks.poll](double) { poll(); };
  return scene;
}

app::MeasuredError measured(Picture& picture, truth::Scene& scene, const app::ErrorOptions& error) {
  scene.frame = picture.spec;
  scene.frame.how = picture.asked;
  return app::measure(picture.image, scene, error);
}

}  // namespace

RenderOptions parse_picture(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                            From from) {
  RenderOptions o;
  OptionList list = options_for(o, from);
  read(list, words);
  o.views = views;
  app::settle_picture(list, o);
  o.run.transport = app::TransportChoice::loopback;
  return o;
}

Layout parse_layout(const std::vector<std::string>& words, bool over_mpi, int ranks) {
  if (words.empty()) return {.gps = ranks, .renderers = ranks, .placement = Placement::colocated};
  app::RunOptions o;
  OptionList list;
  app::add_layout_options(list, o);
  read(list, words);
  if (o.choose_roles)
    throw InputError("a session's roles cannot be chosen by a measured frame, as it has no volume yet",
                     "give numbers instead of auto");
  return app::choose_layout(o, over_mpi, over_mpi ? ranks : 1);
}

std::string picture_options_json() {
  RenderOptions o;
  const OptionList in_sessions = options_for(o, From::session);
  auto list = nlohmann::json::array();
  for (const Option& option : options_for(o, From::volume))
    list.push_back({{"name", option.name().substr(2)},
                    {"form", option.form},
                    {"default", option.fallback},
                    {"help", option.help},
                    {"group", option.heading},
                    {"values", option.reader.words},
                    {"session", in_sessions.find(option.name()) != nullptr}});
  return list.dump();
}

Picture picture_of(FrameResult&& result, const app::RenderOptions& options, const ValueRange& range,
                   const std::optional<app::Annotation>& annotation,
                   const std::vector<app::DrawnChannel>& channels) {
  std::string why = app::why_empty(result, range);
  if (why.empty()) why = app::why_nearly_empty(result);
  if (!why.empty()) log_warning("{}", why);
  Picture picture;
  picture.image = std::move(result.image);
  picture.spec = std::move(result.spec);
  picture.asked = options.frame.how;
  picture.seconds = result.stats.seconds;
  picture.settings = app::picture_settings(picture.spec, options.volume.path, options.annotate, channels);
  picture.background = options.background;
  if (annotation) picture.overlay = annotation->overlay(picture.spec, range);
  return picture;
}

std::vector<Picture> render_pictures(app::RenderOptions options, const Hooks& hooks) {
  const PlainFloats floats;
  options.volume = polled(options.volume, hooks);
  options.run.poll = hooks.poll;
  app::Launch launch;
  const auto at = [&hooks](const std::string& what, double done, double total) {
    if (hooks.poll) hooks.poll();
    if (hooks.told) hooks.told(what, done, total);
  };
  app::Progress progress(app::Progress::Listener{at, [](const std::string& line) { log_info("{}", line); }});
  app::Job job = app::prepare(options, launch);
  const app::RenderOptions& o = job.options;
  ValueRange range;
  std::vector<Picture> pictures;
  const auto take = [&](FrameResult&& result) {
    pictures.push_back(picture_of(std::move(result), o, range, job.annotation, job.channels));
    progress.at(double(pictures.size()));
  };
  Scene scene;
  app::SeriesLoader loader(job, app::pictures_at_once(job, job.cameras.size()), progress, launch);
  loader.load_channels(scene, 0);
  const auto frames = app::choose_frames(job, scene, progress, launch);
  range = scene.values.range;
  progress.begin("rendering", double(job.cameras.size()));
  app::render_all(job, o.run.protocol, std::move(scene), app::director_of(job, 0, frames, take), launch);
  progress.end();
  const auto judge = [&] {
    std::vector<app::Judged> judged;
    truth::Scene truth = read_scene(o.volume, hooks);
    for (Picture& picture : pictures) {
      if (picture.error) continue;
      picture.error = measured(picture, truth, o.error);
      picture.settings = app::picture_settings(picture.spec, o.volume.path, o.annotate, {}, &*picture.error);
      const std::string name = fmt::format("picture {}", picture.spec.frame);
      judged.push_back({picture.spec, name, picture.error->held()});
    }
    return judged;
  };
  const auto replace = [&](FrameResult&& result) {
    Picture& picture = pictures[std::size_t(result.spec.frame)];
    picture = picture_of(std::move(result), o, range, job.annotation, job.channels);
  };
  if (o.budget.max_error)
    app::hold_budget(job, {judge, replace}, progress, launch);
  else if (o.error.truth)
    judge();
  return pictures;
}

app::MeasuredError measure(const Picture& picture, const app::VolumeOptions& volume,
                           const app::ErrorOptions& error, const Hooks& hooks) {
  if (app::names_channels(volume.choice.channel))
    throw InputError("a picture of several channels has no error", "draw one channel by itself");
  const PlainFloats floats;
  truth::Scene scene = read_scene(polled(volume, hooks), hooks);
  Picture same = picture;
  return measured(same, scene, error);
}

}  // namespace ringsplat::words
