#include "ringsplat/session/session.hpp"

#include <exception>
#include <map>
#include <new>
#include <utility>

#include "base/archive.hpp"
#include "base/process.hpp"
#include "classify/auto_preset.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/dealer.hpp"
#include "scene/scene.hpp"
#include "session/render_frames.hpp"

namespace ringsplat {

template <class Archive>
void fields(LoadOptions& o, Archive& archive) {
  archive(o.kept_axes, o.with_normals, o.factors, o.prefilter, o.with_cell_ranges, o.clip);
}

namespace {

// Rows of this size stay in a core's cache while they are packed, sent and placed; larger ones take up to
// twice as long (tests/session/bench_commit.cpp).
constexpr std::size_t round_bytes = std::size_t{1} << 16;

bool contains(const std::vector<int>& all, const std::vector<int>& some) {
  return std::ranges::all_of(some, [&](int one) { return std::ranges::find(all, one) != all.end(); });
}

bool covers(const LoadOptions& made, const LoadOptions& needed) {
  for (const Axis axis : all_axes)
    if (needed.kept_axes[std::size_t(axis)] && !made.kept_axes[std::size_t(axis)]) return false;
  const bool reduced = std::any_of(needed.factors.begin(), needed.factors.end(), [](int f) { return f > 1; });
  return contains(made.factors, needed.factors) && (!reduced || made.prefilter == needed.prefilter) &&
         (!needed.with_normals || (made.with_normals && made.clip == needed.clip)) &&
         (!needed.with_cell_ranges || made.with_cell_ranges);
}

/// Adds to what is needed all of `one` that can be kept beside it.
void add_needs(LoadOptions& all, const LoadOptions& one) {
  for (const Axis axis : all_axes) all.kept_axes[std::size_t(axis)] |= one.kept_axes[std::size_t(axis)];
  if (!all.with_normals) all.clip = one.clip;
  all.with_normals |= one.with_normals;
  all.with_cell_ranges |= one.with_cell_ranges;
  for (const int factor : one.factors)
    if (!contains(all.factors, {factor}) && (factor == 1 || one.prefilter == all.prefilter))
      all.factors.push_back(factor);
}

/// What all the frames need. Throws InputError when they need different things of one slice.
LoadOptions needed_together(const std::vector<FrameSpec>& frames, const Grid& grid) {
  LoadOptions all = needed_to_render(frames.front(), grid);
  for (const FrameSpec& frame : frames) {
    const LoadOptions one = needed_to_render(frame, grid);
    if (one.with_normals && all.with_normals && one.clip != all.clip)
      throw InputError("lit splats cannot be drawn with several clip boxes in one call",
                       "call render() for each clip box, or draw with sheets");
    if (one.prefilter != all.prefilter)
      throw InputError("frames with and without a prefilter cannot be drawn in one call",
                       "call render() for either");
    add_needs(all, one);
  }
  return all;
}

/// Of the processes, of which the first are set aside, those with which this one draws or has blocks; nothing
/// where none are. Collective.
std::optional<Processes> part_of(Processes& all, int set_aside) {
  require_same(all.collectives(), {{"visualisation ranks", std::to_string(set_aside)}},
               "was given other roles", "pass the same SessionOptions on all ranks");
  if (set_aside == 0) return std::nullopt;
  if (set_aside < 0 || set_aside >= all.ranks())
    throw InputError(
        fmt::format("{} of {} ranks cannot be set aside for visualisation", set_aside, all.ranks()),
        "one at least must be left for the simulation");
  return all.collectives().part(all.rank() < set_aside ? 0 : 1);
}

}  // namespace

struct Session::State {
  State(Processes given, const std::optional<Layout>& wanted, const SessionOptions& options)
      : processes(std::move(given)),
        part(part_of(processes, options.visualisation_ranks)),
        draws(!part || processes.rank() < options.visualisation_ranks),
        layout(wanted.value_or(all_draw(part ? options.visualisation_ranks : processes.ranks()))),
        wiring{peers().collectives(), peers().transport()} {
    engine.threads_per_rank = options.threads_per_rank;
    protocol = running_ahead(layout.topology);
    protocol.stall_timeout = options.stall_timeout;
    for (Processes* each : {&processes, &peers()})
      each->collectives().patience = {options.stall_timeout, false};
    // Several processes would wait for one that ends a call by itself.
    if (processes.transport() == nullptr) wiring.loopback.poll = options.poll;
  }

  static Layout all_draw(int ranks) {
    return {.gps = ranks, .renderers = ranks, .placement = Placement::colocated};
  }
  /// The ranks with which this one draws; where it does not those that have blocks.
  Processes& peers() { return part ? *part : processes; }

  /// Begins a call that these ranks make together: all must be in the same one, and all throw when one has an
  /// error, now or from a call before that was its own.
  void enter(const std::string& call, const std::string& error, Collectives& ranks) {
    const std::string before = std::exchange(problem, {});
    const auto all = [&] {
      const auto watched = ranks.watched(fmt::format("late for {}()", call), false);
      return ranks.all_gather(to_bytes(call, before.empty() ? error : before));
    }();
    std::vector<std::string> calls, errors;
    for (const Block& block : all) {
      FromBytes archive(block);
      archive(calls.emplace_back(), errors.emplace_back());
    }
    for (std::size_t rank = 0; rank < calls.size(); ++rank)
      if (calls[rank] != calls.front())
        throw InputError(
            fmt::format("rank {} called {}() while rank 0 called {}()", rank, calls[rank], calls.front()),
            "all ranks make the same calls of a session in the same order");
    throw_first(errors);
  }
  /// The same of a call of those that draw.
  void enter_to_draw(const std::string& call, const std::string& error) {
    if (!draws)
      throw InputError(fmt::format("rank {} called {}() and does not draw", processes.rank(), call),
                       "call it on the ranks that are set aside");
    enter(call, error, wiring.collectives);
  }

  const Grid& committed() const {
    if (!committed_grid)
      throw InputError("there is no volume yet", "call set_grid(), add_block() and commit() first");
    return *committed_grid;
  }

  // All processes call what follows, with the same arguments but for the blocks.

  /// Takes the voxels of all processes' blocks in place of the volume before. Throws the same InputError on
  /// all when grids, layouts or blocks do not fit; then the volume stays as it was.
  void commit_blocks() {
    Collectives& all = processes.collectives();
    agree_after(all, [&] {
      check(*grid, "the grid");
      if (draws) check_wiring(layout, wiring);
    });
    const Wiring of_all{all, processes.transport()};
    require_same_scene(*grid, {}, layout, of_all);
    check_blocks(*grid, blocks, all);
    const Sharing sharing = sharing_of(layout, of_all);
    scene.reset();
    known_values.reset();
    std::string error;
    if (!committed_grid || facts_of(*committed_grid) != facts_of(*grid)) {
      committed_grid.reset();
      slices.clear();
      try {
        for (int gp = 0; gp < sharing.dealing.gps; ++gp)
          if (sharing.hosts(gp))
            slices.emplace(gp, SliceStore(*grid, gp, sharing.dealing, {false, false, true}, false));
      } catch (const std::bad_alloc&) {
        slices.clear();
        error = "there is no memory for the volume's slices; hint: use more ranks on more machines";
      }
    }
    agree(all, error);
    committed_grid = grid;
    deal_blocks(*grid, blocks, slices, round_bytes, sharing);
  }

  /// What frames need that need all this.
  Scene scene_for(const LoadOptions& needed) {
    if (!scene || !covers(made, needed)) {
      const LoadOptions before = std::exchange(made, needed);
      if (scene) add_needs(made, before);
      scene.reset();
      scene = deal_scene_again(*committed_grid, slices, made, sharing_of(layout, wiring));
    }
    return *scene;
  }

  Processes processes;
  std::optional<Processes> part;
  bool draws;
  Layout layout;
  Wiring wiring;  ///< of the peers
  EngineOptions engine;
  ProtocolOptions protocol;
  std::optional<Grid> grid;  ///< the next commit's
  std::vector<VoxelBlock> blocks;
  std::string problem;  ///< the first since the last collective call

  // The volume that was put together of blocks. GPs keep its z slices; what frames need besides is made of
  // them when it is first needed.
  std::optional<Grid> committed_grid;
  std::map<int, SliceStore> slices;
  std::optional<ValueStatistics> known_values;
  LoadOptions made;  ///< the scene's
  std::optional<Scene> scene;
};

Session::Session(Processes processes, const std::optional<Layout>& layout, const SessionOptions& options)
    : state_(std::make_unique<State>(std::move(processes), layout, options)) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

int Session::rank() const { return state_->processes.rank(); }
int Session::ranks() const { return state_->processes.ranks(); }
bool Session::visualises() const { return state_->part && state_->draws; }

void Session::set_grid(const Grid& grid) {
  state_->grid = grid;
  state_->blocks.clear();
}

int Session::add_block(const VoxelBox& extent, const void* first_voxel,
                       const std::optional<Strides>& strides) {
  const std::size_t scalar = size_of(state_->grid ? state_->grid->type : ScalarType::uint8);
  state_->blocks.push_back({extent, static_cast<const std::byte*>(first_voxel),
                            strides.value_or(x_fastest(extent.dims(), scalar))});
  return int(state_->blocks.size()) - 1;
}

void Session::update_block(int block, const void* first_voxel, const std::optional<Strides>& strides) {
  if (block < 0 || block >= int(state_->blocks.size()))
    return SessionParts::note_problem(
        *this, fmt::format("there is no block {}; this rank has {}; hint: pass a number that add_block() "
                           "returned after the last set_grid()",
                           block, state_->blocks.size()));
  VoxelBlock& changed = state_->blocks[std::size_t(block)];
  changed.first_voxel = static_cast<const std::byte*>(first_voxel);
  changed.strides = strides.value_or(changed.strides);
}

void Session::clear_blocks() { state_->blocks.clear(); }

void Session::commit() {
  const PlainFloats floats;
  State& s = *state_;
  s.enter("commit",
          s.grid ? "" : "the volume has no grid; hint: call set_grid() before add_block() and commit()",
          s.processes.collectives());
  s.commit_blocks();
}

void SessionParts::note_problem(Session& session, const std::string& problem) {
  if (session.state_->problem.empty()) session.state_->problem = problem;
}

ValueRange Session::range() { return SessionParts::values(*this, "range").range; }

const ValueStatistics& SessionParts::values(Session& session, const char* call) {
  const PlainFloats floats;
  Session::State& s = *session.state_;
  s.enter_to_draw(call, input_error_of([&] { static_cast<void>(s.committed()); }));
  if (!s.known_values) s.known_values = share_values(s.slices, *s.committed_grid, {}, s.wiring.collectives);
  return *s.known_values;
}

TransferFunction Session::transfer_function(const std::string& name) {
  const PlainFloats floats;
  const ValueStatistics& values = SessionParts::values(*this, "transfer_function");
  TransferFunction made;
  agree_after(state_->wiring.collectives, [&] {
    made = name == "auto" ? choose_function(values).function : preset(name, values.histogram);
  });
  return made;
}

Image Session::render(const FrameSpec& frame) {
  Image image;
  render({frame}, [&image](Image&& made) { image = std::move(made); });
  return image;
}

void Session::render(const std::vector<FrameSpec>& frames, const std::function<void(Image&&)>& take) {
  SessionParts::render(*this, frames, [&take](FrameResult&& result) { take(std::move(result.image)); });
}

void SessionParts::render(Session& session, const std::vector<FrameSpec>& frames,
                          const std::function<void(FrameResult&&)>& take) {
  const PlainFloats floats;
  Session::State& s = *session.state_;
  if (!s.draws) return;
  std::optional<LoadOptions> needed;  // on rank 0, where there are frames
  s.enter_to_draw("render", input_error_of([&] {
                    const Grid& grid = s.committed();
                    check(s.engine);
                    check(s.protocol);
                    if (s.processes.rank() != 0 || frames.empty()) return;
                    for (const FrameSpec& frame : frames) check_frame(frame, grid);
                    needed = needed_together(frames, grid);
                  }));
  const Block told = s.wiring.collectives.broadcast(needed ? to_bytes(*needed) : Block{}, 0);
  if (told.empty()) return;
  needed = value_of<LoadOptions>(told, "what frames need");
  if (s.wiring.loopback.poll) needed->told = [poll = s.wiring.loopback.poll](double, bool) { poll(); };
  // What is thrown between messages would leave the other ranks waiting.
  std::exception_ptr thrown;
  const auto take_one = [&](FrameResult&& result) {
    if (thrown) return;
    try {
      take(std::move(result));
    } catch (...) {
      thrown = std::current_exception();
    }
  };
  Scene scene = s.scene_for(*needed);
  render_frames(std::move(scene), s.layout, s.protocol, director_of(frames, take_one), s.wiring, s.engine);
  if (thrown) std::rethrow_exception(thrown);
}

void check_values(const ValueStatistics& values, const std::string& hint) {
  if (values.range.empty())
    throw InputError("the volume has no finite value: every voxel is not-a-number or infinite", hint);
}

void SessionParts::direct(Session& session, const LoadOptions& needed, Director director) {
  const PlainFloats floats;
  Session::State& s = *session.state_;
  s.enter_to_draw("show", input_error_of([&] { static_cast<void>(s.committed()); }));
  render_frames(s.scene_for(needed), s.layout, s.protocol, std::move(director), s.wiring, s.engine);
}

Collectives& SessionParts::collectives(Session& session) { return session.state_->peers().collectives(); }
Processes& SessionParts::all(Session& session) { return session.state_->processes; }
bool SessionParts::draws(const Session& session) { return session.state_->draws; }
const Grid& SessionParts::grid(const Session& session) { return session.state_->committed(); }

}  // namespace ringsplat
