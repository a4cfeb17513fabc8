#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.hpp"
#include "classify/auto_preset.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/voxel_box.hpp"
#include "volume/segmented.hpp"

/// Turns what people type for an option into values. Every function throws InputError that names the option
/// (`option`, such as "--size") and shows a value that works.
namespace ringsplat::app {

/// "640x480", or "512" for a square.
glm::ivec2 parse_size(const std::string& text, const std::string& option);

/// Columns and rows of a mesh: "4x3", or "4" for 4x4.
glm::ivec2 parse_mesh(const std::string& text, const std::string& option);

/// Bytes: "8G", "500M", with powers of 1024; positive.
double parse_memory(const std::string& text, const std::string& option);

/// "256x256x128", or "64" for a cube; all at least 1.
glm::ivec3 parse_dims(const std::string& text, const std::string& option);

/// "0.5x0.5x1.2" (or with commas), or "0.7" for all three; positive and finite.
glm::dvec3 parse_spacing(const std::string& text, const std::string& option);

/// Linear light of a display (sRGB) colour: a name, "#rrggbb" or "r,g,b" with numbers from 0 to 1;
/// nothing for "none" (transparent).
std::optional<glm::dvec3> parse_colour(const std::string& text, const std::string& option);

/// The names that parse_colour() knows, beside "none".
std::vector<std::string> colour_names();

/// The numbers of a list separated by blanks, commas, semicolons or tabs; nothing when a part is no number.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

using detail::joined;
using detail::split;

/// The entry of `known` closest to `word`, or an empty string when none is close (Levenshtein 1966; at most a
/// third of the letters wrong).
std::string closest(const std::string& word, const std::vector<std::string>& known);

/// "LO:HI", both finite and LO below HI.
DataRange parse_window(const std::string& text, const std::string& option);
/// A finite number above 0; `hint` shows one.
double parse_positive(const std::string& text, const std::string& option, const std::string& hint);

/// The labels of a segmentation that are shown.
struct ShownLabels {
  std::string path;  ///< empty: everything is shown
  LabelRanges labels;
  Covered covered = Covered::alone;
};
/// "FILE", or "FILE=1,3-5" with labels.
ShownLabels parse_mask(const std::string& text, const std::string& option);

/// What --frames says: from `first` to before `end`, every `step`-th.
struct FrameRange {
  std::optional<int> first, end;  ///< from 0; missing: the first there is, and to the last
  int step = 1;                   ///< at least 1
  std::string text;               ///< as it was given
};

/// "all", "A:B", "A:B:STEP"; each of A, B and STEP may be missing.
FrameRange parse_frames(const std::string& text, const std::string& option);

/// "did you mean --colours?" for an option that is not among the `known` ones: what other programs' word for
/// it is called here, or else the most similar one. Empty when nothing is like it. Dashes and underscores are
/// alike.
std::string likely_option(const std::string& unknown, const std::vector<std::string>& known);

/// What is meant of a volume. Throws InputError that names the part that has no voxel or leaves the volume.
using BoxOf = std::function<VoxelBox(const Grid&)>;

/// A clip box as people type it, "x0:x1,y0:y1,z0:z1": a part that is empty or has an open end reaches to the
/// volume's face. Numbers are voxels, of a pyramid the finest level's, x0 the first and x1 the first behind;
/// in a part that ends in "mm", and in all parts when the last one does, they are distances from the volume's
/// first face along the lattice's axis, in the file's world units, and voxels count whose centres lie
/// between. Throws InputError that names the part that is no range.
BoxOf parse_clip(const std::string& text, const std::string& option);

/// One slice, "x=40" or "z=12.5mm", and the axis that it lies across. Throws InputError.
std::pair<BoxOf, Axis> parse_slice(const std::string& text, const std::string& option);

/// A clip plane, "nx,ny,nz,d"; or several with colons between. Throws InputError.
ClipPlane parse_clip_plane(std::string_view text, const std::string& option);
inline std::vector<ClipPlane> parse_clip_planes(const std::string& text, const std::string& option) {
  return detail::mapped(split(text, ":"), [&](auto part) { return parse_clip_plane(part, option); });
}

/// The box that was typed, if any, in the grid's voxels.
std::optional<VoxelBox> clip_box(const BoxOf& clip, const Grid& grid, const VolumeNotes& notes = {});

}  // namespace ringsplat::app
