#include "ringsplat/live/live.hpp"

#include <cmath>
#include <mutex>
#include <utility>

#include "base/clock.hpp"
#include "base/srgb.hpp"
#include "classify/auto_preset.hpp"
#include "frame/quality.hpp"
#include "live/hand_over.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/viewer.hpp"

namespace ringsplat {
namespace {

using serve::RunState;
using serve::SteerMessage;

/// What all ranks do next in show().
enum class Act : std::uint8_t { go_on, draw, count_and_draw, answer, hold };

constexpr double soon = 0.2;                ///< seconds, as often as people read
constexpr double most_debt_of_first = 0.5;  ///< seconds owed, up to which a page's first picture is drawn

FrameSpec first_frame(const LiveOptions& options, const ValueStatistics& values) {
  FrameSpec frame;
  if (options.frame) {
    frame = *options.frame;
  } else {
    const AutoChoice choice = choose_function(values);
    frame.shown.camera = {.azimuth = 30, .elevation = 20};
    frame.shown.transfer_function = choice.function;
    if (choice.labels) frame.shown.interpolation = Interpolation::nearest;
  }
  frame.how = sheets_of(Quality::best);
  // A mean of labels is another label.
  frame.shown.reduction.prefilter = frame.shown.interpolation == Interpolation::linear;
  return frame;
}

}  // namespace

struct Live::State {
  State(Session& session_, const LiveOptions& options) : session(session_), share(options.share) {
    if (!SessionParts::draws(session)) hand_over.emplace(session, options.share);
    if (session.visualises()) post.emplace(session);
    agree_after(SessionParts::all(session).collectives(), [&] {
      if (hand_over) return;
      const ValueStatistics& values = SessionParts::values(session, "Live");
      if (!(options.share > 0 && options.share <= 1))
        throw InputError(fmt::format("the share {:g} is not in 0 ... 1", options.share), "0.05 is usual");
      check_values(values);
      range = values.range;
      frame = first_frame(options, values);
      check_frame(frame, SessionParts::grid(session));
      if (session.rank() == 0) start(options, values);
    });
  }
  ~State() {
    if (viewer) viewer->end("The simulation has ended.");
    if (!post || session.rank() != 0) return;
    while (given != Want::end) given = post->wait_for_letter().want;
    post->send(simulation(), {.want = Want::end});
  }

  Collectives& all() { return SessionParts::collectives(session); }

  void start(const LiveOptions& options, const ValueStatistics& values) {
    const Grid& grid = SessionParts::grid(session);
    serve::ViewerOptions v;
    v.layout = post ? "ranks set aside for it" : "the simulation's ranks";
    v.ranks = all().processes();
    v.volume = {options.name, grid, false, options.unit, false, {values.range}, values.histogram};
    v.frame = frame;
    v.initial.shown = frame.shown;
    v.initial.background = linear_to_srgb(options.background);
    const bool light = frame.shown.mode == Mode::composite;
    serve::set_modes(light ? frame.shown.transfer_function : choose_function(values).function, values, v);
    v.target_seconds = options.target_seconds;
    v.server = {options.address,         options.port,           options.allowed_hosts,
                options.allowed_origins, options.allowed_frames, false};
    v.steer = [this](const SteerMessage& message) {
      steer(message);
      tell();
    };
    run.histogram = values.histogram;
    auto made = serve::make_viewer(std::move(v));
    url = made->url();
    const std::lock_guard lock(telling);
    viewer = std::move(made);
  }

  void offer(RunState::Parameter parameter, double& value) {
    const std::lock_guard lock(telling);
    offered.push_back(&value);
    run.parameters.push_back(std::move(parameter));
    set_by_page.push_back(false);
  }

  // On rank 0.

  /// Tells pages how far it is; by any thread.
  void tell() {
    const std::lock_guard lock(telling);
    if (viewer) viewer->tell(run_text(run));
  }

  /// What the driver wants of the simulation. Throws InputError, for the page.
  void steer(const SteerMessage& wants) {
    const std::lock_guard lock(telling);
    if (wants.act == SteerMessage::Act::set) return set(wants.parameter, wants.value);
    run.paused = wants.act != SteerMessage::Act::resume;
    steps_wanted = wants.act == SteerMessage::Act::step ? steps_wanted + 1 : 0;
  }
  /// The mutex is held.
  void set(const std::string& name, double value) {
    const auto found = std::ranges::find(run.parameters, name, &RunState::Parameter::name);
    if (found == run.parameters.end()) throw InputError(fmt::format("the simulation offers no {}", name));
    if (!(value >= found->low && value <= found->high))
      throw InputError(fmt::format("{} must be from {:g} to {:g}", name, found->low, found->high));
    if (!found->choices.empty() && value != std::floor(value))
      throw InputError(fmt::format("{} must be a whole number", name));
    found->value = value;
    set_by_page[std::size_t(found - run.parameters.begin())] = true;
  }
  /// It must not go on.
  bool holds() {
    const std::lock_guard lock(telling);
    return run.paused && steps_wanted == 0;
  }

  /// All parameters as pages want them, for the program. The mutex is held.
  std::vector<double> take_set() {
    std::vector<double> values;
    for (const RunState::Parameter& parameter : run.parameters) values.push_back(parameter.value);
    set_by_page.assign(values.size(), false);
    return values;
  }

  void begin(std::int64_t step, double time, int steps_taken = 1) {
    steps += steps_taken;
    const double passed = now_seconds() - told;
    {
      const std::lock_guard lock(telling);
      for (std::size_t k = 0; k < offered.size(); ++k)
        if (!set_by_page[k]) run.parameters[k].value = *offered[k];
      run.step = step;
      run.time = time;
      if (passed >= soon) run.steps_a_second = std::exchange(steps, 0) / passed;
      if (passed < soon && !run.paused) return;
    }
    if (passed >= soon) told = now_seconds();
    tell();
  }

  Act decide() {
    if (holds()) return Act::hold;
    if (share.debt() > (viewer->has_newcomer() ? most_debt_of_first : 0)) return Act::go_on;
    if (viewer->has_requests()) return Act::answer;
    viewer->renewed(range, true);
    director = viewer->director();
    wanted = director.next_picture();
    if (wanted.empty()) return Act::go_on;
    return now_seconds() - counted < soon ? Act::draw : Act::count_and_draw;
  }

  /// The next act and all parameters as pages want them; nothing while nobody looks.
  Block decision() {
    const bool looked_at = viewer->has_pages();
    const Act act = looked_at ? decide() : Act::go_on;
    const std::lock_guard lock(telling);
    if (!looked_at) {
      run.paused = false;  // whoever paused it is gone
      if (std::ranges::find(set_by_page, true) == set_by_page.end()) return {};
    }
    return to_bytes(act, take_set());
  }

  /// Draws what pages want as long as that may go on.
  Director frames_while(const std::function<bool()>& goes_on) {
    Director frames = viewer->director();
    frames.may_come = [goes_on, may_come = frames.may_come] { return goes_on() && may_come(); };
    frames.next_picture = [goes_on, next = frames.next_picture] {
      return goes_on() ? next() : std::vector<VolumeFrame>();
    };
    return frames;
  }

  /// While they hold the simulation, or until all is answered.
  Director held_frames(Act act) {
    return frames_while(
        [this, act] { return viewer->has_pages() && (act == Act::hold ? holds() : viewer->has_requests()); });
  }

  // On rank 0 of those that are set aside.

  int simulation() { return all().processes(); }  ///< its first rank

  /// Takes what the simulation says and asks it for what pages want. Whether all have to do something else
  /// than draw the step that was given last.
  bool heard() {
    while (const auto came = post->receive()) {
      if (asked != Want::hold || came->want == Want::hold) asked = Want::nothing;
      if (came->want != Want::news) given = came->want;
      if (came->want == Want::end) break;
      take_values(session, came->values, offered);
      begin(came->step, came->time, came->steps);
    }
    if (given == Want::nothing) ask();
    return given != Want::nothing;
  }

  /// What to ask for next.
  Want question() {
    const bool stale = now_seconds() - told >= soon, looked_at = viewer->has_pages();
    const std::lock_guard lock(telling);
    if (!looked_at) run.paused = false;  // whoever paused it is gone
    if (run.paused) return Want::hold;
    if (std::ranges::find(set_by_page, true) != set_by_page.end()) return Want::news;
    if (!looked_at) return Want::nothing;
    return pictures > 0 ? Want::step : stale ? Want::news : Want::nothing;
  }

  /// A question is open until it is answered; only that it waits may be asked meanwhile.
  void ask() {
    const Want want = question();
    if (waiting ? holds() : want <= asked || (asked != Want::nothing && want != Want::hold)) return;
    const std::lock_guard lock(telling);
    // Before the step is told, so that none that is wanted then is lost.
    if (waiting) steps_wanted = std::max(steps_wanted - 1, 0);
    const Letter letter{want, take_set(), std::exchange(waiting, false)};
    asked = want;
    for (int rank = simulation(); rank < (letter.lets_go ? session.ranks() : simulation() + 1); ++rank)
      post->send(rank, letter);
  }

  /// Draws what pages want of the step that was given last, first as of views that move. For another one a
  /// view's picture that is not drawn is dropped.
  Director frames_of_step() {
    Director frames = frames_while([this] { return !heard(); });
    frames.pause = {};  // it would not end when messages come
    frames.unwanted = [this, unwanted = frames.unwanted](const FrameSpec& spec) {
      return unwanted(spec) || (given != Want::nothing && !viewer->has_requests());
    };
    frames.frame_done = [this, done = frames.frame_done](FrameResult&& result) {
      done(std::move(result));
      if (++pictures == 1 && !waiting) viewer->renewed(range, false);
    };
    return frames;
  }

  // On all ranks.

  /// Takes the next step that is given, of all ranks that are set aside; false when none comes any more.
  bool next_step() {
    const Block said = all().broadcast(viewer ? to_bytes(given) : Block{}, 0);
    const auto next = value_of<Want>(said, "what the simulation gives");
    if (next == Want::end) return false;
    if (next == Want::nothing) return true;
    given = Want::nothing;
    pictures = 0;
    session.commit();
    waiting = next == Want::hold;  // unless it was thrown what the simulation's ranks throw, too
    count();
    if (!viewer) return true;
    viewer->renewed(range, !waiting);
    tell();
    return true;
  }

  /// Rank 0's decision; takes its values of the parameters.
  Act agree_on_next() {
    const Block told_by_0 = all().broadcast(viewer ? decision() : Block{}, 0);
    if (told_by_0.empty()) return Act::go_on;
    Act act = Act::go_on;
    std::vector<double> values;
    read_block(told_by_0, "what to do next", act, values);
    take_values(session, values, offered);
    return act;
  }

  /// What pages are told of the values.
  void count() {
    counted = now_seconds();
    const ValueStatistics& values = SessionParts::values(session, "show");
    range = values.range;
    const std::lock_guard lock(telling);
    run.histogram = values.histogram;
  }

  void hold(Act act) {
    const bool goes_on = act == Act::answer;
    if (viewer) viewer->renewed(range, goes_on);
    LoadOptions needed = serve::needed_for_levels(frame, SessionParts::grid(session));
    if (goes_on) needed.factors = {1};
    SessionParts::direct(session, needed, viewer ? held_frames(act) : Director{});
    if (goes_on) return;
    steps = 0;
    told = now_seconds();
  }

  Session& session;
  FrameSpec frame;  ///< what all have in common, but for what is shown
  std::string url;
  std::vector<double*> offered;
  ValueRange range;                   ///< of the volume that was counted last
  std::optional<HandOver> hand_over;  ///< where others draw

  // Rank 0's.
  TimeShare share;
  std::mutex telling;               ///< guards what pages are told and want
  RunState run;                     ///< its parameters in the order in which they were offered
  std::vector<bool> set_by_page;    ///< which of them have values that the program has not yet taken
  int steps_wanted = 0;             ///< while it is paused
  Director director = {};           ///< of the picture that is drawn next
  std::vector<VolumeFrame> wanted;  ///< its frames
  int steps = 0;                    ///< since the rate was told
  std::optional<Post> post;         ///< where ranks are set aside
  Want asked = Want::nothing;       ///< of the simulation, which has not answered yet
  Want given = Want::nothing;       ///< by it, and not yet taken
  bool waiting = false;             ///< it waits
  int pictures = 0;                 ///< of the step that was given last
  double told = now_seconds(), counted = 0;
  std::unique_ptr<serve::Viewer> viewer;  ///< last, as its thread uses what is above
};

Live::Live(Session& session, const LiveOptions& options)
    : state_(std::make_unique<State>(session, options)) {}
Live::~Live() = default;

const std::string& Live::url() const { return state_->url; }

void Live::offer(const std::string& name, double& value, double low, double high) {
  state_->offer({name, value, low, high}, value);
}

void Live::offer(const std::string& name, double& value, const std::vector<std::string>& choices) {
  if (choices.empty()) throw InputError(fmt::format("{} has no choices", name), "name one at least");
  state_->offer({name, value, 0, double(choices.size()) - 1, choices}, value);
}

void Live::show(std::int64_t step, double time) {
  State& s = *state_;
  if (s.hand_over) return s.hand_over->show(step, time, s.offered);
  s.share.step_ends();
  if (s.viewer) s.begin(step, time);
  bool committed = false;
  while (true) {
    const Act act = s.agree_on_next();
    if (act == Act::go_on) break;
    const double begin = now_seconds();
    if (!std::exchange(committed, true)) s.session.commit();
    if (act != Act::draw) s.count();
    if (act == Act::hold || act == Act::answer) {
      s.hold(act);
    } else {
      std::vector<FrameSpec> frames;  // on rank 0, which has decided on them
      for (VolumeFrame& one : s.wanted) frames.push_back(std::move(one.spec));
      SessionParts::render(s.session, frames, s.director.frame_done);
    }
    if (act == Act::hold) continue;
    s.share.spend(now_seconds() - begin);
    break;
  }
  const std::lock_guard lock(s.telling);
  s.steps_wanted = std::max(s.steps_wanted - 1, 0);
  s.share.step_begins();
}

void Live::visualise() {
  State& s = *state_;
  if (!s.session.visualises())
    throw InputError("visualise() is for ranks that are set aside to draw", "the others call show()");
  do
    SessionParts::direct(s.session, serve::needed_for_levels(s.frame, SessionParts::grid(s.session)),
                         s.viewer ? s.frames_of_step() : Director{});
  while (s.next_step());
}

}  // namespace ringsplat
