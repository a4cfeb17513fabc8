// Colour maps against all 256 entries of the originals.
#include <fstream>
#include <sstream>

#include "classify/adjust.hpp"
#include "classify/colour_maps.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

TEST_CASE("every colour map is within 4 of 255 display levels of the original everywhere") {
  // A map a line: its name and its entries as rrggbb, as matplotlib 3.11 has them; ParaView's two
  // interpolated.
  std::ifstream file(RINGSPLAT_TEST_DATA "/colour_maps.txt");
  REQUIRE(file);
  std::size_t maps = 0;
  for (std::string line; std::getline(file, line); ++maps) {
    const auto tab = line.find('\t');
    const std::string name = line.substr(0, tab), entries = line.substr(tab + 1);
    REQUIRE(entries.size() == 256 * 6);
    TransferFunction tf;
    tf.colours = colours_over(colour_map(name), {0, 255});
    tf.opacities = {{0, 1}, {255, 1}};
    REQUIRE(message_of([&] { check(tf, name); }).empty());
    double worst = 0;
    for (std::size_t k = 0; k < 256; ++k) {
      const glm::dvec3 linear = tf.evaluate(double(k)).colour;
      for (int c = 0; c < 3; ++c) {
        const double value =
            linear[c] <= 0.0031308 ? 12.92 * linear[c] : 1.055 * std::pow(linear[c], 1 / 2.4) - 0.055;
        const int wanted = std::stoi(entries.substr(6 * k + 2 * std::size_t(c), 2), nullptr, 16);
        worst = std::max(worst, std::abs(255 * value - wanted));
      }
    }
    INFO(name << ' ' << worst);
    CHECK(worst < 4);
  }
  CHECK(maps == colour_map_names().size());
}

TEST_CASE("colour maps are found in any spelling of their names, and an unknown one lists all") {
  CHECK(colour_map("Viridis").name == "viridis");
  CHECK(colour_map("rdbu").name == "RdBu");
  CHECK(colour_map("black-body radiation").name == "Black-Body Radiation");
  CHECK(colour_map("Cool to Warm").name == "coolwarm");
  const auto message = message_of<InputError>([] { static_cast<void>(colour_map("virids")); });
  CHECK(says(message, "\"virids\""));
  for (const auto& [name, description] : colour_map_names()) {
    CHECK(says(message, name));
    CHECK_FALSE(description.empty());
  }
}
