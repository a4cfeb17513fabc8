#include <random>
#include <vector>

#include "classify/empty_space.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Rows of noise, some of them clear; their length is no multiple of a mask's.
template <class T>
std::vector<T> noise(int width, int height) {
  std::mt19937 random(5);
  std::vector<T> values;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) values.push_back(row < 8 ? T{0} : T(random() % 200));
  return values;
}

template <class T>
void require_visible(EmptySpace& space, const SliceView& slice, const std::vector<T>& values,
                     const TransferFunction& tf) {
  VisibleVoxels& visible = space.voxels(slice, tf);
  for (int row = 0; row < slice.height; ++row) {
    const auto masks = visible.of_row(slice, row);
    for (int column = 0; column < slice.width; ++column) {
      const double value = double(values[std::size_t(row * slice.width + column)]);
      const bool found = !masks.empty() && (masks[std::size_t(column / 64)] >> column % 64 & 1) != 0;
      REQUIRE(found == (tf.evaluate(value).opacity > 0));
    }
  }
}

}  // namespace

TEMPLATE_TEST_CASE("what is visible is kept, and found anew for another transfer function", "", std::uint8_t,
                   float) {
  constexpr int width = 150, height = 40;
  const std::vector<TestType> values = noise<TestType>(width, height);
  const ScalarType type = sizeof(TestType) == 1 ? ScalarType::uint8 : ScalarType::float32;
  const SliceView slice{Axis::z, 3, width, height, type, reinterpret_cast<const std::byte*>(values.data()),
                        nullptr};
  EmptySpace space;
  const TransferFunction dense = ramp(100, 190, 0.5), everything = constant_opacity(0.5),
                         nothing = ramp(900, 950, 1);
  for (const auto* tf : {&dense, &dense, &everything, &dense, &nothing, &everything})
    require_visible(space, slice, values, *tf);
  CHECK(space.voxels(slice, nothing).of_row(slice, 20).empty());
}
