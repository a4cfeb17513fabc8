#include "serve/ruler.hpp"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "frame/frame_geometry.hpp"

namespace ringsplat::serve {
namespace {

/// What of a line lies in the picture, so that its mask is never larger.
std::optional<std::pair<glm::dvec2, glm::dvec2>> within(const glm::dvec2& from, const glm::dvec2& to,
                                                        const glm::dvec2& size) {
  const glm::dvec2 way = to - from;
  double first = 0, last = 1;
  for (int k = 0; k < 2; ++k) {
    const double a = -from[k] / way[k], b = (size[k] - from[k]) / way[k];
    if (way[k] != 0)
      first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
    else if (!(from[k] >= 0 && from[k] <= size[k]))
      return std::nullopt;
  }
  if (!(first < last)) return std::nullopt;
  return std::pair(from + first * way, from + last * way);
}

}  // namespace

Overlay ruler_overlay(const Ruler& ruler, const Shown& shown, const Grid& grid, const std::string& unit,
                      const glm::dvec3& background) {
  const ViewTransform view = make_view(shown.camera, lattice_frame(grid), shown.width, shown.height);
  const bool dark_ink = glm::dot(background, glm::dvec3(0.299, 0.587, 0.114)) > 0.55;
  Drawing drawing(shown.width, shown.height, dark_ink);
  const auto write = [&](const std::string& words, const glm::dvec2& beside) {
    drawing.text(words, beside + drawing.letter() * glm::dvec2(0.5, -1), 0);
  };
  std::vector<glm::dvec3> ways;
  for (std::size_t k = 1; k < ruler.size(); ++k) {
    const glm::dvec3 &from = ruler[k - 1], &to = ruler[k];
    ways.push_back(grid.direction * (grid.spacing * (to - from)));
    if (!std::isfinite(view.magnification(from)) || !std::isfinite(view.magnification(to))) continue;
    const auto line = within(view.seen_at(from), view.seen_at(to), {shown.width, shown.height});
    if (!line) continue;
    const auto& [begin, end] = *line;
    drawing.line(begin, end, drawing.ink());
    write(fmt::format("{:.5g} {}", glm::length(ways.back()), unit.empty() ? "units" : unit),
          0.5 * (begin + end));
    if (ways.size() < 2) continue;
    const glm::dvec3 back = -ways[k - 2], &way = ways[k - 1];
    const double angle = std::atan2(glm::length(glm::cross(back, way)), glm::dot(back, way));
    write(fmt::format("{:.4g} deg", glm::degrees(angle)), begin);  // some fonts and libraries lack the sign
  }
  return std::move(drawing.drawn);
}

}  // namespace ringsplat::serve
