#pragma once
#include <algorithm>
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "ringsplat/base/axis.hpp"

namespace ringsplat {

/// The volume's lattice in the world, all that the camera needs of it (conventions: volume/grid.hpp).
struct LatticeFrame {
  glm::ivec3 dims{1};
  glm::dvec3 spacing{1.0}, origin{0.0};
  glm::dmat3 direction{1.0};
};

/// What fits the picture at zoom 1. The volume's box ends half a voxel beyond the outer voxel centres.
enum class Fit {
  /// The box's bounding sphere fits the picture's shorter side: turning changes no sizes.
  sphere,
  /// The box as this camera sees it fills `box_fill` of the picture's width or height.
  box
};
inline constexpr double box_fill = 0.95;

/// Orthographic camera, or with a `fov` a perspective one. Angles in degrees. At azimuth = elevation = roll =
/// 0 the viewer looks along world +y, world x to the right and world z up: in patient coordinates (LPS) at
/// the face, with the patient's left at the right of the picture. Azimuth turns the viewer about world z (at
/// 90 it stands at +x and looks along -x, world y to the right), elevation lifts it (at 90 it looks straight
/// down, world y up in the picture), roll turns the picture clockwise. Multiples of 90 degrees are exact.
/// Zoom 1 fits the volume to the image (Fit); the box's centre is at the image's centre, unless it is panned,
/// at depth 0.
///
/// A perspective camera's eye lies before the box's centre, towards the viewer, at `distance`. The plane
/// through that centre parallel to the picture, at depth 0, then fills `fov` degrees of the shorter side at
/// zoom 1. Zoom enlarges the picture and leaves the eye where it is.
struct Camera {
  double azimuth = 0, elevation = 0, roll = 0, zoom = 1;
  /// World to screen, instead of angles and zoom. Its rows give pixels right, pixels down, and pixels of
  /// depth away from the viewer. It may mirror.
  std::optional<std::array<double, 12>> matrix = std::nullopt;
  /// Degrees of the picture's shorter side, 0.01 to 179; 0: orthographic. Not with a matrix.
  double fov = 0;
  /// From the eye to the box's centre in radii of the bounding sphere, up to 1e5. 0: fitted, for the sphere
  /// 1 / tan(fov / 2), so that the plane through the centre is shown as by the orthographic camera; for the
  /// box so that all of its corners, near ones, too, are in the picture.
  double distance = 0;
  /// Where the box's centre lies in the picture: right and down of its middle, in lengths of the shorter
  /// side. A perspective picture is shifted as a whole, as by a shift lens. Not with a matrix.
  std::array<double, 2> pan{0, 0};
  /// World positions. The target takes the place of the box's centre. An eye that is given looks at it,
  /// instead of the angles and the distance, and `up` points up in the picture as far as it can. Not with a
  /// matrix.
  std::optional<glm::dvec3> eye = std::nullopt, target = std::nullopt;
  glm::dvec3 up{0, 0, 1};
  /// Without effect where the size follows from elsewhere: with a matrix, or in perspective with a distance
  /// or an eye. The box fits as it would in the middle, wherever pan and target move it.
  Fit fit = Fit::sphere;
  bool operator==(const Camera&) const = default;
};

/// The world's axis that a direction is nearest to.
int nearest_axis(const glm::dvec3& direction);

/// Stands straight before an axis' slices. Of a patient's the viewer sees axial ones from the feet and
/// sagittal ones from the left, as radiologists do; of others the world's axes point to the right and up.
/// They fill the picture, so that one of a slice's size has a pixel a voxel.
Camera facing_slices(const LatticeFrame& lattice, Axis axis, bool patient);

/// Stands straight before a plane, as far along a world direction from the volume's middle as `distance`
/// says; world z points up, or y where the viewer looks along z.
Camera facing_plane(const LatticeFrame& lattice, const glm::dvec3& normal, double distance);

/// Lattice to screen: (pixel x right, pixel y down, depth away from the viewer in pixels); pixel
/// centres lie at integers + ½.
struct ViewTransform {
  glm::dmat3 linear{1.0};
  glm::dvec3 offset{0.0};
  double pixels_per_unit = 1;              ///< pixels a world unit (of a matrix: the cube root of |det|)
  glm::dvec3 to_viewer{0, 0, 1};           ///< world direction, unit length
  glm::dvec3 right{1, 0, 0}, up{0, 0, 1};  ///< world directions of the picture's axes, unit length
  /// Of a perspective view, in lattice coordinates. All else describes the orthographic view with which it
  /// agrees at depth 0: a pixel's ray goes from the eye to the point there that the pixel's centre shows.
  std::optional<glm::dvec3> eye = std::nullopt;
  /// As the orthographic view shows it.
  glm::dvec3 project(const glm::dvec3& lattice) const { return linear * lattice + offset; }
  /// How much larger than at depth 0 things are shown at a lattice point: infinitely beside or behind the
  /// eye, 1 in an orthographic view.
  double magnification(const glm::dvec3& lattice) const;
  /// The point's place in the picture, in pixels. Its magnification must be finite.
  glm::dvec2 seen_at(const glm::dvec3& lattice) const;
};

/// Image of width × height pixels of a checked lattice. Throws InputError: zoom not positive and finite, an
/// angle not finite, a singular matrix, no pixels, a field of view or a distance out of range.
ViewTransform make_view(const Camera& camera, const LatticeFrame& lattice, int width, int height);

/// Which slice set a view traverses. Where spacings are nearly equal both rules mean the same one.
enum class SliceRule {
  most_parallel,  ///< to the view plane: footprints are least foreshortened
  /// Of the sets that a ray crosses most, so that it crosses few cells between two slices, the most parallel.
  most_crossed
};

/// The slice set that a view traverses, and the order of its slices, front to back.
struct Traversal {
  Axis axis = Axis::z;
  bool ascending = true;
  double cos_angle = 1;       ///< |cos| of the angle between the view direction and the slices' normal
  double slice_distance = 1;  ///< along the ray from slice to slice, in unit lengths (the smallest spacing)
  /// How many times as many slabs a ray's way from slice to slice needs as where spacings are equal. It goes
  /// by its length and, as the field bends there, by the cells it crosses along the slices.
  double between = 1;
  static constexpr int most_slabs = 8;
  int slabs_for(int slabs) const { return std::min(most_slabs, int(slabs * between + 0.75)); }
  /// Of so many slabs a slice, beyond the first and the last slice's centre.
  static int slabs_in_half(int slabs) { return slabs > 4 ? slabs / 2 : 1; }
  int slice_at(int step, int slices) const { return ascending ? step : slices - 1 - step; }
};

/// A pure function of the view. Ties (equal to 1e-9, relative) go to z before y before x. The view is never
/// parallel to the chosen slices: of the most parallel ones |cos| is at least 1/√3 when the lattice's axes
/// are orthogonal, and above zero when they are oblique.
///
/// In a perspective view angle and distance are the central ray's. All rays must meet the slices in one
/// order, so only axes count along which the eye lies outside of the box [−½, n − ½]. Throws InputError when
/// the eye is inside the box.
Traversal choose_traversal(const ViewTransform& view, const LatticeFrame& lattice,
                           SliceRule rule = SliceRule::most_parallel);

}  // namespace ringsplat
