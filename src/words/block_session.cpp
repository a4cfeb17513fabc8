#include "words/block_session.hpp"

#include "app/views.hpp"
#include "base/log.hpp"
#include "images/image_io.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "options/option_tables.hpp"

namespace ringsplat::words {

BlockSession::BlockSession(Processes processes, const std::vector<std::string>& layout,
                           const SessionOptions& options, const std::string& problem)
    : session_([&] {
        const bool over_mpi = processes.transport() != nullptr;
        Layout nodes;
        agree_after(processes.collectives(), [&] {
          if (!problem.empty()) throw InputError(problem);
          const int aside = options.visualisation_ranks;
          nodes = parse_layout(layout, over_mpi, aside > 0 ? aside : processes.ranks());
        });
        return Session(std::move(processes), nodes, options);
      }()) {}

std::vector<Picture> BlockSession::render(const std::vector<std::string>& words,
                                          const std::vector<app::ViewAngles>& views, const Hooks& hooks) {
  if (!SessionParts::draws(session_)) return {};
  const ValueStatistics& values = SessionParts::values(session_);
  Request wanted;
  agree_after(SessionParts::collectives(session_), [&] {
    check_values(values);
    if (session_.rank() == 0) wanted = request(words, views, values);
  });
  const ValueRange range = values.range;
  std::vector<Picture> pictures;
  SessionParts::render(session_, wanted.frames, [&](FrameResult&& result) {
    pictures.push_back(picture_of(std::move(result), wanted.options, range, wanted.annotation));
    if (hooks.told) hooks.told("rendering", double(pictures.size()), double(wanted.frames.size()));
  });
  return pictures;
}

void BlockSession::draw(const std::vector<std::string>& words, const std::string& file) {
  const auto pictures = render(words, {}, {});
  agree_after(SessionParts::collectives(session_), [&] {
    for (const Picture& p : pictures) {
      try {
        write_image(p.image, file, p.background, p.settings, p.overlay);
      } catch (const RunError& e) {
        throw InputError(e.what());  // the others are told, and go on
      }
    }
  });
}

void BlockSession::act(const std::string& file, std::int64_t step) {
  Actions& actions = actions_.try_emplace(file, file).first->second;
  std::vector<Action> due;
  if (session_.rank() == 0) due = actions.due(step);
  const Block told = SessionParts::all(session_).collectives().broadcast(to_bytes(due.size()), 0);
  due.resize(value_of<std::size_t>(told, "how many pictures are due"));
  if (due.empty()) return;
  commit();
  for (const Action& action : due) {
    try {
      draw(action.words, action.file);
    } catch (const InputError& e) {
      if (session_.rank() == 0) actions.warn(fmt::format("the picture {}: {}", action.name, e.what()));
    }
  }
}

std::string BlockSession::serve(const std::vector<std::string>& words, LiveOptions options) {
  live_.reset();
  offered_.clear();
  agree_after(SessionParts::all(session_).collectives(), [&] {
    if (!SessionParts::draws(session_)) return;
    const ValueStatistics& values = SessionParts::values(session_, "serve");
    check_values(values);
    const Request wanted = request(words, {}, values);
    options.frame = wanted.frames.front();
    options.unit = committed_notes_.unit;
    options.background = wanted.options.background.value_or(options.background);
  });
  live_.emplace(session_, options);
  return live_->url();
}

void BlockSession::offer(const std::string& name, double value, double low, double high,
                         const std::optional<std::vector<std::string>>& choices) {
  Live& shown = live();
  double& kept = offered_.emplace_back(name, value).second;
  if (choices)
    shown.offer(name, kept, *choices);
  else
    shown.offer(name, kept, low, high);
}

BlockSession::Request BlockSession::request(const std::vector<std::string>& words,
                                            const std::vector<app::ViewAngles>& views,
                                            const ValueStatistics& values) const {
  const Grid& grid = SessionParts::grid(session_);
  Request made{parse_picture(words, views, From::session), {}, {}};
  app::RenderOptions& o = made.options;
  const auto tell = [this](const std::string& note) {
    if (!note.empty() && session_.rank() == 0) log_info("{}", note);
  };
  o.volume.path = "session";
  o.frame.shown.clip = app::clip_box(o.clip, grid);
  tell(app::complete_view(o, grid, committed_notes_));
  if (o.annotate) made.annotation.emplace(grid, committed_notes_, o.background, o.colour.range);
  const auto cameras = app::views_of(o);
  const app::TransferFunctionChoice choice(o.transfer_function, o.colour);
  const std::string said = choice.make(values, o.frame.shown).said;
  check(o.frame.shown.transfer_function, o.transfer_function);
  tell(said);
  made.frames = frames_of(o.frame, cameras);
  return made;
}

}  // namespace ringsplat::words
