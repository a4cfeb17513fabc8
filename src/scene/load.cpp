#include <fmt/format.h>

#include <algorithm>

#include "base/byte_stream.hpp"
#include "base/clock.hpp"
#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/dealer.hpp"
#include "scene/scene.hpp"

namespace ringsplat {
namespace {

/// What process 0 tells the others of the volume it has opened.
struct Known {
  Grid grid;
  std::uint8_t concurrent = 0;
  std::int32_t layer_depth = 1;
  std::uint8_t has_fill = 0;
  double fill = 0;  ///< what the values' statistics leave out
};

/// Copies `known` into `volume`; throws RunError when such a volume cannot exist.
void take_known(const Known& known, OpenedVolume& volume) {
  const auto type = int(known.grid.type), last = int(ScalarType::float64);
  try {
    if (type < 0 || type > last || known.concurrent > 1 || known.has_fill > 1)
      throw InputError("its type is none");
    check(known.grid, "its grid");
    if (known.layer_depth < 1) throw InputError("its layers have no slices");
  } catch (const InputError& e) {
    throw RunError(fmt::format("rank 0 announced a volume that cannot be: {}", e.what()));
  }
  volume.grid = known.grid;
  volume.concurrent = known.concurrent == 1;
  volume.layer_depth = known.layer_depth;
  if (known.has_fill == 1) volume.notes.fill = known.fill;
}

/// Which part of a deal's time has passed. Slices are read and dealt in turns, each at a pace of its own, so
/// neither count alone would tell how long the rest takes. Until the first slice is dealt, dealing is taken
/// to be as fast as reading.
class LoadPace {
 public:
  LoadPace(int slices, const std::function<void(double part)>& told) : slices_(slices), told_(told) {}

  /// Starts the clock: slices begin to be read.
  void begin() {
    last_ = now_seconds();
    if (told_) told_(0);
  }
  /// So many slices have been read; the time since the last call went into it.
  void read(double slices) { note(read_, slices); }
  void dealt(double slices) { note(dealt_, slices); }

 private:
  struct Work {
    double slices = 0, seconds = 0;
    double each() const { return slices > 0 ? seconds / slices : 0; }
  };
  void note(Work& work, double slices) {
    const double now = now_seconds();
    work.seconds += now - last_;
    work.slices = slices;
    last_ = now;
    if (!told_) return;
    const double whole = slices_ * (read_.each() + (dealt_.slices > 0 ? dealt_.each() : read_.each()));
    if (whole <= 0) return;
    part_ = std::max(part_, std::min(1.0, (read_.seconds + dealt_.seconds) / whole));
    told_(part_);
  }

  int slices_;
  const std::function<void(double)>& told_;
  Work read_, dealt_;
  double last_ = now_seconds(), part_ = 0;
};

}  // namespace

std::vector<int> processes_of_gps(SliceDealing dealing, const std::vector<std::vector<int>>& gps_of_process) {
  std::vector<int> processes(std::size_t(dealing.gps), 0);
  for (std::size_t p = 0; p < gps_of_process.size(); ++p)
    for (const int gp : gps_of_process[p]) processes[std::size_t(gp)] = int(p);
  return processes;
}

OpenedVolume open_everywhere(Collectives& collectives,
                             const std::function<std::unique_ptr<VolumeSource>()>& open,
                             const std::string& name) {
  OpenedVolume volume;
  volume.name = name;
  const auto open_it = [&] {
    volume.source = open();
    check(volume.source->grid(), "the volume");
    volume.notes = volume.source->notes();
    volume.facts = facts_of(volume.source->grid());
    const Facts more = volume.source->facts();
    volume.facts.insert(volume.facts.end(), more.begin(), more.end());
  };
  const bool is_first = collectives.process() == 0;
  agree(collectives, is_first ? input_error_of(open_it) : std::string());

  Block block;
  if (volume.source) {
    const auto& fill = volume.notes.fill;
    block = block_of_value(Known{volume.source->grid(), volume.source->concurrent(),
                                 volume.source->layer_depth(), fill.has_value(), fill.value_or(0)});
  }
  block = collectives.broadcast(std::move(block), 0);
  take_known(value_of<Known>(block, "a volume's grid"), volume);
  if (!volume.concurrent) return volume;
  agree(collectives, is_first ? std::string() : input_error_of(open_it));
  require_same(collectives, volume.facts, fmt::format("sees another volume at {}", name),
               "give every machine the same files, or a path that leads to one place from all of them");
  // Voxels are read into memory for the grid that was broadcast.
  if (facts_of(volume.source->grid()) != facts_of(volume.grid))
    throw RunError("rank 0 told of another grid than it compared", "all ranks must run the same build");
  return volume;
}

std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options, SliceDealing dealing,
                                      const std::vector<std::vector<int>>& gps_of_process,
                                      Collectives& collectives) {
  LoadPace pace(volume.grid.dims.z, options.told);
  const bool alone = volume.concurrent && volume.layer_depth == 1;
  const int readers = volume.concurrent ? collectives.processes() : 1;
  const auto supply = alone ? reading_supply(*volume.source)
                            : decoding_supply(
                                  volume.source.get(), volume.grid, volume.layer_depth, readers,
                                  [&pace](double read) { pace.read(read); }, collectives);
  pace.begin();
  return deal_slices(volume.grid, *supply,
                     {options, dealing, gps_of_process, nullptr, [&pace](int end) { pace.dealt(end); }},
                     collectives);
}

}  // namespace ringsplat
