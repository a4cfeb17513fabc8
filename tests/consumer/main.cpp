// Renders a slab that rank 0 holds in memory and checks its opacity, and asks for a picture that is not
// there:  mpirun -n 3 consumer
#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "ringsplat/images/image_file.hpp"
#include "ringsplat/mpi/communicator.hpp"
#include "ringsplat/session/render.hpp"

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

/// What reads images is loaded when it is needed, from where the package is installed; throws when it is not
/// found.
bool knows_images() { return !ringsplat::open_image_file("no such picture.png").file; }

bool run(MPI_Comm comm, int rank) {
  const ringsplat::Grid grid = slab();
  const std::vector<std::byte> voxels(rank == 0 ? grid.bytes() : 0, std::byte{100});
  const auto transport = ringsplat::make_mpi_transport(comm);
  const auto collectives = ringsplat::make_mpi_collectives(comm);
  const ringsplat::Layout layout{.gps = 2, .renderers = 1};
  return check_image(
      ringsplat::render_image(grid, voxels, red_view(), layout, {*collectives, transport.get()}), rank);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  int wrong = 1, wrong_anywhere = 1;
  try {
    wrong = run(MPI_COMM_WORLD, rank) && knows_images() ? 0 : 1;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "rank %d: %s\n", rank, e.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  if (wrong != 0) std::fprintf(stderr, "rank %d: not the image that was expected\n", rank);
  MPI_Allreduce(&wrong, &wrong_anywhere, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return wrong_anywhere;
}
