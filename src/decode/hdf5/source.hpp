#pragma once
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "decode/hdf5/datasets.hpp"
#include "decode/hdf5/library.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail::hdf5 {

/// What is read of a dataset. Sizes and offsets are in the order of its dimensions.
struct Selection {
  std::filesystem::path file;
  std::string dataset;
  std::vector<hsize_t> first, size;  ///< the chosen frame and channel, and the whole of the others
  int slices = -1;                   ///< the dimension that z slices lie along; -1: there is one slice
  ValueType value = {};
  std::vector<Rescale> rescale = {};  ///< none, one for all, or one a slice
};

/// Throws InputError, naming the reason, for voxels that the file does not hold itself or that need a filter
/// which is missing, and for sizes that the file cannot hold.
void require_readable(hid_t dataset, const std::filesystem::path& file, const std::string& where);

/// Where the file holds the voxels of the selection, in the order in which they are read and as they are;
/// nothing where it does not. `dims`: the dataset's.
std::optional<StoredVoxels> stored_in_place(hid_t dataset, const Selection& selection,
                                            const std::vector<int>& dims);

/// The voxels of the selection. Concurrent; its layers are the chunks' layers. A layer of more than 256 MiB
/// is cut into thinner layers, which keeps memory bounded and decodes its chunks once for each of them. Reads
/// that are not whole layers keep the last one. Holds the file open; throws InputError when it changes.
std::unique_ptr<VolumeSource> dataset_source(const Grid& grid, VolumeNotes notes, Selection selection);

}  // namespace ringsplat::detail::hdf5
