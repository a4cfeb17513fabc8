#include "simulate/simulated_engines.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "protocol/engine_decorator.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "simulate/charge.hpp"

namespace ringsplat {
namespace {

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
    for (const EncodedPart& part : step.parts) sent += double(part.items);
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
  ChargedPainter(Painter& inner, const Machine& machine, const SlicesOf& slices_of, bool sheets)
      : PainterDecorator(inner), machine_(machine), slices_of_(slices_of), sheets_(sheets) {
    debt_.owe(machine.renderer.frame);
  }

  bool prepare() override { return debt_.pay() || inner_.prepare() || pay_for_samples(); }
  void begin(const PayloadToDraw& payload) override {
    before_ = inner_.counts();
    inner_.begin(payload);
    passes_ = payload.passes;
    slices_ = slices_of_(payload.body);
    painted_ = false;
  }
  bool work() override {
    if (!painted_) {
      if (debt_.pay() || !inner_.work()) return false;
      painted_ = true;
      owe_for_payload(inner_.counts());
    }
    return !debt_.pay() && !(slices_kept_ > most_slices_kept && pay_for_samples());
  }
  bool conclude() override { return inner_.conclude() || pay_for_samples(); }
  void finish(const std::function<void(int, Bytes)>& deliver) override {
    inner_.finish([&](int tile, Bytes bytes) {
      constexpr double bytes_of_pixel = 4 * sizeof(float);
      charge(machine_.renderer.pixel * double(Message::body_size(bytes)) / bytes_of_pixel);
      deliver(tile, std::move(bytes));
    });
  }

 private:
  void owe_for_payload(const ItemCounts& now) {
    const double items = double(now.drawn + now.clipped - before_.drawn - before_.clipped),
                 blocks = double(now.blocks - before_.blocks),
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

class ChargedEngine final : public EngineDecorator {
 public:
  ChargedEngine(std::unique_ptr<Engine> inner, const Machine& machine, SlicesOf slices_of)
      : EngineDecorator(std::move(inner)), machine_(machine), slices_of_(std::move(slices_of)) {}

  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    Debt& debt = debts_.try_emplace(gp, machine_.poll_interval).first->second;
    return std::make_unique<ChargedEncoder>(inner_->encoder(gp, a), machine_, debt, of_sheets(a),
                                            has_work(gp, plan(a)));
  }

 private:
  std::unique_ptr<Painter> make_painter(int renderer, const Announcement& a) override {
    return std::make_unique<ChargedPainter>(inner_->painter(renderer, a), machine_, slices_of_, of_sheets(a));
  }
  static bool of_sheets(const Announcement& a) { return method_of(a.body) == Sheets::name; }
  static bool has_work(int gp, const FramePlan& plan) {
    for (const FramePlan::Tile& tile : plan.tiles)
      if (tile.renderer != FramePlan::nobody)
        return std::find(plan.owners.begin(), plan.owners.end(), gp) != plan.owners.end();
    return false;
  }

  Machine machine_;
  SlicesOf slices_of_;
  std::map<int, Debt> debts_;  ///< by GP
};

}  // namespace

std::unique_ptr<Engine> make_charged_engine(std::unique_ptr<Engine> inner, const Machine& machine,
                                            SlicesOf slices_of) {
  return std::make_unique<ChargedEngine>(std::move(inner), machine, std::move(slices_of));
}

}  // namespace ringsplat
