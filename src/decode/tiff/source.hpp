#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "formats/channels.hpp"
#include "images/image_file.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// Where a slice's pixels are: a page that the library reads, or uncompressed bytes of the file.
struct TiffSlice {
  std::filesystem::path file;
  int page = 0;  ///< in the file's chain, from 0
  std::optional<std::uint64_t> raw_begin = std::nullopt;
  bool big_endian = false;  ///< of raw bytes
};

/// What a pixel's numbers are and which is taken.
struct TiffSamples {
  int count = 1;
  ChannelChoice taken{0};
};

/// Opens an image by its library. Throws InputError when it is none.
std::unique_ptr<ImageFile> open_tiff_image(const std::filesystem::path& path);

/// Which scalar a type of samples becomes; nothing for one that cannot be rendered.
std::optional<ScalarType> scalar_type_of(SampleType type);

/// Reads slices by number, so every process reads its own. All have the grid's width, height and type.
std::unique_ptr<VolumeSource> tiff_source(const Grid& grid, std::vector<TiffSlice> slices,
                                          const TiffSamples& samples);

}  // namespace ringsplat::detail
