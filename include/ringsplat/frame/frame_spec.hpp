#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/classify/phong.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/screen/regions.hpp"
#include "ringsplat/splat/kernel_options.hpp"
#include "ringsplat/view/slice_plane.hpp"
#include "ringsplat/view/view.hpp"
#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/reduced.hpp"

namespace ringsplat {

enum class Shading { none, phong };

/// How splats travel from GPs to Renderers: the paper's six words each, or runs of voxels whose positions
/// follow from the view.
enum class PayloadForm { words, runs };
/// Of colours and opacities in runs: 10, 8 or 4 bytes a voxel. float32 draws the same bits as words.
enum class Precision { float32, half, u8 };

/// Where Renderers' regions lie: on the screen, as in the paper; or in the plane of the traversed slices,
/// sheared along the rays, of which the frame buffer makes the picture by one warp (Lacroute and Levoy 1994).
enum class ImagePlane { screen, slices };
std::string name(ImagePlane plane);

/// Everything that decides a frame's pixels, announced by rank 0 to all ranks.
struct FrameSpec {
  std::int64_t frame = 0;
  Camera camera;
  int width = 512, height = 512;  ///< pixels
  ImagePlane image_plane = ImagePlane::screen;
  int plane_samples =
      1;  ///< in the slices' plane: pixels a voxel along either axis, where the screen has so many
  int region_size = 0;  ///< of a side, in pixels of the image plane; 0: on the screen 128, or 64 or 32 where
                        ///< the volume covers too few of those for the Renderers; strips in the slices' plane
  int dealt_to = 0;     ///< how many Renderers get regions; 0: the frame buffer puts in how many there are
  TransferFunction transfer_function;
  Shading shading = Shading::phong;
  PhongMaterial material;
  glm::dvec3 light{-0.4, 0.6, 0.7};  ///< towards the light, in the picture's axes: right, up, to the viewer
  double kernel_radius = 1.6;        ///< in lattice distances
  KernelOptions kernel;
  bool opacity_correction = true;
  double opaque_threshold =
      1.0 / 512;  ///< a pixel with less transmittance takes nothing more; 0: all are composited to the end
  Reduction reduction;  ///< of the volume; opacities are corrected for the larger voxels
  PayloadForm payload = PayloadForm::runs;
  Precision precision = Precision::float32;
  bool operator==(const FrameSpec&) const = default;
};

/// Throws InputError naming the option: sizes, radius, camera, transfer function, light of length zero, a
/// threshold outside [0, 1), words with less than float precision.
void check(const FrameSpec& spec);

/// Exact bytes and back, for ranks of one build; throws RunError when they are no FrameSpec. Whether it makes
/// sense is check()'s to say.
Bytes encode(const FrameSpec& spec);
FrameSpec decode_frame_spec(std::span<const std::byte> bytes);
/// As JSON text, for --stats and image metadata.
std::string to_json_text(const FrameSpec& spec);

/// What follows from a FrameSpec and a volume's grid; the same on every rank.
struct FrameGeometry {
  Grid grid;           ///< of the volume as it is rendered: reduced when undersampled
  ViewTransform view;  ///< of that grid's lattice to the image plane
  Traversal traversal;
  Footprint footprint;
  int width = 0, height = 0;      ///< of the image plane, in pixels
  Regions regions;                ///< of the image plane
  PixelRect reached;              ///< the block of regions that voxels can reach, in columns and rows of them
  int dealt_to = 0;               ///< how many Renderers get any of them; 0: all
  int slices = 0;                 ///< in the traversed set
  std::optional<PlaneWarp> warp;  ///< from the screen, where that is not the image plane

  /// Of the regions reached. `renderers`: how many there are.
  RegionOwners owners(int renderers) const {
    return regions.owners(reached, renderers, dealt_to > 0 ? std::min(dealt_to, renderers) : renderers);
  }
  /// For each of `renderers` Renderers, whether it has a region.
  std::vector<bool> drawing(int renderers) const;
};
LatticeFrame lattice_frame(const Grid& grid);
/// Of the slice set that a view traverses.
Axis traversed_axis(const Camera& camera, const Grid& grid, int width, int height);
FrameGeometry make_geometry(const FrameSpec& spec, const Grid& grid);

}  // namespace ringsplat
