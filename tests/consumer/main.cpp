// Renders a slab of which each rank has a part, checks its opacity, and writes its picture:  mpirun -n 3
// consumer
#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <vector>

#include "ringsplat/ringsplat.hpp"

namespace {

constexpr double opacity_per_voxel = 0.1;
constexpr int depth = 24;  // voxels along y, which the camera looks along

ringsplat::Grid slab() {
  ringsplat::Grid grid;
  grid.dims = {40, depth, 40};
  grid.type = ringsplat::ScalarType::uint8;
  return grid;
}

ringsplat::FrameSpec red_view() {
  ringsplat::FrameSpec spec;
  spec.shown.width = spec.shown.height = 160;
  spec.division.region_size = 64;
  spec.shown.shading = ringsplat::Shading::none;
  spec.shown.transfer_function.colours = {{0, {1, 0, 0}}, {255, {1, 0, 0}}};
  spec.shown.transfer_function.opacities = {{0, opacity_per_voxel}, {255, opacity_per_voxel}};
  return spec;
}

/// Mean of one channel over the middle 32 × 32 pixels, some ten kernels wide: their ripple averages out.
double middle_mean(const ringsplat::Image& image, int channel) {
  constexpr int side = 32;
  double sum = 0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      sum += image.pixel((image.width - side) / 2 + x, (image.height - side) / 2 + y)[channel];
  return sum / (side * side);
}

bool near(const char* what, double is, double should_be) {
  const bool fine = std::abs(is - should_be) <= 0.01 * should_be + 1e-6;
  std::printf("%s: %.5f, expected %.5f: %s\n", what, is, should_be, fine ? "ok" : "WRONG");
  return fine;
}

bool check_image(const ringsplat::Image& image, int rank) {
  if (rank != 0) return image.rgba.empty();
  if (image.width != 160 || image.height != 160) return false;
  const double opacity = 1 - std::pow(1 - opacity_per_voxel, depth);
  const bool alpha = near("opacity", middle_mean(image, 3), opacity);
  const bool red = near("red", middle_mean(image, 0), opacity);
  const bool green = near("green", middle_mean(image, 1), 0);
  const bool outside = near("opacity in the corner", image.pixel(0, 0)[3], 0);
  return alpha && red && green && outside;
}

bool run(MPI_Comm comm) {
  const ringsplat::Layout layout{.gps = 2, .renderers = 1};
  ringsplat::Session session(comm, layout);
  const ringsplat::Grid grid = slab();
  ringsplat::VoxelBox part = ringsplat::whole_box(grid);
  part.first.x = grid.dims.x * session.rank() / session.ranks();
  part.end.x = grid.dims.x * (session.rank() + 1) / session.ranks();
  const glm::ivec3 dims = part.dims();
  const std::vector<unsigned char> voxels(std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z),
                                          100);
  session.set_grid(grid);
  session.add_block(part, voxels.data());
  session.commit();
  const ringsplat::Image image = session.render(red_view());
  // What writes images is loaded when it is needed, from where the package is installed.
  if (session.rank() == 0) ringsplat::write_image(image, "slab.png");
  return check_image(image, session.rank()) &&
         (session.rank() != 0 || std::filesystem::file_size("slab.png") > 0);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  int wrong = 1, wrong_anywhere = 1;
  try {
    wrong = run(MPI_COMM_WORLD) ? 0 : 1;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "rank %d: %s\n", rank, e.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  if (wrong != 0) std::fprintf(stderr, "rank %d: not the image that was expected\n", rank);
  MPI_Allreduce(&wrong, &wrong_anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return wrong_anywhere;
}
