#include "classify/colour_maps.hpp"

#include <cctype>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Points as rrggbb one after another, at `places` or, without those, evenly from 0 to 1. Between points
/// display colours are interpolated.
///
/// Sources: viridis, plasma, inferno, magma (S. van der Walt, N. Smith) and cividis (J. Nunez, C. Anderton,
/// R. Renslow) are matplotlib's, CC0. gray, bone, hot and jet are matplotlib's (its own, BSD-like licence).
/// RdBu is ColorBrewer's (C. Brewer, Apache 2.0), turbo Google's (A. Mikhailov, Apache 2.0). coolwarm (K.
/// Moreland), Black-Body Radiation and Rainbow Desaturated are ParaView's, BSD.
struct Table {
  PresetName name;
  std::string points;
  std::vector<double> places = {};
};

const std::vector<Table>& tables() {
  static const std::vector<Table> all{
      {{"viridis", "perceptual, dark blue to yellow"},
       "440154470d6048186a482374472d7b4536814240863f49893b528b375a8d33638d2f6a8e2c728e297a8e26818e23898e"
       "21908c1f988b1f9f8821a68528ae8031b57b3ebc744cc26c5dc9636ece5882d34c96d83fabdc32c0df24d5e21aeae51a"
       "fde725"},
      {{"plasma", "perceptual, blue to yellow through red"},
       "0d08872206903105963f049c4c02a15901a56600a77201a87e03a88909a69511a29f1a9ca92396b22c8ebb3587c33e80"
       "cb4778d25071d9596ae06263e66c5ceb7555f07f4ff48a48f89441fb9f3afdab33feb72dfdc328fcd025f9dd25f5eb27"
       "f0f921"},
      {{"inferno", "perceptual, black to light yellow through red"},
       "0000040403120b0724150b37210c4a2e0a5a3c09654a0c6b57106d63146e70196e7d1e6d89226a962766a32b61af315c"
       "bb3755c63e4dd14644db4f3be35932eb6528f1711ef67f14f98d0afb9c06fcab0ffbba1ff9ca32f5d949f2e865f3f586"
       "fcffa4"},
      {{"magma", "perceptual, black to white through purple"},
       "0000040303110a0822130d331d114628115a36106a430f7650127c5d177f691c817621818226818f2a819c2e7fa9327d"
       "b63779c33b75cf4170db486ae65163ee5c5ef5695cf9785dfb8761fd9668fea571feb47bfec387fed194fde0a2fceeb0"
       "fcfdbf"},
      {{"cividis", "perceptual, blue to yellow, the same for colour-blind eyes"},
       "00224e00255400285b002b62002e6a0030700433711135701a386f213b6e273e6e2d416d32436d36466c3b496c3f4c6c"
       "434e6c47516c4b546c4f576c52596d565c6d5a5f6e5d626e61656f646770686a716b6d726f7073727374757676797877"
       "7c7b78807e788481798784788b87788f8a78938d789790779b93769f9676a39a75a79d74aba072afa371b3a670b7aa6e"
       "bbad6cbfb06bc3b469c8b766ccba64d0be61d4c15fd9c55cddc958e1cc55e6d051ead44cefd748f4db42f8df3cfde334"
       "fee838"},
      {{"coolwarm", "diverging, blue to red through grey: ParaView's \"Cool to Warm\""},
       "3b4cc0445acc4d68d75775e16282ea6c8ef1779af782a5fb8db0fe98b9ffa3c2feaec9fcb8d0f9c2d5f4ccd9eed5dbe6"
       "dddddde5d8d1ecd3c5f1ccb9f4c4adf7bba0f7b194f7a687f49a7bf18d6fec7f63e57058de604dd55042cb3e38c0282f"
       "b40426"},
      {{"RdBu", "diverging, red to blue through white"},
       "67001fb1182bd6604df3a481fddbc7f6f7f7d1e5f090c4dd4393c32065ab053061"},
      {{"Black-Body Radiation", "black to white through red and yellow"},
       "000000e60000e6e600ffffff",
       {0, 0.4, 0.8, 1}},
      {{"gray", "black to white"}, "000000ffffff", {0, 1}},
      {{"bone", "black to white, bluish"}, "000000515171a6c6c6ffffff", {0, 0.365079, 0.746032, 1}},
      {{"hot", "black to white through red and yellow"},
       "0b0000ff0000ffff00ffffff",
       {0, 0.365079, 0.746032, 1}},
      {{"turbo", "rainbow of even brightness steps"},
       "30123b392a734040a14456c7466be3467ff64293ff37a7fa29bbec1dcdd818dcc31ee8b031f2994cf97e6bfd648aff4d"
       "a3fd3cb8f735cced34dee037edd03af8c03afdae35fe982cfb8022f56817ec520fe04009d23105c02302ac1701950d01"
       "7a0403"},
      {{"Rainbow Desaturated", "rainbow, dull"},
       "4747db00005c00ffff008000ffff00ff61006b0000e04d4d",
       {0, 0.143, 0.285, 0.429, 0.571, 0.714, 0.857, 1}},
      {{"jet", "rainbow, for comparing with old pictures: it shows steps that are not there"},
       "0000800000ff0000ff00dbff00e5f715ffe2efff08f7f600ffec00ff1300e80000800000",
       {0, 0.11, 0.125, 0.34, 0.35, 0.375, 0.64, 0.65, 0.66, 0.89, 0.91, 1}},
  };
  return all;
}

/// Other names of the same maps, in ParaView.
const std::pair<const char*, const char*> aliases[] = {
    {"cooltowarm", "coolwarm"}, {"grayscale", "gray"}, {"grey", "gray"}, {"greys", "gray"}};

/// Letters and digits alone, in lower case, so that "Black Body radiation" is found, too.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) plain += char(std::tolower(c));
  return plain;
}

std::vector<glm::dvec3> colours_of(std::string_view text) {
  std::vector<glm::dvec3> colours;
  for (; !text.empty(); text.remove_prefix(6)) colours.push_back(*hex_colour(text.substr(0, 6)));
  return colours;
}

ColourMap made(const Table& table) {
  constexpr double step = 1.0 / 64;
  const auto colours = colours_of(table.points);
  const auto place = [&](std::size_t k) {
    return table.places.empty() ? double(k) / double(colours.size() - 1) : table.places[k];
  };
  ColourMap map{table.name.name, {}};
  for (std::size_t k = 0; k + 1 < colours.size(); ++k) {
    const double from = place(k), to = place(k + 1);
    // Points are interpolated in linear light, so that steps in display colours must be small.
    const int parts = std::max(1, int(std::ceil((to - from) / step - 1e-9)));
    for (int i = 0; i < parts; ++i) {
      const double t = double(i) / parts;
      map.points.push_back({std::lerp(from, to, t), colours[k] + t * (colours[k + 1] - colours[k])});
    }
  }
  map.points.push_back({1.0, colours.back()});
  return map;
}

}  // namespace

std::vector<PresetName> colour_map_names() { return detail::mapped(tables(), &Table::name); }

ColourMap colour_map(const std::string& name) {
  std::string wanted = plain_name(name);
  for (const auto& [alias, real] : aliases)
    if (wanted == alias) wanted = real;
  for (const Table& table : tables())
    if (plain_name(table.name.name) == wanted) return made(table);
  throw InputError(fmt::format("there is no colour map \"{}\"", name),
                   "use one of " + detail::joined(colour_map_names(), ", ", &PresetName::name));
}

}  // namespace ringsplat
