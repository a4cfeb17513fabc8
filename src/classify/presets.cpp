#include "base/text.hpp"
#include "classify/auto_preset.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {
namespace {

enum class Scale { range, hounsfield };

/// A preset's points; `at` is a share of the volume's range (0..1) or Hounsfield units.
struct PresetTable {
  PresetName name;
  Scale scale;
  std::vector<TransferFunction::ColourPoint> colours;
  std::vector<TransferFunction::OpacityPoint> opacities;
};

// The MR shares suit a T1-weighted head whose air is near 0: skin from 0.1, grey matter about 0.3, white
// matter about 0.44, fat above. The skin's slopes are gentle: voxels are classified before interpolation, and
// steep slopes show the lattice as rings.
const std::vector<PresetTable>& tables() {
  static const std::vector<PresetTable> all{
      {{"mr-soft", "MR head, soft: fat, white and grey matter glow through each other"},
       Scale::range,
       {{0.0, {0.25, 0.10, 0.08}},
        {0.30, {0.62, 0.30, 0.22}},
        {0.40, {0.85, 0.58, 0.42}},
        {0.50, {0.96, 0.84, 0.68}},
        {1.0, {1.0, 0.97, 0.90}}},
       {{0.0, 0.0}, {0.297, 0.0}, {0.34, 0.02}, {0.42, 0.06}, {0.55, 0.20}, {1.0, 0.50}}},
      {{"mr-surface", "MR head, one steep surface about the brightest tissue"},
       Scale::range,
       {{0.0, {0.80, 0.58, 0.45}},
        {0.42, {0.86, 0.66, 0.52}},
        {0.60, {0.94, 0.84, 0.72}},
        {1.0, {1.0, 0.96, 0.90}}},
       {{0.0, 0.0}, {0.43, 0.0}, {0.47, 0.9}, {1.0, 0.95}}},
      {{"mr-skin", "MR head, the skin as a closed surface"},
       Scale::range,
       {{0.0, {0.72, 0.48, 0.38}},
        {0.15, {0.84, 0.62, 0.50}},
        {0.40, {0.95, 0.78, 0.66}},
        {1.0, {1.0, 0.92, 0.84}}},
       {{0.0, 0.0}, {0.04, 0.0}, {0.24, 0.25}, {0.48, 0.35}, {1.0, 0.4}}},
      {{"ct-bone", "CT in Hounsfield units: bone alone"},
       Scale::hounsfield,
       {{-1000, {0.55, 0.25, 0.15}},
        {150, {0.73, 0.45, 0.30}},
        {350, {0.90, 0.82, 0.66}},
        {1500, {1.0, 0.99, 0.95}}},
       {{-1000, 0.0}, {150, 0.0}, {300, 0.15}, {600, 0.6}, {1500, 0.9}, {3000, 0.95}}},
      {{"ct-skin", "CT in Hounsfield units: the skin as a closed surface"},
       Scale::hounsfield,
       {{-1000, {0.80, 0.56, 0.44}},
        {-400, {0.84, 0.62, 0.50}},
        {100, {0.95, 0.78, 0.66}},
        {600, {1.0, 0.96, 0.88}}},
       {{-1000, 0.0}, {-500, 0.0}, {-300, 0.4}, {-100, 0.9}, {3000, 0.95}}},
      {{"ct-soft", "CT in Hounsfield units: muscle and organs translucent about the bone"},
       Scale::hounsfield,
       {{-1000, {0.45, 0.12, 0.08}},
        {-50, {0.75, 0.38, 0.26}},
        {60, {0.82, 0.36, 0.28}},
        {180, {0.90, 0.70, 0.52}},
        {500, {1.0, 0.98, 0.92}}},
       {{-1000, 0.0},
        {-120, 0.0},
        {-20, 0.01},
        {40, 0.04},
        {120, 0.06},
        {250, 0.3},
        {700, 0.7},
        {3000, 0.9}}},
      {{"grey", "black to white over the volume's range, clear to a quarter opaque"},
       Scale::range,
       {{0.0, {0.0, 0.0, 0.0}}, {1.0, {1.0, 1.0, 1.0}}},
       {{0.0, 0.0}, {1.0, 0.25}}},
  };
  return all;
}

constexpr const char* automatic = "auto";

}  // namespace

std::vector<PresetName> preset_names() {
  auto names = detail::mapped(tables(), &PresetTable::name);
  names.push_back({automatic,
                   "chosen by the values: CT, labels, both signs, many decades; else background clear, rare "
                   "values dense"});
  return names;
}

TransferFunction preset(const std::string& name, const Histogram& histogram) {
  if (name == automatic) return choose_function(describe_values(histogram)).function;
  for (const auto& table : tables())
    if (table.name.name == name) {
      TransferFunction tf{table.name.name, table.colours, table.opacities};
      if (table.scale == Scale::range) stretch(tf, range_of(histogram));
      return tf;
    }
  throw InputError(fmt::format("there is no transfer function \"{}\"", name),
                   fmt::format("use one of {} or a ParaView colour map (.json)",
                               detail::joined(preset_names(), ", ", &PresetName::name)));
}

}  // namespace ringsplat
