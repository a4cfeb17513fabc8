#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ringsplat/net/collectives.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

struct LoadOptions {
  std::array<bool, 3> kept_axes{true, true, true};
  bool with_normals = true;
  std::vector<int> factors{1};  ///< of the levels that are kept; 1 is the volume itself
  bool prefilter = false;       ///< of the others (volume/reduced.hpp)
};

struct OpenedVolume {
  Grid grid;
  bool concurrent = false;
  std::unique_ptr<VolumeSource> source;
  Facts facts = {};  ///< on process 0: by what the volume is known again when it is opened once more
};

/// Opens the volume on process 0, and on the others too when it can be read by all at once; then all must see
/// the same one: grid, encoding, sizes and first and last bytes. Every process gets the grid; a process that
/// need not read gets no source. All throw the same InputError when one fails or sees another volume than
/// process 0; there `name` is what the volume is called.
OpenedVolume open_everywhere(Collectives& collectives,
                             const std::function<std::unique_ptr<VolumeSource>()>& open,
                             const std::string& name = "the volume");

/// Deals the volume to the GPs: GP g gets slices s ≡ g (mod G) of each kept axis, with quantised normals. No
/// process holds more of the volume than its GPs' share and a batch of slices on their way.
///
/// z slices are read whole, by their owner when the source is concurrent and by process 0 in ascending order
/// otherwise; the other two axes come by exchange. `gps_of_process[p]` lists the GPs that process p hosts.
/// Returns this process's stores by GP. All processes throw the same InputError when reading fails on one.
std::map<int, SliceStore> deal_slices(OpenedVolume& volume, const LoadOptions& options, int gps,
                                      const std::vector<std::vector<int>>& gps_of_process,
                                      Collectives& collectives);

/// Lets every store know the values' range of all slices of the axes that are kept.
void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives);

/// Value range and histogram over all GPs' slices; the same on every process.
ValueRange value_range(const std::map<int, SliceStore>& stores, Collectives& collectives);
Histogram histogram(const std::map<int, SliceStore>& stores, const ValueRange& range, int bins,
                    Collectives& collectives);

}  // namespace ringsplat
