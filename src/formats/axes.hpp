#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/channels.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/volume/source.hpp"

/// What the axes of an array of any number of dimensions mean.
namespace ringsplat::detail {

/// One axis of a dataset, in the order of its dimensions: the last is the fastest in memory.
struct DatasetAxis {
  enum class Role { space, frame, channel, single };
  int size = 1;
  Role role = Role::space;
  bool known = false;                       ///< a convention told the role
  std::string name = {};                    ///< in small letters; empty: unknown
  std::optional<int> world = std::nullopt;  ///< along x, y or z of the world
  double sign = 1;                          ///< -1: indices grow against the world's axis
  double spacing = 1, first = 0;            ///< of neighbours; world coordinate of index 0
  std::string unit = {};
};

/// A dataset as its conventions describe it.
struct DatasetMeaning {
  std::vector<DatasetAxis> axes;
  VolumeNotes notes;
  std::vector<Rescale> rescale = {};  ///< none, one for all, or one a slice, frame after frame
  /// Where a convention gives it instead of the axes' own positions.
  std::optional<glm::dvec3> origin = std::nullopt;
  std::optional<glm::dmat3> direction = std::nullopt;
};

/// Where columns, rows and slices lead as Fiji and napari show a stack: the default camera looks along +y, z
/// is up. So columns run to the right, rows downwards, and slices away from the viewer.
inline const glm::dmat3 microscope_axes(glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0));

/// A unit of length in micrometres; nothing for other units and texts.
std::optional<double> micrometres_in(const std::string& unit);

/// What an axis's name says of its role and direction.
void describe_by_name(DatasetAxis& axis);

/// Settles what no convention told: the last three dimensions are z, y, x, and what is left over frames or
/// components. Counts frames and channels. Throws InputError, with `hint`, for dimensions that cannot be told
/// apart.
void settle_roles(DatasetMeaning& meaning, const std::string& where, const char* hint);

/// Numbers of the dimensions along x, y, z of the lattice; -1: the volume has one voxel along it.
inline std::array<int, 3> lattice_axes(const std::vector<DatasetAxis>& axes) {
  std::array<int, 3> lattice{-1, -1, -1};
  for (int axis = int(axes.size()) - 1, k = 0; axis >= 0; --axis)
    if (axes[std::size_t(axis)].role == DatasetAxis::Role::space) lattice[std::size_t(k++)] = axis;
  return lattice;
}

/// The volume's lattice; the type is left alone.
Grid lattice_of(const DatasetMeaning& meaning, const std::string& where);

/// What is read of an array: of frames and channels one, but all of colours whose luminance is made. In the
/// order of its dimensions.
struct ArrayPart {
  std::vector<std::int64_t> first, end;
  int frame = 0;
  std::array<int, 3> lattice{};  ///< lattice_axes()
  int components = 1;            ///< numbers that are read of a voxel, of which `channel` makes one
  ChannelChoice channel = {0};
};

/// Of channels that do not lie beside each other the first, or one by its number or name. `type`: of voxels.
/// Throws InputError for no such frame or channel.
ArrayPart choose_part(const DatasetMeaning& meaning, ScalarType type, const VolumeChoice& choice,
                      const std::string& where);

}  // namespace ringsplat::detail
