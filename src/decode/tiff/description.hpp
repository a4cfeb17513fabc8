#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// What a microscope's program says in the ImageDescription of a file's planes: images of one slice in one
/// channel at one time, a page each or, in ImageJ's large files, behind the only page.
struct Microscopy {
  std::string by;       ///< "ImageJ" or "OME-XML"
  std::string problem;  ///< why its planes are no single image of this file; empty when they are
  std::int64_t channels = 1, frames = 1;
  std::optional<std::int64_t> slices;  ///< where it says how many
  std::vector<ChannelNotes> of_channels;
  glm::dvec3 spacing{1};
  bool sized = false;  ///< it gives the pixels' size
  std::string unit;    ///< of the spacing, in ASCII: "um" for every length known; empty: unknown
  bool depth = false;  ///< it gives the distance of slices
  /// The planes' order, the fastest first: of 'C', 'Z' and 'T'.
  std::string order = "CZT";
  /// By the place in that order at which a run of planes begins: the run's first plane in the file and how
  /// many there are. Empty: all planes in that order from 0.
  struct Run {
    std::uint64_t plane, count;
  };
  std::map<std::uint64_t, Run> runs;

  /// The number of planes; nothing when they are more than any file holds.
  std::optional<std::uint64_t> planes(std::int64_t slice_count) const;
  /// The plane of a slice in the file; nothing when it is not there. All three from 0 and below their counts.
  std::optional<std::uint64_t> plane(std::int64_t channel, std::int64_t slice, std::int64_t frame,
                                     std::int64_t slice_count) const;
};

/// Reads ImageJ's description ("ImageJ=1.53...") or OME-XML (the OME data model of 2016-06 and before);
/// nothing for other texts. `resolution`: the tags', pixels for a unit, 0 when missing.
std::optional<Microscopy> read_microscopy(const std::string& description,
                                          const std::array<double, 2>& resolution);

}  // namespace ringsplat::detail
