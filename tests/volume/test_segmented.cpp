#include "volume/segmented.hpp"

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/message_of.hpp"
#include "volume/forwarding_source.hpp"

using namespace ringsplat;

namespace {

constexpr int side = 6;

Grid cube(int n, ScalarType type, double spacing = 1, const glm::dvec3& origin = glm::dvec3(0)) {
  Grid grid;
  grid.dims = glm::ivec3(n);
  grid.spacing = glm::dvec3(spacing);
  grid.origin = origin;
  grid.type = type;
  return grid;
}

/// Values by place, which it owns.
template <class T, class Value>
std::unique_ptr<VolumeSource> source_of(const Grid& grid, const VolumeNotes& notes, Value value) {
  struct Owner final : ForwardingSource {
    Owner(std::unique_ptr<VolumeSource> source, std::shared_ptr<std::vector<T>> kept)
        : ForwardingSource(std::move(source)), values(std::move(kept)) {}
    std::shared_ptr<std::vector<T>> values;
  };
  auto values = std::make_shared<std::vector<T>>();
  for (int z = 0; z < grid.dims.z; ++z)
    for (int y = 0; y < grid.dims.y; ++y)
      for (int x = 0; x < grid.dims.x; ++x) values->push_back(T(value(x, y, z)));
  auto memory = memory_source(grid, std::as_bytes(std::span(*values)));
  return with_notes(std::make_unique<Owner>(std::move(memory), values), notes);
}

double number_at(int x, int y, int z) { return 1 + x + side * y + side * side * z; }
int label_at(int x, int, int z) { return z < 2 ? 0 : 1 + x / 2; }

template <class T>
std::unique_ptr<VolumeSource> numbered(ScalarType type, const VolumeNotes& notes = {}) {
  return source_of<T>(cube(side, type), notes, number_at);
}
std::unique_ptr<VolumeSource> labelled(const VolumeNotes& notes = {}) {
  return source_of<std::uint8_t>(cube(side, ScalarType::uint8), notes, label_at);
}

template <class T>
std::vector<T> slices_of(VolumeSource& source, int first, int count) {
  std::vector<T> values(std::size_t(count * side * side));
  source.read_slices(first, count, std::as_writable_bytes(std::span(values)));
  return values;
}

/// The voxels of a masked volume that keep their numbers; of all others `is_outside` is asked.
template <class T, class Shown, class Outside>
void check_voxels(VolumeSource& masked, Shown shown, Outside is_outside) {
  const auto values = slices_of<T>(masked, 0, side);
  std::size_t i = 0, wrong = 0;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x, ++i)
        wrong += shown(x, y, z) ? values[i] != T(number_at(x, y, z)) : !is_outside(values[i]);
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("a mask keeps what has a label, or one of some, and empties all else") {
  const auto is_zero = [](auto value) { return value == 0; };
  const auto all = segmented_source(numbered<std::uint16_t>(ScalarType::uint16), labelled(), {});
  check_voxels<std::uint16_t>(
      *all, [](int x, int y, int z) { return label_at(x, y, z) != 0; }, is_zero);
  const auto some =
      segmented_source(numbered<std::uint16_t>(ScalarType::uint16), labelled(), {{1, 1}, {3, 9}});
  check_voxels<std::uint16_t>(
      *some, [](int x, int y, int z) { return label_at(x, y, z) == 1 || label_at(x, y, z) == 3; }, is_zero);
  const auto background = segmented_source(numbered<std::uint16_t>(ScalarType::uint16), labelled(), {{0, 0}});
  check_voxels<std::uint16_t>(
      *background, [](int, int, int z) { return z < 2; }, is_zero);
  // Whatever slices are asked for.
  const auto whole = slices_of<std::uint16_t>(*all, 0, side), part = slices_of<std::uint16_t>(*all, 3, 2);
  CHECK(std::equal(part.begin(), part.end(), whole.begin() + 3 * side * side));
  CHECK(all->facts() != some->facts());
}

TEST_CASE("outside of a mask are voxels without data") {
  const auto shown = [](int x, int y, int z) { return label_at(x, y, z) == 2; };
  const LabelRanges two{{2, 2}};
  check_voxels<float>(*segmented_source(numbered<float>(ScalarType::float32), labelled(), two), shown,
                      [](float v) { return std::isnan(v); });
  check_voxels<std::int16_t>(
      *segmented_source(numbered<std::int16_t>(ScalarType::int16, {.modality = "CT"}), labelled(), two),
      shown, [](int v) { return v == -1000; });
  check_voxels<std::uint8_t>(
      *segmented_source(numbered<std::uint8_t>(ScalarType::uint8, {.modality = "CT"}), labelled(), two),
      shown, [](int v) { return v == 0; });
  check_voxels<std::int16_t>(
      *segmented_source(numbered<std::int16_t>(ScalarType::int16, {.fill = -99.0}), labelled(), two), shown,
      [](int v) { return v == -99; });
}

TEST_CASE("what a mask leaves out of a CT is air, also where no file says that it is one") {
  const auto left_out = [](int in_first_slice) {
    const auto masked = segmented_source(
        source_of<std::int16_t>(cube(side, ScalarType::int16), {},
                                [=](int x, int, int z) { return z == 0 && x == 3 ? in_first_slice : 40; }),
        labelled(), {{2, 2}});
    return slices_of<std::int16_t>(*masked, side - 1, 1).front();
  };
  CHECK(left_out(-1020) == -1000);
  CHECK(left_out(-200) == 0);
}

TEST_CASE("a segmentation of another grid is looked up where voxels lie") {
  const VolumeNotes patient{.world = World::patient};
  // Voxels twice as large, of which the first lies over voxels 2 and 3.
  const auto coarse = [&](const VolumeNotes& notes) {
    return source_of<std::int32_t>(cube(2, ScalarType::int32, 2, glm::dvec3(2.5)), notes,
                                   [](int x, int, int) { return x == 0 ? 7 : 300; });
  };
  const auto inside = [](int p) { return 2 <= p && p < 6; };
  const auto is_zero = [](auto value) { return value == 0; };
  check_voxels<std::uint8_t>(
      *segmented_source(numbered<std::uint8_t>(ScalarType::uint8, patient), coarse(patient), {}),
      [&](int x, int y, int z) { return inside(x) && inside(y) && inside(z); }, is_zero);
  check_voxels<std::uint8_t>(
      *segmented_source(numbered<std::uint8_t>(ScalarType::uint8, patient), coarse(patient), {{300, 300}}),
      [&](int x, int y, int z) { return 4 <= x && x < 6 && inside(y) && inside(z); }, is_zero);
  CHECK(says(message_of([&] {
               segmented_source(numbered<std::uint8_t>(ScalarType::uint8, patient), coarse({}), {});
             }),
             "the segmentation's world coordinates are not of the volume's kind"));
  // As many voxels that say nothing of where they are lie on the volume's.
  check_voxels<std::uint8_t>(
      *segmented_source(numbered<std::uint8_t>(ScalarType::uint8, patient),
                        source_of<std::uint8_t>(cube(side, ScalarType::uint8, 9), {}, label_at), {}),
      [](int x, int y, int z) { return label_at(x, y, z) != 0; }, is_zero);
}

TEST_CASE("a segmentation that tints tells labels, one that outlines those at borders") {
  const auto with = [](LabelRanges ranges, Covered covered) {
    return segmented_source(numbered<std::uint16_t>(ScalarType::uint16), labelled(), std::move(ranges),
                            covered);
  };
  const auto check_labels = [](VolumeSource& volume, auto label) {
    check_voxels<std::uint16_t>(
        volume, [](int, int, int) { return true; }, [](int) { return false; });
    REQUIRE(volume.labels() != nullptr);
    const auto labels = slices_of<std::uint8_t>(*volume.labels(), 0, side);
    std::size_t i = 0, wrong = 0;
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x, ++i) wrong += labels[i] != label(x, y, z);
    CHECK(wrong == 0);
    const auto part = slices_of<std::uint8_t>(*volume.labels(), 3, 2);
    CHECK(std::equal(part.begin(), part.end(), labels.begin() + 3 * side * side));
  };
  check_labels(*with({}, Covered::tinted), label_at);
  check_labels(*with({{2, 2}}, Covered::tinted),
               [](int x, int y, int z) { return label_at(x, y, z) == 2 ? 2 : 0; });
  check_labels(*with({}, Covered::outlined), [](int x, int y, int z) {
    const int label = label_at(x, y, z);
    const auto differs = [&](int dx, int dz) {
      const int nx = x + dx, nz = z + dz;
      return nx >= 0 && nx < side && nz >= 0 && nz < side && label_at(nx, y, nz) != label;
    };
    return differs(-1, 0) || differs(1, 0) || differs(0, -1) || differs(0, 1) ? label : 0;
  });
  CHECK(with({}, Covered::alone)->labels() == nullptr);
  // Bytes begin again behind the last of them.
  const auto large =
      segmented_source(numbered<std::uint16_t>(ScalarType::uint16),
                       source_of<std::uint16_t>(cube(side, ScalarType::uint16), {},
                                                [](int x, int, int) { return x == 0 ? 0 : 126 + x; }),
                       {}, Covered::tinted);
  CHECK(slices_of<std::uint8_t>(*large->labels(), 0, 1)[1] == 127);
  CHECK(slices_of<std::uint8_t>(*large->labels(), 0, 1)[2] == 1);
}
