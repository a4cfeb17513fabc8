// The hard values again, with half and byte payloads compared with float payloads.
#include <fmt/format.h>

#include <limits>

#include "support/catch.hpp"
#include "truth/truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct HardCase {
  const char* name;
  Volume volume;
  TransferFunction transfer_function;
};

std::vector<HardCase> hard_cases() {
  const auto pattern = [](int x, int y, int z) { return double((7 * x + 13 * y + 5 * z) % 101) / 100; };
  const auto with = [pattern](double odd) {
    return [pattern, odd](int x, int y, int z) { return (x + y + z) % 9 == 0 ? odd : pattern(x, y, z); };
  };
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const TransferFunction soft = ramp(0.1, 1, 0.3);
  const glm::ivec3 dims{14, 15, 16};
  std::vector<HardCase> cases;
  cases.push_back({"not-a-number", make_volume(dims, ScalarType::float32, with(std::nan(""))), soft});
  cases.push_back({"infinities", make_volume(dims, ScalarType::float32, with(infinity)), soft});
  cases.push_back({"denormals", make_volume(dims, ScalarType::float32, with(1e-40)), soft});
  cases.push_back({"the largest floats", make_volume(dims, ScalarType::float32, with(3.4e38)), soft});
  cases.push_back(
      {"int16 at its end",
       make_volume(dims, ScalarType::int16, [](int x, int, int) { return x % 2 == 0 ? -32768.0 : 32767.0; }),
       ramp(-32769, 32767, 0.3)});
  cases.push_back(
      {"uint32 at its end",
       make_volume(dims, ScalarType::uint32, [](int x, int, int) { return x % 2 == 0 ? 4294967295.0 : 0.0; }),
       ramp(1, 4294967295.0, 0.3)});
  cases.push_back({"opacity 1", make_volume(dims, ScalarType::float32, pattern), constant_opacity(1.0, 0.5)});
  cases.push_back({"a jump", make_volume(dims, ScalarType::float32, pattern), constant_opacity(0.4, 0.5)});
  cases.push_back({"constant", make_volume(dims, ScalarType::uint8, [](int, int, int) { return 100.0; }),
                   constant_opacity(0.05)});
  cases.push_back({"one voxel",
                   make_volume({1, 1, 1}, ScalarType::uint8, [](int, int, int) { return 100.0; }),
                   constant_opacity(0.5)});
  cases.push_back({"a plane", make_volume({1, 15, 16}, ScalarType::float32, pattern), soft});
  cases.push_back({"transparent", make_volume(dims, ScalarType::float32, pattern), constant_opacity(0.5, 3)});
  return cases;
}

}  // namespace

TEST_CASE("hard values travel as halves and as bytes") {
  // A half keeps 11 bits of each colour and opacity, a byte is off by half a level at most; errors of sixteen
  // slices go to both sides. A value decoded wrongly would differ by a hundred levels.
  for (const HardCase& hard : hard_cases()) {
    for (const Shading shading : {Shading::none, Shading::phong}) {
      INFO(hard.name << (shading == Shading::phong ? ", shaded" : ""));
      FrameSpec spec = plain_spec(hard.transfer_function, 40, {.azimuth = 27, .elevation = 18});
      spec.shown.shading = shading;
      const Image exact = rendered(hard.volume, spec);
      spec.as<Splats>().precision = Precision::half;
      const double half = largest_difference(rendered(hard.volume, spec), exact);
      spec.as<Splats>().precision = Precision::u8;
      const double bytes = largest_difference(rendered(hard.volume, spec), exact);
      UNSCOPED_INFO(fmt::format("half {:.3g}, bytes {:.3g} of 255", 255 * half, 255 * bytes));
      CHECK(half < 1.0 / 4096);
      CHECK(bytes < 1.0 / 255);
      CHECK((brightest(exact) > 0) == (std::string(hard.name) != "transparent"));
    }
  }
}
