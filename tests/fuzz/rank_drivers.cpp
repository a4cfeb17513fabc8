// Tests a whole rank. An input is what the others send it in a frame.
#include <algorithm>
#include <stdexcept>

#include "fuzz/driver.hpp"
#include "net/loopback.hpp"
#include "protocol/rank.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/scene.hpp"
#include "session/directed_frames.hpp"
#include "session/render_frames.hpp"
#include "simulate/meter.hpp"
#include "support/scenes.hpp"

namespace ringsplat::fuzz {
namespace {

struct Job {
  Layout layout;
  ProtocolOptions protocol;
  FrameSpec spec{.how = Splats{}};
  bool count_only = false;
};

FrameSpec frame_of_ranks() {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33, .elevation = 21};
  spec.shown.width = 48;
  spec.shown.height = 40;
  spec.division.region_size = 16;
  spec.shown.transfer_function = test::ramp(20, 255, 0.9);
  spec.shown.shading = Shading::none;
  return spec;
}

const std::vector<Job>& jobs() {
  static const std::vector<Job> all = [] {
    const FrameSpec spec = frame_of_ranks();
    FrameSpec shaded = spec;
    shaded.shown.shading = Shading::phong;
    shaded.as<Splats>().image_plane = ImagePlane::slices;
    ProtocolOptions ahead;
    ahead.send_ahead = ahead.look_ahead = 3;
    return std::vector<Job>{
        {Layout{2, 2}, {}, spec},         {Layout{3, 2, Placement::colocated}, ahead, shaded},
        {mesh_layout(2, 2, 3), {}, spec}, {mesh_layout(2, 2, 2, Routing::direct), {}, spec},
        {Layout{2, 2}, {}, spec, true},   {Layout{.gps = 2, .renderers = 2, .bundle = 4}, ahead, shaded}};
  }();
  return all;
}

Scene load(const Job& job) {
  SoloCollectives solo;
  const Grid grid = test::make_grid({12, 10, 9});
  OpenedVolume volume{grid, true, synth_source("ball", grid)};
  return load_scene(volume, needed_to_render(job.spec, grid), job.layout, {solo});
}

/// Each job's scene, loaded once.
const Scene& scene_of(std::size_t job) {
  static const std::vector<Scene> all = [] {
    std::vector<Scene> scenes;
    for (const Job& one : jobs()) scenes.push_back(load(one));
    return scenes;
  }();
  return all[job];
}

/// One rank of a job's frame.
class Rank {
 public:
  Rank(std::size_t job, int rank, Transport& transport)
      : frames_(rank == 0 ? director_of({jobs()[job].spec}, [](FrameResult&&) {}) : Director{},
                scene_of(job).grid, jobs()[job].layout),
        engine_(engine_of(job, rank)),
        host_(jobs()[job].layout, jobs()[job].protocol, transport, *engine_, &frames_) {}
  Host& host() { return host_; }

 private:
  std::unique_ptr<Engine> engine_of(std::size_t job, int rank) {
    const Layout& layout = jobs()[job].layout;
    const EngineSetup setup{
        .grid = scene_of(job).grid,
        .gps = layout.gps,
        .renderers = layout.renderers,
        .bundle = layout.bundle,
        .slices = std::make_shared<const SliceStore>(rank < layout.gps ? scene_of(job).stores.at(rank)
                                                                       : SliceStore()),
        .take = [this](std::int64_t frame, Image&& p) { frames_.take_picture(frame, std::move(p)); }};
    return jobs()[job].count_only ? make_counting_engine(setup, 1) : make_rank_engine(setup);
  }
  DirectedFrames frames_;
  std::unique_ptr<Engine> engine_;
  Host host_;
};

/// Delivers an input's parts, one whenever the rank has nothing left to do, so that no answer comes before
/// its question. Discards what the rank sends.
class SentByOthers final : public Transport {
 public:
  SentByOthers(int rank, int ranks, std::span<const std::byte> parts)
      : rank_(rank), ranks_(ranks), parts_(parts) {}
  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  void send(int destination, Message message) override {
    if (destination < 0 || destination >= ranks_ || destination == rank_)
      throw std::logic_error("a message is sent to a rank that does not exist or to itself");
    static_cast<void>(message.seal());
  }
  std::optional<Message> receive() override { return std::exchange(here_, std::nullopt); }
  bool sends_done() override { return true; }
  void wait_next() override {}

  /// Makes the next message available; false when there are no more.
  bool deliver() {
    std::span<const std::byte> part;
    if (!take_part(parts_, part)) return false;
    Message message = Message::from_wire(copy_of(part), (rank_ + 1) % ranks_);
    // Left out: a stall message makes the rank log a line and wait half a second.
    if (message.header.kind != Kind::stall) here_ = std::move(message);
    return true;
  }

 private:
  int rank_, ranks_;
  std::span<const std::byte> parts_;
  std::optional<Message> here_;
};

/// Input: a choice of job and rank, then messages.
void run_rank(std::span<const std::byte> input) {
  const std::size_t k = take_choice(input) % jobs().size();
  const Job& job = jobs()[k];
  const int rank = int(take_choice(input)) % job.layout.ranks();
  SentByOthers transport(rank, job.layout.ranks(), input);
  Rank tested(k, rank, transport);
  do {
    while (tested.host().step()) {
    }
    static_cast<void>(tested.host().waiting_for());
  } while (!tested.host().finished() && transport.deliver());
}

/// Records the messages that arrive.
class Recorder final : public Transport {
 public:
  Recorder(Transport& transport, Input& record) : transport_(transport), record_(record) {}
  int rank() const override { return transport_.rank(); }
  int ranks() const override { return transport_.ranks(); }
  void send(int destination, Message message) override { transport_.send(destination, std::move(message)); }
  std::optional<Message> receive() override {
    auto message = transport_.receive();
    if (message) append_part(record_, message->seal());
    return message;
  }
  bool sends_done() override { return transport_.sends_done(); }
  void wait_next() override { transport_.wait_next(); }

 private:
  Transport& transport_;
  Input& record_;
};

std::vector<Input> record_frame(std::size_t k) {
  const Job& job = jobs()[k];
  const auto ranks = std::size_t(job.layout.ranks());
  std::vector<Input> records;
  for (std::size_t rank = 0; rank < ranks; ++rank) records.push_back({char(k), char(rank)});
  LoopbackNetwork network(int(ranks), {});
  std::vector<std::unique_ptr<Recorder>> transports;
  std::vector<std::unique_ptr<Rank>> all;
  for (int rank = 0; rank < int(ranks); ++rank) {
    transports.push_back(std::make_unique<Recorder>(network.transport(rank), records[std::size_t(rank)]));
    all.push_back(std::make_unique<Rank>(k, rank, *transports.back()));
  }
  const auto finished = [](const std::unique_ptr<Rank>& one) { return one->host().finished(); };
  while (!std::all_of(all.begin(), all.end(), finished)) {
    for (const auto& one : all) one->host().step();
    network.turn();
  }
  return records;
}

std::vector<Input> rank_seeds() {
  std::vector<Input> seeds;
  for (std::size_t k = 0; k < jobs().size(); ++k)
    for (Input& record : record_frame(k)) seeds.push_back(std::move(record));
  return seeds;
}

}  // namespace

std::vector<Driver> rank_drivers() { return {{"rank", run_rank, rank_seeds, {"RSP1"}, 3000}}; }

}  // namespace ringsplat::fuzz
