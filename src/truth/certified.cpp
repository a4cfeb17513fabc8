#include "truth/certified.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "truth/cubic.hpp"
#include "truth/enclosed_piece.hpp"
#include "truth/passage.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

class Certifier : Tracer {
 public:
  Certifier(const Scene& scene, double width, int most_pieces)
      : Tracer(scene),
        width_(width),
        most_pieces_(most_pieces),
        lines_(curve_),
        gradients_(scene),
        grown_(scene, resized(tube)),
        shrunk_(scene, resized(-tube)) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double v : scene.values) {
      const double finite = curve_.bounded(v);
      if (std::isnan(finite)) continue;
      low = std::min(low, finite);
      high = std::max(high, finite);
    }
    if (low <= high) values_ = {low, high};
    const glm::dmat3 to_world = against_gradient(scene.grid.direction, scene.grid.spacing);
    constexpr double largest_difference = 2;  // of values that Gradients scales to at most 1
    for (int k = 0; k < 3; ++k)
      for (int row = 0; row < 3; ++row) steepest_ += 2 * largest_difference * std::abs(to_world[k][row]);
  }

  PixelBounds along(Pixel pixel) const {
    const LatticeRay ray = rays_.through(pixel);
    if (!(ray.enter < ray.leave))
      return grown_.hit(pixel) ? PixelBounds{} : PixelBounds{Rgba(0.0), Rgba(0.0)};
    Sight sight{.pieces_left = most_pieces_};
    const std::vector<Uncertain> cuts = uncertain_cuts(scene_, ray);
    for (std::size_t i = 0; i + 1 < cuts.size() && !hidden(sight); ++i)
      if (cuts[i].at < cuts[i + 1].at) pass(ray, passage_between(scene_, ray, cuts[i], cuts[i + 1]), sight);
    sight.rest_open = hidden(sight);
    EnclosedPiece seen = composited(sight);
    while (!(seen.width() <= width_) && sharpen(sight, seen.width())) seen = composited(sight);
    PixelBounds bounds = bounds_of(seen);
    if (!shrunk_.hit(pixel)) bounds.low = Rgba(0.0);
    return bounds;
  }

 private:
  /// Between two places of a passage, in parts of it.
  struct Piece {
    EnclosedPiece known;
    std::size_t stretch;
    double from, to;
    bool settled;  ///< cannot be known more exactly
  };
  /// What was seen of a ray from the front.
  struct Sight {
    std::vector<CellMedium> stretches = {};
    std::vector<Piece> pieces = {};
    Interval transmittance = 1;
    bool rest_open = false;  ///< whatever is behind the pieces
    int pieces_left;
    void add(const Piece& piece) {
      transmittance = clamped(transmittance * piece.known.transmittance, 0, 1);
      pieces.push_back(piece);
    }
  };

  /// Whether what is behind may be left open.
  bool hidden(const Sight& sight) const {
    constexpr double share = 0.125;
    return sight.transmittance.upper() < share * width_;
  }

  /// From the back to the front.
  EnclosedPiece composited(const Sight& sight) const {
    EnclosedPiece seen;
    const Interval any{0, 1};
    if (sight.rest_open) seen = {{any, any, any}, any};
    for (std::size_t i = sight.pieces.size(); i-- > 0;) seen = behind(sight.pieces[i].known, seen);
    return seen;
  }

  LatticeBox resized(double by) const {
    const LatticeBox box = voxel_faces(scene_);
    return {box.low - by, box.high + by};
  }

  static PixelBounds bounds_of(const EnclosedPiece& seen) {
    const auto& [red, green, blue] = seen.colour;
    const Interval channels[] = {red, green, blue, clamped(1.0 - seen.transmittance, 0, 1)};
    PixelBounds bounds;
    for (int c = 0; c < 4; ++c) {
      bounds.low[c] = channels[c].lower();
      bounds.high[c] = channels[c].upper();
      // Whatever was no number proves nothing.
      if (!(bounds.low[c] <= bounds.high[c])) return {};
    }
    return bounds;
  }

  void pass(const LatticeRay& ray, const Passage& passage, Sight& sight) const {
    if (!(passage.length.lower() > 0) || beside_other_medium(ray, passage)) {
      sight.add({unknown(passage), 0, 0, 1, true});
      return;
    }
    const auto values = cell_values(scene_, curve_, passage.shown);
    if (!values) return;
    // How far the field is from the cell's own: each axis changes it by less than the values' range a voxel.
    const double extra = passage.beside > 0 ? 3 * passage.beside * width(values_) : 0;
    if (!curve_.visible(values->low - extra, values->high + extra)) return;
    sight.stretches.push_back(medium_of(ray, passage, *values, extra));
    const auto line = [&](double value) { return lines_.line_of(value); };
    if (line(values->low - extra) == line(values->high + extra))
      return look(sight.stretches.size() - 1, 0, 1, sight);
    const auto value_at = [&](double part) {
      return median(series_of<0>(sight.stretches.back().value, Interval(part), 0)[0]);
    };
    const std::vector<double> cuts = cuts_at_knots(cubic_along(0, 1, value_at), curve_.knots());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
      if (cuts[i] < cuts[i + 1]) look(sight.stretches.size() - 1, cuts[i], cuts[i + 1], sight);
  }

  /// Where a ray runs along a face, or along an edge, what is on the other side counts as well.
  bool beside_other_medium(const LatticeRay& ray, const Passage& passage) const {
    if (!scene_.nearest()) return passage.beside > 0 && !values_around(passage);
    for (int k = 0; k < 3; ++k) {
      if (!may_run_along_faces(ray.step[k])) continue;
      for (const double s : {passage.enter, passage.leave}) {
        constexpr double towards_greater = 1e-9;  // as nearest_voxel() rounds
        const double place = ray.at(s)[k] + 0.5 + towards_greater - passage.shown.low[k];
        if (!(place > tube && place < 1 - tube)) return true;
      }
    }
    return false;
  }

  Polynomial value_of(const CellValues& values, const Passage& passage) const {
    if (values.low == values.high) return {Interval(values.low), 0.0, 0.0, 0.0};
    Corners<Interval> corners;
    std::copy(values.corners.begin(), values.corners.end(), corners.begin());
    return along_passage(corners, passage);
  }

  CellMedium medium_of(const LatticeRay& ray, const Passage& passage, const CellValues& values,
                       double extra) const {
    CellMedium medium{value_of(values, passage), std::nullopt, passage.length};
    if (extra > 0) medium.value[0] += within(extra);
    if (!scene_.shaded()) return medium;
    const Corners<glm::dvec3> normals = cell_normals(gradients_, passage.cell);
    const bool level = std::ranges::all_of(normals, [](const glm::dvec3& n) { return n == glm::dvec3(0.0); });
    if (level && passage.beside == 0) return medium;
    std::array<Polynomial, 3> normal;
    for (int k = 0; k < 3; ++k) {
      Corners<Interval> corners;
      for (std::size_t c = 0; c < 8; ++c) {
        constexpr double rounding = 1e-14;
        corners[c] = normals[c][k] + within(rounding * glm::length(normals[c]));
      }
      normal[std::size_t(k)] = along_passage(corners, passage);
      normal[std::size_t(k)][0] += within(3 * passage.beside * steepest_);
    }
    medium.light.emplace(scene_.frame.shown.material, phong_.to_light(), ray.to_viewer, normal);
    return medium;
  }

  /// The values of all voxels that a ray beside the passage's cell may see; nothing where one is no number.
  std::optional<Interval> values_around(const Passage& passage) const {
    Interval all = Interval::empty();
    const glm::ivec3 first = glm::max(passage.cell.low - 1, 0),
                     last = glm::min(passage.cell.high + 1, scene_.grid.dims - 1);
    bool complete = true;
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
          const double v = curve_.bounded(scene_.values[scene_.index({x, y, z})]);
          complete = complete && !std::isnan(v);
          if (!std::isnan(v)) all = hull(all, Interval(v));
        }
    return complete ? std::optional(all) : std::nullopt;
  }

  /// `front`: what is let through before it.
  Piece piece_of(Sight& sight, std::size_t stretch, double from, double to, double front) const {
    const CellMedium& medium = sight.stretches[stretch];
    const Part part(medium.length_of_passage, from, to);
    const Extremes extremes = extremes_of(lines_, medium, part);
    EnclosedPiece known = between(extremes, part);
    --sight.pieces_left;
    constexpr double negligible = 0.003;
    if (front * known.width() > negligible * width_) {
      const auto smooth = expanded(lines_, medium, extremes, part);
      if (smooth && smooth->width() < known.width()) known = *smooth;
    }
    constexpr double shortest = 1e-8;  // of a passage: values are not known more exactly
    return {known, stretch, from, to, to - from < shortest};
  }

  /// Adds a piece, or its halves where it has much of the wanted width by itself.
  void look(std::size_t stretch, double from, double to, Sight& sight) const {
    const double front = sight.transmittance.upper(), middle = 0.5 * (from + to);
    const Piece piece = piece_of(sight, stretch, from, to, front);
    constexpr double much = 0.3;
    if (piece.settled || sight.pieces_left <= 0 || front * piece.known.width() <= much * width_) {
      sight.add(piece);
      return;
    }
    look(stretch, from, middle, sight);
    if (hidden(sight)) return;
    look(stretch, middle, to, sight);
  }

  /// Halves the pieces that are widest as seen: so many that what the others leave open is within what is
  /// wanted. Returns false when nothing would help.
  bool sharpen(Sight& sight, double width_seen) const {
    std::vector<double> widths, open;
    double front = 1, sum = 0, settled = 0;
    for (const Piece& piece : sight.pieces) {
      const double width = widths.emplace_back(front * piece.known.width());
      sum += width;
      piece.settled ? settled += width : open.emplace_back(width);
      front *= piece.known.transmittance.upper();
    }
    std::sort(open.begin(), open.end());
    // Widths add up to more than what is seen: colours behind are like those in front.
    constexpr double aim = 0.9, least_share = 0.125;
    double left = std::max(aim * width_ / width_seen * sum - settled, least_share * width_);
    const auto first =
        std::find_if(open.begin(), open.end(), [&](double width) { return (left -= width) < 0; });
    if (first == open.end() || sight.pieces_left <= 0) return false;
    const std::vector<Piece> before = std::exchange(sight.pieces, {});
    sight.transmittance = 1;
    for (std::size_t k = 0; k < before.size(); ++k) {
      const auto& [known, stretch, from, to, cannot] = before[k];
      if (cannot || widths[k] < *first || sight.pieces_left <= 0) {
        sight.add(before[k]);
        continue;
      }
      const double middle = 0.5 * (from + to);
      sight.add(piece_of(sight, stretch, from, middle, sight.transmittance.upper()));
      sight.add(piece_of(sight, stretch, middle, to, sight.transmittance.upper()));
    }
    return true;
  }

  /// A passage of which only what is near it is known.
  EnclosedPiece unknown(const Passage& passage) const {
    Extremes e;
    const auto around = values_around(passage);
    e.value = around.value_or(values_);
    const auto values = cell_values(scene_, curve_, passage.cell);
    if (values && around && !scene_.nearest()) {
      constexpr double voxels = 1e-6;  // many times what a passage of no sure length crosses
      e.value = series_of<0>(value_of(*values, passage), Interval(0.5), 0.5)[0] +
                within(3 * voxels * width(values_));
    }
    e.of_curve = lines_.over(e.value);
    if (scene_.shaded()) {
      e.light = EnclosedLight::any(scene_.frame.shown.material);
      e.light.scale = hull(e.light.scale, Interval(1));  // none, where the field is level
    }
    EnclosedPiece piece = between(e, Part(passage.length, 0, 1));
    piece.transmittance = {piece.transmittance.lower(), 1};
    return piece;
  }

  double width_;
  int most_pieces_;
  EnclosedCurve lines_;
  Gradients gradients_;
  Rays grown_, shrunk_;
  Interval values_ = 0;  ///< of all voxels that are numbers
  double steepest_ = 0;  ///< how much a normal's component changes from voxel to voxel, at most
};

}  // namespace

std::vector<PixelBounds> certified_bounds(const Scene& scene, std::span<const Pixel> pixels, double width,
                                          int most_pieces) {
  if (scene.frame.shown.mode != Mode::composite)
    throw InputError("only --mode composite has certified bounds",
                     "measure other modes by --error field: they are exact but for float32");
  const Shown& shown = scene.frame.shown;
  if (!shown.clip_planes.empty() || shown.edges || !shown.tints.empty())
    throw InputError("certified bounds know no --clip-plane, --tf2d or --mask-as",
                     "measure by --error field");
  if (scene.frame.shown.clip) return certified_bounds(cropped(scene), pixels, width, most_pieces);
  const Certifier certifier(scene, width, most_pieces);
  return along_rays(scene, pixels, [&](Pixel pixel) { return certifier.along(pixel); });
}

}  // namespace ringsplat::truth
