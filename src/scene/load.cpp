#include <fmt/format.h>

#include <optional>

#include "net/agree.hpp"
#include "net/blocks.hpp"
#include "scene/dealer.hpp"
#include "scene/scene.hpp"

namespace ringsplat {
namespace {

/// What process 0 tells the others of the volume it has opened.
struct Known {
  Grid grid;
  bool concurrent = false;
  int layer_depth = 1;
  std::optional<double> fill;  ///< what the values' statistics leave out
};

}  // namespace

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
  if (volume.source)
    block = block_of_value(Known{volume.source->grid(), volume.source->concurrent(),
                                 volume.source->layer_depth(), volume.notes.fill});
  block = collectives.broadcast(std::move(block), 0);
  const auto known = value_of<Known>(block, "a volume's grid");
  volume.grid = known.grid;
  volume.concurrent = known.concurrent;
  volume.layer_depth = known.layer_depth;
  volume.notes.fill = known.fill;
  if (!volume.concurrent) return volume;
  agree(collectives, is_first ? std::string() : input_error_of(open_it));
  require_same(collectives, volume.facts, fmt::format("sees another volume at {}", name),
               "give every machine the same files, or a path that leads to one place from all of them");
  return volume;
}

std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options,
                                      const Sharing& sharing) {
  const bool alone = volume.concurrent && volume.layer_depth == 1;
  const int readers = volume.concurrent ? sharing.collectives.processes() : 1;
  // Slices are read and dealt in turns.
  double read = 0, dealt = 0;
  const auto note = [&](double& slices, double end) {
    slices = end;
    if (options.told) options.told((alone ? dealt : 0.5 * (read + dealt)) / volume.grid.dims.z);
  };
  const auto supply = alone ? reading_supply(*volume.source)
                            : decoding_supply(
                                  volume.source.get(), volume.grid, volume.layer_depth, readers,
                                  [&](double z) { note(read, z); }, sharing.collectives);
  note(read, 0);
  return deal_slices(volume.grid, *supply, {options, sharing, nullptr, [&](int end) { note(dealt, end); }});
}

}  // namespace ringsplat
