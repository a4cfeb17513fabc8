#include <glm/geometric.hpp>

#include "formats/files.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "support/catch.hpp"

using namespace files;

namespace {
double mean_of(const std::string& slice, int width, int left, int right) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < int(slice.size()); ++i) {
    const int x = i % width;
    if (x < left || x >= right) continue;
    sum += static_cast<unsigned char>(slice[std::size_t(i)]);
    ++count;
  }
  return sum / count;
}
}  // namespace

TEST_CASE("the head has the paper's size, its physical size and its share of visible voxels", "[head]") {
  const auto source = open_volume(fs::path(RINGSPLAT_TEST_DATA) / "head.nrrd");
  const auto& grid = source->grid();
  CHECK(grid.dims == glm::ivec3(128, 128, 124));
  CHECK(grid.type == ScalarType::uint8);
  CHECK_FALSE(source->concurrent());
  const auto size = grid.spacing * glm::dvec3(grid.dims);
  CHECK(glm::distance(size, glm::dvec3(181, 217, 181)) < 1e-6);

  const auto bytes = read_all(*source);
  const auto visible =
      std::count_if(bytes.begin(), bytes.end(), [](char c) { return static_cast<unsigned char>(c) >= 75; });
  CHECK(double(visible) / double(grid.voxels()) == Approx(0.32).margin(0.02));
  ValueRange range;
  range.add(grid.type, std::as_bytes(std::span(bytes)));
  CHECK(range.low == 0);
  CHECK(range.high > 200);
}

TEST_CASE("the head lies in left-posterior-superior world coordinates", "[head]") {
  const auto source = open_volume(fs::path(RINGSPLAT_TEST_DATA) / "head.nrrd");
  const auto& grid = source->grid();
  // The template's lattice runs to right, anterior, superior.
  CHECK(grid.direction[0].x < -0.999);
  CHECK(grid.direction[1].y < -0.999);
  CHECK(grid.direction[2].z > 0.999);
  // Inferior slices cut neck and jaw, the topmost one only air.
  CHECK(mean_of(read_slice(*source, 123), 128, 0, 128) < 5);
  CHECK(mean_of(read_slice(*source, 40), 128, 0, 128) > 20);
  // A head is nearly as much left as right.
  const auto middle = read_slice(*source, 62);
  CHECK(mean_of(middle, 128, 0, 64) == Approx(mean_of(middle, 128, 64, 128)).epsilon(0.1));
}
