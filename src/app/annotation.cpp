#include "app/annotation.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "frame/frame_geometry.hpp"

namespace ringsplat::app {
namespace {

/// Lays out one picture's annotations.
class Sheet : public Drawing {
 public:
  Sheet(int width, int height, bool dark_ink)
      : Drawing(width, height, dark_ink), width_(width), height_(height) {}

  double margin() const { return 0.8 * letter(); }
  double width() const { return width_; }
  double height() const { return height_; }

  /// Keeps what was drawn since the last call, if it lies in the picture and on nothing that was kept.
  void keep_if_free() {
    const bool free = std::all_of(drawn.begin(), drawn.end(), [&](const Patch& p) {
      const bool inside = p.x >= 0 && p.y >= 0 && p.x + p.width <= width_ && p.y + p.height <= height_;
      return inside && std::none_of(kept_.begin(), kept_.end(), [&](const Patch& k) {
               return p.x < k.x + k.width && k.x < p.x + p.width && p.y < k.y + k.height &&
                      k.y < p.y + p.height;
             });
    });
    if (free) std::move(drawn.begin(), drawn.end(), std::back_inserter(kept_));
    drawn.clear();
  }
  Overlay take() { return std::move(kept_); }

 private:
  int width_, height_;
  Overlay kept_;
};

void add_letters(Sheet& sheet, const ViewTransform& view) {
  const double edge = sheet.margin(), middle_x = 0.5 * sheet.width(), middle_y = 0.5 * sheet.height();
  constexpr double size = 1.3;
  const double half_line = 0.5 * size * sheet.letter();
  sheet.text(patient_letters(-view.right), {edge, middle_y}, 0, size);
  sheet.text(patient_letters(view.right), {sheet.width() - edge, middle_y}, 1, size);
  sheet.text(patient_letters(view.up), {middle_x, edge + half_line}, 0.5, size);
  sheet.text(patient_letters(-view.up), {middle_x, sheet.height() - edge - half_line}, 0.5, size);
  sheet.keep_if_free();
}

/// The lattice's axes in the lower left corner, those that point away first.
void add_axes(Sheet& sheet, const ViewTransform& view, const Grid& grid) {
  constexpr std::array names{"x", "y", "z"};
  const std::array<glm::dvec3, 3> colours{glm::dvec3(1, 0.35, 0.3), glm::dvec3(0.35, 0.85, 0.3),
                                          glm::dvec3(0.4, 0.6, 1)};
  const double arm = 2.4 * sheet.letter(), inset = sheet.margin() + arm + 0.9 * sheet.letter();
  const glm::dvec2 origin{inset, sheet.height() - inset};
  std::array<int, 3> order{0, 1, 2};
  const auto nearness = [&](int k) { return glm::dot(grid.direction[k], view.to_viewer); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return nearness(a) < nearness(b); });
  for (const int k : order) {
    const glm::dvec2 along{glm::dot(grid.direction[k], view.right), -glm::dot(grid.direction[k], view.up)};
    const double seen = glm::length(along);
    constexpr double end_on = 0.15;  // such an axis is a dot, whose name would lie on the others
    sheet.line(origin, origin + arm * along, colours[std::size_t(k)], 0.18);
    if (seen > end_on)
      sheet.text(names[std::size_t(k)], origin + (arm + 0.65 * sheet.letter() / seen) * along, 0.5);
  }
  sheet.keep_if_free();
}

/// Pixels to the right of a step of one world unit along the picture's horizontal.
double pixels_per_unit(const Camera& camera, const ViewTransform& view) {
  if (!camera.matrix) return view.pixels_per_unit;
  const auto& m = *camera.matrix;
  return glm::dot(glm::dvec3(m[0], m[1], m[2]), view.right);
}

std::string length_text(double length, const VolumeNotes& notes, const Grid& grid) {
  if (notes.unit == "um") return fmt::format("{:g} µm", length);
  if (!notes.unit.empty()) return fmt::format("{:g} {}", length, excerpt(notes.unit, 12));
  const bool voxels = grid.spacing == glm::dvec3(1);
  return fmt::format("{:g} {}{}", length, voxels ? "voxel" : "unit", length == 1 ? "" : "s");
}

/// In the lower right corner.
void add_scale_bar(Sheet& sheet, double pixels_per_unit, const VolumeNotes& notes, const Grid& grid) {
  const double room = 0.25 * std::min(sheet.width(), 1.5 * sheet.height());
  if (!(pixels_per_unit > 0) || !std::isfinite(room / pixels_per_unit)) return;
  const double length = round_length(room / pixels_per_unit), pixels = length * pixels_per_unit;
  const std::string text = length_text(length, notes, grid);
  const double half_text = 0.32 * sheet.letter() * double(text.size());
  const double right = sheet.width() - sheet.margin() - std::max(0.0, half_text - 0.5 * pixels);
  const double y = sheet.height() - sheet.margin() - 0.25 * sheet.letter(), tick = 0.25 * sheet.letter();
  sheet.line({right - pixels, y}, {right, y}, sheet.ink(), 0.16);
  sheet.line({right - pixels, y - tick}, {right - pixels, y + tick}, sheet.ink());
  sheet.line({right, y - tick}, {right, y + tick}, sheet.ink());
  sheet.text(text, {right - 0.5 * pixels, y - 0.95 * sheet.letter()}, 0.5);
  sheet.keep_if_free();
}

/// The colours over the values, the highest above, within a frame.
void add_colours(Sheet& sheet, Patch patch, const TransferFunction& tf, const DataRange& span) {
  for (int y = 0; y < patch.height; ++y) {
    const double value = span.high - (y + 0.5) / patch.height * (span.high - span.low);
    const glm::dvec3 colour = linear_to_srgb(glm::clamp(tf.evaluate(value).colour, 0.0, 1.0));
    for (int x = 0; x < patch.width; ++x)
      for (const double part : {colour.x, colour.y, colour.z, 1.0}) patch.rgba.push_back(float(part));
  }
  const std::array<glm::dvec2, 4> corners{glm::dvec2(patch.x, patch.y),
                                          {patch.x + patch.width, patch.y},
                                          {patch.x + patch.width, patch.y + patch.height},
                                          {patch.x, patch.y + patch.height}};
  for (std::size_t k = 0; k < 4; ++k) sheet.line(corners[k], corners[(k + 1) % 4], sheet.ink(), 0.08);
  sheet.drawn.push_back(std::move(patch));
}

/// At the right side, from above down to `bottom`.
void add_colour_bar(Sheet& sheet, double bottom, const TransferFunction& tf, const DataRange& span,
                    const std::string& quantity) {
  const double letter = sheet.letter(), right = sheet.width() - sheet.margin();
  const double left = right - 0.9 * letter;
  double top = sheet.margin() + 0.5 * letter;
  if (!quantity.empty()) top += 1.5 * letter;
  const double height = bottom - top;
  const int most_ticks = static_cast<int>(height / (2.2 * letter));
  if (most_ticks < 2 || !std::isfinite(span.high - span.low)) return;
  // The least of 1, 2 or 5 times a power of ten that is not below `least`.
  const double least = (span.high - span.low) / most_ticks, below = round_length(least);
  const double step = below >= least ? below : round_length(2.51 * below);
  add_colours(sheet, {int(left), int(top), int(right) - int(left), int(bottom) - int(top), {}}, tf, span);
  if (!quantity.empty()) sheet.text(quantity, {right, sheet.margin() + 0.5 * letter}, 1);
  // Enough digits to tell neighbouring ticks apart.
  const double largest = std::max(std::abs(span.low), std::abs(span.high));
  const int digits = std::clamp(static_cast<int>(std::ceil(std::log10(largest / step))) + 1, 4, 15);
  const double first = std::ceil(span.low / step);
  for (int k = 0; k <= most_ticks && (first + k) * step <= span.high; ++k) {
    const double value = (first + k) * step;
    const double y = bottom - (value - span.low) / (span.high - span.low) * height;
    sheet.line({left - 0.35 * letter, y}, {left, y}, sheet.ink(), 0.08);
    sheet.text(fmt::format("{:.{}g}", plain(value), digits), {left - 0.6 * letter, y}, 1);
  }
  sheet.keep_if_free();
}

/// The channels' names from the upper right corner down, each before a piece of its colour.
void add_legend(Sheet& sheet, const std::vector<DrawnChannel>& channels) {
  const double letter = sheet.letter(), right = sheet.width() - sheet.margin();
  double y = sheet.margin() + 0.5 * letter;
  for (const DrawnChannel& channel : channels) {
    sheet.line({right - letter, y}, {right, y}, channel.colour, 0.6);
    sheet.text(excerpt(channel.name, 28), {right - 1.6 * letter, y}, 1);
    y += 1.5 * letter;
  }
  sheet.keep_if_free();
}

}  // namespace

Overlay colour_bar(int width, int height, const TransferFunction& tf, const DataRange& span,
                   const std::string& quantity) {
  Sheet sheet(width, height, false);
  add_colour_bar(sheet, 0.6 * height, tf, span, quantity);
  return sheet.take();
}

double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double digit : {10.0, 5.0, 2.0, 1.0})
    if (digit * power <= most * (1 + 1e-9)) return digit * power;
  return 0.5 * power;  // the logarithm was rounded up
}

std::string patient_letters(const glm::dvec3& direction) {
  constexpr const char *positive = "LPH", *negative = "RAF";
  std::array<int, 3> order{0, 1, 2};
  std::ranges::sort(order, [&](int a, int b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  constexpr double least = 0.25;  // of the whole length: 15 degrees
  std::string letters;
  for (const int k : order)
    if (std::abs(direction[k]) > least) letters += direction[k] > 0 ? positive[k] : negative[k];
  return letters;
}

std::optional<DataRange> visible_span(const TransferFunction& tf, const DataRange& range) {
  const auto& points = tf.opacities;
  std::optional<DataRange> span;
  const auto add = [&](double low, double high) {
    low = std::max(low, range.low);
    high = std::min(high, range.high);
    if (low > high) return;
    span = span ? DataRange{std::min(span->low, low), std::max(span->high, high)} : DataRange{low, high};
  };
  if (points.front().opacity > 0) add(range.low, points.front().value);
  for (std::size_t k = 0; k + 1 < points.size(); ++k)
    if (points[k].opacity > 0 || points[k + 1].opacity > 0) add(points[k].value, points[k + 1].value);
  if (points.back().opacity > 0) add(points.back().value, range.high);
  return span && span->low < span->high ? span : std::nullopt;
}

Annotation::Annotation(const Grid& grid, const VolumeNotes& notes,
                       const std::optional<glm::dvec3>& background, const std::optional<DataRange>& window,
                       std::vector<DrawnChannel> channels)
    : grid_(grid), notes_(notes), bar_(window), channels_(std::move(channels)) {
  constexpr double middle_grey = 0.18;
  dark_ink_ = background && glm::dot(*background, glm::dvec3(0.2126, 0.7152, 0.0722)) > middle_grey;
  static_cast<void>(text_mask("0", 12));
}

Overlay Annotation::overlay(const FrameSpec& spec, const ValueRange& range) const {
  const Shown& shown = spec.shown;
  const ViewTransform view = make_view(shown.camera, lattice_frame(grid_), shown.width, shown.height);
  Sheet sheet(shown.width, shown.height, dark_ink_);
  const bool patient = notes_.world == World::patient;
  if (patient)
    add_letters(sheet, view);
  else
    add_axes(sheet, view, grid_);
  if (!view.eye) add_scale_bar(sheet, pixels_per_unit(shown.camera, view), notes_, grid_);
  const double bottom = patient ? 0.5 * shown.height - 1.6 * sheet.letter() : 0.6 * shown.height;
  if (!channels_.empty()) {
    add_legend(sheet, channels_);
  } else if (shown.mode != Mode::surface) {
    const TransferFunction& tf = shown.transfer_function;
    // Integrals are no values of voxels: what is shown of them is the function's.
    const DataRange values =
        shown.mode == Mode::sum ? ends_of(tf) : bar_.value_or(DataRange{range.low, range.high});
    const bool hounsfield = notes_.quantity.empty() && notes_.modality == "CT" && shown.mode != Mode::sum;
    // As many letters as have room beside the picture's middle.
    const auto quantity = excerpt(hounsfield ? "HU" : notes_.quantity, 28);
    if (const auto span = visible_span(tf, values)) add_colour_bar(sheet, bottom, tf, *span, quantity);
  }
  return sheet.take();
}

}  // namespace ringsplat::app
