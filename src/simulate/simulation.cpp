#include "simulate/simulation.hpp"

#include <map>

#include "base/clock.hpp"
#include "frame/engine_setup.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "protocol/engine_decorator.hpp"
#include "protocol/joined_step.hpp"
#include "session/render_frames.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "simulate/charge.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/meter.hpp"

namespace ringsplat {
namespace {

/// Charges the software costs of messages between ranks. The simulator adds the network's time itself.
class ChargedTransport final : public TransportDecorator {
 public:
  /// `transport` must outlive it. `count_only`: payloads only count.
  ChargedTransport(Transport& transport, const Machine& machine, bool count_only)
      : TransportDecorator(transport),
        machine_(machine),
        count_only_(count_only),
        shared_(shares_cores(machine, transport.ranks())) {
    slow_rank = machine.slow.rank;
    slowness = machine.slow.factor;
  }

  void send(int destination, Message message) override {
    Header& h = message.header;
    charge(sending_seconds(machine_, static_cast<double>(sizeof(Header) + h.bytes)));
    if (h.kind == Kind::token) charge(machine_.gp.token);
    if (h.kind == Kind::payload && count_only_) h.magic = counted_magic;
    inner_.send(destination, std::move(message));
  }
  std::optional<Message> receive() override {
    auto message = inner_.receive();
    if (message) charge(machine_.message.receive);
    return message;
  }
  /// A rank that waits has yielded its core, where others may compute.
  void wait_next() override {
    const double since = now_seconds();
    inner_.wait_next();
    if (shared_ && now_seconds() > since) sleep_simulated(machine_.message.wake);
  }
  void only_first_work(int ranks) override {
    shared_ = shares_cores(machine_, ranks);
    inner_.only_first_work(ranks);
  }

 private:
  Machine machine_;
  bool count_only_;
  bool shared_;  ///< more ranks work than there are cores
};

/// How many slices a payload is of.
using SlicesOf = std::function<int(std::span<const std::byte> payload)>;

class ChargedEncoder final : public EncoderDecorator {
 public:
  /// `debt` is the GP's. A frame's setup is paid before its first slice, even while an earlier frame is being
  /// encoded.
  ChargedEncoder(std::unique_ptr<Encoder> inner, const Machine& machine, Debt& debt, bool sheets,
                 bool has_work)
      : EncoderDecorator(std::move(inner)), machine_(machine), debt_(debt), sheets_(sheets) {
    if (has_work) debt_.owe(machine.gp.frame);
  }

  bool prepare() override { return !encoded_ && debt_.pay(); }
  bool work() override {
    if (!encoded_) {
      if (!inner_->work()) return false;
      encoded_ = inner_->finish();
      debt_.owe(seconds_of(*encoded_));
    }
    return !debt_.pay();
  }
  EncodedStep finish() override {
    EncodedStep step = std::move(*encoded_);
    encoded_.reset();
    return step;
  }

 private:
  double seconds_of(const EncodedStep& step) const {
    if (!sheets_)
      return encoding_seconds(machine_, double(step.counts.voxels), double(step.counts.visible), step.slices);
    double sent = 0;
    for (const EncodedPart& part : step.parts) sent += double(part.items - part.kept);
    return selecting_seconds(machine_, double(step.counts.blocks), sent, step.slices);
  }

  const Machine& machine_;
  Debt& debt_;
  bool sheets_;
  std::optional<EncodedStep> encoded_;  ///< encoded, but its simulated time is still passing
};

/// Pays for a payload of splats before the next one is begun. Sheets are painted while no payload is there,
/// as long as the Renderer can keep more slices, and at the end.
class ChargedPainter final : public PainterDecorator {
 public:
  ChargedPainter(std::shared_ptr<Painter> inner, const Machine& machine, const SlicesOf& slices_of,
                 bool sheets)
      : PainterDecorator(std::move(inner)), machine_(machine), slices_of_(slices_of), sheets_(sheets) {
    debt_.owe(machine.renderer.frame);
  }

  bool prepare() override { return debt_.pay() || inner_->prepare() || pay_for_samples(); }
  void begin(const PayloadToDraw& payload) override {
    before_ = inner_->counts();
    inner_->begin(payload);
    passes_ = payload.passes;
    slices_ = slices_of_(payload.body);
    painted_ = false;
  }
  bool work() override {
    if (!painted_) {
      if (debt_.pay() || !inner_->work()) return false;
      painted_ = true;
      owe_for_payload(inner_->counts());
    }
    return !debt_.pay() && !(slices_kept_ > most_slices_kept && pay_for_samples());
  }
  bool conclude() override { return inner_->conclude() || pay_for_samples(); }
  Bytes hand_over(int to) override {
    Bytes bytes = inner_->hand_over(to);
    charge_pixels(Message::body_size(bytes), half_pixel);
    return bytes;
  }
  void gather(int from, std::span<const std::byte> bytes) override {
    charge_pixels(bytes.size(), half_pixel);
    inner_->gather(from, bytes);
  }
  void finish(const std::function<void(int, Bytes)>& deliver) override {
    inner_->finish([&](int tile, Bytes bytes) {
      charge_pixels(Message::body_size(bytes), float_pixel);
      deliver(tile, std::move(bytes));
    });
  }

 private:
  static constexpr double half_pixel = 8, float_pixel = 16;  ///< bytes
  void charge_pixels(std::size_t bytes, double bytes_of_pixel) const {
    charge(machine_.renderer.pixel * double(bytes) / bytes_of_pixel);
  }

  void owe_for_payload(const ItemCounts& now) {
    // What is kept is looked at only.
    const auto placed = [](const ItemCounts& counts) { return counts.drawn + counts.clipped - counts.kept; };
    const double items = double(placed(now) - placed(before_)), blocks = double(now.blocks - before_.blocks),
                 samples = double(now.samples - before_.samples);
    if (!sheets_) {
      debt_.owe(drawing_seconds(machine_, items, double(passes_), samples, slices_));
      return;
    }
    // The frame's first payload says what the tables are made for.
    if (before_.blocks == 0) debt_.owe(machine_.sheets.table);
    debt_.owe(placing_seconds(machine_, blocks, items, slices_));
    samples_debt_.owe(painting_seconds(machine_, samples));
    slices_kept_ += slices_;
  }

  /// Once all is painted that could be, the slices are no longer needed.
  bool pay_for_samples() {
    if (samples_debt_.pay()) return true;
    slices_kept_ = 0;
    return false;
  }

  const Machine& machine_;
  const SlicesOf& slices_of_;
  bool sheets_;
  Debt debt_{machine_.poll_interval}, samples_debt_{painting_piece(machine_)};
  int slices_kept_ = 0;       ///< placed since all was painted
  std::uint32_t passes_ = 0;  ///< the payload's
  int slices_ = 0;
  ItemCounts before_;     ///< the payload
  bool painted_ = false;  ///< the payload is drawn, but its simulated time is still passing
};

/// An engine whose work takes as long on the simulated clock as `machine` says. A step is complete once its
/// time has passed. Time passes in pieces, so that the rank handles messages in between.
class ChargedEngine final : public EngineDecorator {
 public:
  ChargedEngine(std::unique_ptr<Engine> inner, const Machine& machine, SlicesOf slices_of)
      : EngineDecorator(std::move(inner)), machine_(machine), slices_of_(std::move(slices_of)) {}

  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    Debt& debt = debts_.try_emplace(gp, machine_.poll_interval).first->second;
    return std::make_unique<ChargedEncoder>(inner_->encoder(gp, a), machine_, debt, of_sheets(a),
                                            has_work(gp, plan(a)));
  }

  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    return std::make_shared<ChargedPainter>(inner_->painter(renderer, a), machine_, slices_of_, of_sheets(a));
  }

 private:
  static bool of_sheets(const Announcement& a) { return std::holds_alternative<Sheets>(method_of(a.body)); }
  static bool has_work(int gp, const FramePlan& plan) {
    for (const FramePlan::Tile& tile : plan.tiles)
      if (tile.renderer != FramePlan::nobody) return std::ranges::find(plan.owners, gp) != plan.owners.end();
    return false;
  }

  Machine machine_;
  SlicesOf slices_of_;
  std::map<int, Debt> debts_;  ///< by GP
};

int slices_of_bundle(std::span<const std::byte> payload) {
  int slices = 0;
  JoinedPart part;
  for (std::size_t at = 0; at < payload.size() && take_part(payload, at, part); at += part.bytes) ++slices;
  return slices;
}

SlicesOf slices_of(const SimulationOptions& simulation, int bundle) {
  if (simulation.count_only) return slices_counted;
  if (bundle > 1) return slices_of_bundle;
  return [](std::span<const std::byte>) { return 1; };
}

}  // namespace

void simulate(const SimulationOptions& simulation, EngineOptions& options) {
  if (simulation.machine || simulation.count_only)
    options.engine = [simulation](EngineSetup setup) -> std::unique_ptr<Engine> {
      const auto& machine = simulation.machine;
      // A described machine's costs are those of looking at every voxel.
      setup.skip_empty = false;
      if (machine) {
        setup.splat_costs = splat_costs(*machine, simulation.voxel_weight, setup.bundle);
        setup.sheet_costs = sheet_costs(*machine, simulation.voxel_weight, setup.bundle);
      }
      auto engine = simulation.count_only ? make_counting_engine(setup, simulation.voxel_weight)
                                          : make_rank_engine(setup);
      if (!machine) return engine;
      return std::make_unique<ChargedEngine>(std::move(engine), *machine,
                                             slices_of(simulation, setup.bundle));
    };
  if (simulation.machine)
    options.network = [machine = *simulation.machine, simulation](Transport& network) {
      return std::make_unique<ChargedTransport>(network, machine, simulation.count_only);
    };
}

}  // namespace ringsplat
