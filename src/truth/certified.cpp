#include "truth/certified.hpp"

#include <utility>

#include "ringsplat/base/error.hpp"
#include "truth/cubic.hpp"
#include "truth/enclosed_projection.hpp"
#include "truth/enclosed_tracer.hpp"

namespace ringsplat::truth {
namespace {

class Certifier : EnclosedTracer {
 public:
  Certifier(const Scene& scene, double width, int most_pieces)
      : EnclosedTracer(scene), width_(width), most_pieces_(most_pieces) {}

  PixelBounds operator()(Pixel pixel) const {
    return seen_by(pixel, [&](const LatticeRay& ray, const Way& way) { return composited(ray, way); });
  }

 private:
  EnclosedPiece composited(const LatticeRay& ray, const Way& way) const {
    Sight sight{.pieces_left = most_pieces_};
    for_passages(ray, way, [&](const Passage& passage) {
      pass(ray, passage, sight);
      return !hidden(sight);
    });
    sight.rest_open = hidden(sight);
    EnclosedPiece seen = composited(sight);
    while (!(seen.width() <= width_) && sharpen(sight, seen.width())) seen = composited(sight);
    return seen;
  }

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

  void pass(const LatticeRay& ray, const Passage& passage, Sight& sight) const {
    if (!(passage.length.lower() > 0) || beside_other_medium(ray, passage)) {
      sight.add({unknown(ray, passage), 0, 0, 1, true});
      return;
    }
    const auto values = cell_values(scene_, curve_, passage.shown);
    if (!values) return;
    const double extra = off_cell(passage);
    if (!curve_.visible(values->low - extra, values->high + extra)) return;
    sight.stretches.push_back(medium_of(ray, passage, *values, extra));
    const auto line = [&](double value) { return lines_.line_of(value); };
    if (line(values->low - extra) == line(values->high + extra))
      return look(sight.stretches.size() - 1, 0, 1, sight);
    const auto value_at = [&](double part) { return about(sight.stretches.back().value, part)[0].middle; };
    const std::vector<double> cuts = cuts_at_knots(cubic_along(0, 1, value_at), curve_.knots());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
      if (cuts[i] < cuts[i + 1]) look(sight.stretches.size() - 1, cuts[i], cuts[i + 1], sight);
  }

  /// `front`: what is let through before it.
  Piece piece_of(Sight& sight, std::size_t stretch, double from, double to, double front) const {
    const Part part(sight.stretches[stretch].length_of_passage, from, to);
    const CellMedium medium = about(sight.stretches[stretch], part.middle);
    const Extremes extremes = extremes_of(lines_, medium, part);
    EnclosedPiece known = between(extremes, part);
    --sight.pieces_left;
    constexpr double negligible = 0.003;
    if (front * known.width() > negligible * width_)
      if (const auto smooth = expanded(lines_, medium, extremes, part))
        known = smooth->width() < known.width() ? *smooth : of_mean(*known.mean_of, smooth->transmittance);
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
  EnclosedPiece unknown(const LatticeRay& ray, const Passage& passage) const {
    Extremes e;
    e.value = values_near(ray, passage).value_or(values_);
    e.of_curve = lines_.over(e.value);
    if (tints_.any()) std::fill_n(e.of_curve.begin(), EnclosedCurve::opacity, Interval(0, 1));
    if (scene_.shaded()) {
      e.light = EnclosedLight::any(shown_.material);
      e.light.scale = hull(e.light.scale, Interval(1));  // none, where the field is level
    }
    EnclosedPiece piece = between(e, Part(passage.length, 0, 1));
    piece.transmittance = {piece.transmittance.lower(), 1};
    return piece;
  }

  double width_;
  int most_pieces_;
};

}  // namespace

std::vector<PixelBounds> certified_bounds(const Scene& scene, std::span<const Pixel> pixels, double width,
                                          int most_pieces) {
  const Shown& shown = scene.frame.shown;
  if (shown.values) throw InputError("--values have no certified bounds", "leave out --values");
  if (shown.clip) return certified_bounds(cropped(scene), pixels, width, most_pieces);
  if (shown.mode != Mode::composite) return projected_bounds(scene, pixels);
  return along_rays(scene, pixels, Certifier(scene, width, most_pieces));
}

}  // namespace ringsplat::truth
