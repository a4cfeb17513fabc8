#include <fmt/format.h>

#include "forecast/forecast.hpp"
#include "program/layouts.hpp"

namespace ringsplat::app {

const char* name(Limit limit) {
  switch (limit) {
    case Limit::gps:
      return "the GPs";
    case Limit::renderers:
      return "the Renderers";
    case Limit::cores:
      break;
  }
  return "the cores";
}

std::string describe(const FrameWork& work) {
  const auto each = [](double seconds, double count) { return count > 0 ? 1e9 * seconds / count : 0.0; };
  return fmt::format(
      "{:.0f} visible voxels of {:.1f} ns on a GP, {:.0f} {} of {:.1f} ns on a Renderer, {:.2f} ms a frame "
      "on "
      "each GP",
      work.visible_voxels, each(work.gp, work.visible_voxels), work.items, work.items_name,
      each(work.renderer, work.items), 1e3 * work.frame);
}

std::string to_table(const std::vector<Prediction>& predictions) {
  std::string text = fmt::format("  {:<38}{:>10}{:>10}{:>12}{:>10}{:>10}   limit\n", "ms a frame",
                                 "predicted", "GP", "Renderer", "cores", "tokens");
  for (const Prediction& p : predictions)
    text += fmt::format("  {:<38}{:>10.2f}{:>10.2f}{:>12.2f}{:>10.2f}{:>10.2f}   {}\n", describe(p.layout),
                        1e3 * p.seconds, 1e3 * p.gp, 1e3 * p.renderer, 1e3 * p.shared, 1e3 * p.tokens,
                        name(p.limit));
  return text;
}

}  // namespace ringsplat::app
