#include "decode/dicom/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string_view>
#include <utility>

#include "base/text.hpp"
#include "decode/dicom/schema.hpp"
#include "formats/limits.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* convert_hint = "convert it, for example with 'gdcmconv --raw'";

[[noreturn]] void fail(const DicomFile& file, const std::string& what, const std::string& hint) {
  throw InputError(fmt::format("{}: {}", file.path.string(), what), hint);
}

std::string described(DicomTag tag, DicomTag parent = {}) {
  const auto* const rule = find_dicom_rule(tag, parent);
  return fmt::format("{} {}", rule->name, to_string(tag));
}

int whole(const DicomFile& file, DicomTag tag, int otherwise, int least, int most) {
  const auto numbers = dicom_numbers(file, file.elements, tag);
  const double value = numbers.empty() ? otherwise : numbers[0];
  if (value != std::trunc(value) || value < least || value > most)
    fail(file, fmt::format("{} is {:g}", described(tag), value),
         fmt::format("it may be {} to {}", least, most));
  return int(value);
}

constexpr std::array<std::pair<std::string_view, DicomCodec>, 12> transfer_syntaxes{{
    {"", DicomCodec::none},
    {"1.2.840.10008.1.2", DicomCodec::none},
    {"1.2.840.10008.1.2.1", DicomCodec::none},
    {"1.2.840.10008.1.2.1.99", DicomCodec::none},
    {"1.2.840.10008.1.2.2", DicomCodec::none},
    {"1.2.840.10008.1.2.5", DicomCodec::rle},
    {"1.2.840.10008.1.2.4.50", DicomCodec::jpeg},
    {"1.2.840.10008.1.2.4.51", DicomCodec::jpeg},
    {"1.2.840.10008.1.2.4.57", DicomCodec::lossless_jpeg},
    {"1.2.840.10008.1.2.4.70", DicomCodec::lossless_jpeg},
    {"1.2.840.10008.1.2.4.80", DicomCodec::jpeg_ls},
    {"1.2.840.10008.1.2.4.81", DicomCodec::jpeg_ls},
}};

DicomCodec codec_of(const DicomFile& file) {
  const auto& uid = file.transfer_syntax;
  if (uid == "1.2.840.10008.1.2.4.90" || uid == "1.2.840.10008.1.2.4.91") return DicomCodec::jpeg_2000;
  for (const auto& [known, codec] : transfer_syntaxes)
    if (known == uid) return codec;
  fail(file, fmt::format("its pixels are encoded as '{}' (transfer syntax)", excerpt(uid)), convert_hint);
}

/// The most bytes of pixels that one compressed byte can hold, except in frames of a single value, which are
/// small.
std::uint64_t best_ratio(DicomCodec codec) {
  switch (codec) {
    case DicomCodec::none:
      return 1;
    case DicomCodec::rle:
      return 64;  // 128 bytes in two
    case DicomCodec::lossless_jpeg:
      return 16;  // a bit for a sample
    case DicomCodec::jpeg:
    case DicomCodec::jpeg_ls:
    case DicomCodec::jpeg_2000:
      break;
  }
  return 1000;
}

void check_amount(const DicomFile& file, const DicomShape& shape) {
  std::uint64_t stored = 0;
  for (const auto& fragment : file.pixels->fragments) stored += fragment.length;
  if (file.pixels->encapsulated != (shape.codec != DicomCodec::none))
    fail(file,
         fmt::format("its pixels are {}in fragments, as its transfer syntax '{}' has them not",
                     file.pixels->encapsulated ? "" : "not ", excerpt(file.transfer_syntax)),
         "write the file again");
  if (shape.codec == DicomCodec::none) return require_bytes(file.path, stored, 0, shape.bytes());
  constexpr std::uint64_t harmless = 32 << 20;
  if (shape.bytes() > harmless)
    require_compressed_bytes(file.path, stored, shape.bytes(), best_ratio(shape.codec));
}

void check_kind(const DicomFile& file) {
  if (file.elements.find(dicom::storage_class) == nullptr && file.storage_class.empty())
    fail(file, fmt::format("{} is missing", described(dicom::storage_class)), "take a complete DICOM file");
  const auto* const colours = file.elements.find(dicom::photometric);
  if (colours != nullptr && *colours != "MONOCHROME1" && *colours != "MONOCHROME2")
    fail(file, fmt::format("{} is '{}'", described(dicom::photometric), excerpt(*colours)),
         "only scalar volumes can be rendered: take a series of grey images");
}

/// Makes all allocated bits count. Values stay the same, except those of MONOCHROME1, which GDCM subtracts
/// from the highest value: refused.
void count_all_bits(const DicomFile& file, DicomShape& shape) {
  const auto* const colours = file.elements.find(dicom::photometric);
  if (colours != nullptr && *colours == "MONOCHROME1" && shape.bits_stored != shape.bits_allocated)
    fail(file,
         fmt::format("MONOCHROME1 of {} bits stored in {} cannot be read", shape.bits_stored,
                     shape.bits_allocated),
         convert_hint);
  shape.bits_stored = shape.bits_allocated;
  shape.high_bit = shape.bits_allocated - 1;
}

DicomShape read_shape(const DicomFile& file) {
  constexpr int most = std::numeric_limits<std::uint16_t>::max();
  DicomShape shape;
  shape.codec = codec_of(file);
  if (const int samples = whole(file, dicom::samples, 1, 0, most); samples != 1)
    fail(file, fmt::format("{} values per pixel", samples),
         "only scalar volumes can be rendered: take a series of grey images");
  shape.rows = whole(file, dicom::rows, 0, 0, most);
  shape.columns = whole(file, dicom::columns, 0, 0, most);
  if (shape.rows < 1 || shape.columns < 1)
    fail(file, fmt::format("{} rows and {} columns", shape.rows, shape.columns),
         "take an image that has pixels");
  shape.frames = whole(file, dicom::frames, 1, 1, std::numeric_limits<int>::max());
  shape.bits_allocated = whole(file, dicom::bits_allocated, 0, 0, most);
  if (shape.bits_allocated != 8 && shape.bits_allocated != 16 && shape.bits_allocated != 32)
    fail(file, fmt::format("{} bits allocated per pixel", shape.bits_allocated),
         "convert it to 8, 16 or 32 bits");
  if (shape.bits_allocated == 32 && (file.big_endian || shape.codec != DicomCodec::none))
    fail(file, fmt::format("32 bits per pixel as '{}' (transfer syntax)", excerpt(file.transfer_syntax)),
         convert_hint);
  shape.bits_stored = whole(file, dicom::bits_stored, shape.bits_allocated, 1, shape.bits_allocated);
  shape.high_bit =
      whole(file, dicom::high_bit, shape.bits_stored - 1, shape.bits_stored - 1, shape.bits_allocated - 1);
  shape.is_signed = whole(file, dicom::is_signed, 0, 0, 1) == 1;
  // GDCM ends the process when not all bits of a byte count.
  if (shape.bits_allocated == 8) count_all_bits(file, shape);
  return shape;
}

void check_spacing(const DicomFile& file, const DicomItem& item, DicomTag tag, DicomTag parent = {}) {
  for (const double value : dicom_numbers(file, item, tag, parent))
    if (!(value > 0))
      fail(file, fmt::format("{} has the value {:g}", described(tag, parent), value), "it must be positive");
}

/// GDCM silently replaces an orientation that it does not accept.
void check_orientation(const DicomFile& file, const DicomItem& item, DicomTag parent = {}) {
  const auto n = dicom_numbers(file, item, dicom::orientation, parent);
  if (n.empty()) return;
  const glm::dvec3 row(n[0], n[1], n[2]), column(n[3], n[4], n[5]);
  constexpr double tolerated = 1e-3;  // GDCM's own
  const double lengths = glm::length(row) * glm::length(column);
  if (!(std::abs(glm::dot(row, column)) < tolerated * lengths))
    fail(file,
         fmt::format("{} is not of two directions at a right angle", described(dicom::orientation, parent)),
         "correct the orientation");
}

/// Whole numbers up to this are exact, and no scanner has larger ones.
void check_rescale(const DicomFile& file, const DicomItem& item, DicomTag slope_tag, DicomTag parent = {}) {
  const auto slopes = dicom_numbers(file, item, slope_tag, parent);
  const auto intercepts =
      slope_tag == dicom::slope ? dicom_numbers(file, item, dicom::intercept, parent) : std::vector<double>{};
  const double slope = slopes.empty() ? 1 : slopes[0], intercept = intercepts.empty() ? 0 : intercepts[0];
  constexpr double largest = 1e9;
  if (slope == 0 || std::abs(slope) > largest || std::abs(intercept) > largest)
    fail(file,
         fmt::format("pixels are to be rescaled by {:g} and {:g} (slope and intercept)", slope, intercept),
         convert_hint);
}

constexpr ScalarType whole_types[] = {ScalarType::uint8, ScalarType::int8,   ScalarType::uint16,
                                      ScalarType::int16, ScalarType::uint32, ScalarType::int32};

/// Place among whole_types; behind them for others.
int rank_of(ScalarType type) {
  return int(std::find(std::begin(whole_types), std::end(whole_types), type) - std::begin(whole_types));
}

/// The narrowest of them for all that the bits stored can be, unsigned unless that may be negative; float64
/// where there is none.
ScalarType narrowest_type(const DicomShape& shape, const Rescale& rescale) {
  const double half = std::ldexp(1.0, shape.bits_stored - 1);
  const double first = (shape.is_signed ? -half : 0) * rescale.slope + rescale.intercept;
  const double last = (shape.is_signed ? half - 1 : 2 * half - 1) * rescale.slope + rescale.intercept;
  const auto fits = [low = std::min(first, last), high = std::max(first, last)](ScalarType type) {
    return visit_type(type, [&](auto zero) {
      using Limits = std::numeric_limits<decltype(zero)>;
      return low >= double(Limits::lowest()) && high <= double(Limits::max()) &&
             (low < 0) == Limits::is_signed;
    });
  };
  const auto* const found = std::find_if(std::begin(whole_types), std::end(whole_types), fits);
  return found == std::end(whole_types) ? ScalarType::float64 : *found;
}

/// The first item of a functional group: that of all frames, or that of the first frame.
const DicomItem* group(const DicomFile& file, DicomTag sequence) {
  for (const auto groups : {dicom::shared_groups, dicom::frame_groups})
    if (const auto* const first = file.elements.first_item(groups))
      if (const auto* const found = first->first_item(sequence)) return found;
  return nullptr;
}

void check_frame_groups(const DicomFile& file) {
  std::optional<std::array<double, 2>> rescale;
  for (const auto groups : {dicom::shared_groups, dicom::frame_groups}) {
    const auto found = file.elements.sequences.find(groups);
    if (found == file.elements.sequences.end()) continue;
    for (const auto& item : found->second) {
      if (const auto* const plane = item.first_item(dicom::plane_position))
        dicom_numbers(file, *plane, dicom::position, dicom::plane_position);
      if (const auto* const plane = item.first_item(dicom::plane_orientation))
        check_orientation(file, *plane, dicom::plane_orientation);
      if (const auto* const measures = item.first_item(dicom::pixel_measures)) {
        check_spacing(file, *measures, dicom::pixel_spacing, dicom::pixel_measures);
        dicom_numbers(file, *measures, dicom::slice_distance, dicom::pixel_measures);
      }
      const auto* const pixels = item.first_item(dicom::pixel_transformation);
      if (pixels == nullptr) continue;
      check_rescale(file, *pixels, dicom::slope, dicom::pixel_transformation);
      const auto slope = dicom_numbers(file, *pixels, dicom::slope, dicom::pixel_transformation);
      const auto intercept = dicom_numbers(file, *pixels, dicom::intercept, dicom::pixel_transformation);
      if (slope.empty() || intercept.empty()) continue;
      if (rescale && *rescale != std::array{slope[0], intercept[0]})
        fail(file, "its frames have different rescaling (slope and intercept)",
             "give the frames as a series of files");
      rescale = {slope[0], intercept[0]};
    }
  }
  const auto* const plane = group(file, dicom::plane_orientation);
  const bool oriented = (plane != nullptr && plane->find(dicom::orientation) != nullptr) ||
                        file.elements.find(dicom::orientation) != nullptr;
  if (group(file, dicom::pixel_measures) != nullptr && !oriented)
    fail(file, "its frames have a pixel spacing and no orientation", "take a complete DICOM file");
}

void check_geometry(const DicomFile& file, const DicomShape& shape) {
  const auto& root = file.elements;
  for (const auto tag : {dicom::pixel_spacing, dicom::imager_spacing, dicom::scanned_spacing,
                         dicom::plane_spacing, dicom::aspect})
    check_spacing(file, root, tag);
  dicom_numbers(file, root, dicom::slice_distance);
  dicom_numbers(file, root, dicom::position);
  check_orientation(file, root);
  if (const auto* const item = root.first_item(dicom::detectors)) {
    dicom_numbers(file, *item, dicom::position, dicom::detectors);
    check_orientation(file, *item, dicom::detectors);
  }
  if (const auto* const item = root.first_item(dicom::regions))
    for (const auto tag : {dicom::delta_x, dicom::delta_y}) check_spacing(file, *item, tag, dicom::regions);
  const auto offsets = dicom_numbers(file, root, dicom::frame_offsets);
  if (!offsets.empty() && offsets.size() != std::size_t(shape.frames))
    fail(file,
         fmt::format("{} has {} numbers for {} frames", described(dicom::frame_offsets), offsets.size(),
                     shape.frames),
         "take a complete DICOM file");
  check_frame_groups(file);
}

}  // namespace

std::vector<double> dicom_numbers(const DicomFile& file, const DicomItem& item, DicomTag tag,
                                  DicomTag parent) {
  const auto* const value = item.find(tag);
  if (value == nullptr) return {};
  const auto* const rule = find_dicom_rule(tag, parent);
  std::vector<double> numbers;
  const auto add = [&](const std::optional<double>& number, const std::string& shown) {
    if (!number || !std::isfinite(*number))
      fail(file, fmt::format("{} is '{}'", described(tag, parent), excerpt(shown)), "it must be a number");
    numbers.push_back(*number);
  };
  if (rule->vr == "US" || rule->vr == "FD") {
    double wide = 0;
    const bool is_short = rule->vr == "US";
    if (value->size() != (is_short ? sizeof(std::uint16_t) : sizeof wide))
      fail(file, fmt::format("{} has {} bytes", described(tag, parent), value->size()),
           "copy the file again");
    if (is_short)
      wide = static_cast<unsigned char>((*value)[0]) + 256 * static_cast<unsigned char>((*value)[1]);
    else
      std::memcpy(&wide, value->data(), sizeof wide);
    add(wide, "not finite");
    return numbers;
  }
  for (std::size_t at = 0; at <= value->size();) {
    const auto end = std::min(value->find('\\', at), value->size());
    const auto word = trimmed(value->substr(at, end - at));
    add(number_in<double>(word), word);
    at = end + 1;
  }
  if (rule->count != 0 && numbers.size() != std::size_t(rule->count))
    fail(file, fmt::format("{} has {} numbers", described(tag, parent), numbers.size()),
         fmt::format("it must have {}", rule->count));
  return numbers;
}

ScalarType stored_type(const DicomShape& shape) {
  if (shape.bits_allocated == 8) return shape.is_signed ? ScalarType::int8 : ScalarType::uint8;
  if (shape.bits_allocated == 16) return shape.is_signed ? ScalarType::int16 : ScalarType::uint16;
  return shape.is_signed ? ScalarType::int32 : ScalarType::uint32;
}

ScalarType rescaled_type(const DicomFile& file, DicomShape& shape, const Rescale& rescale) {
  const ScalarType stored = stored_type(shape);
  const auto whole_number = [](double value) { return value == std::trunc(value); };
  if (rescale.slope == 1 && rescale.intercept == 0) return stored;
  if (!whole_number(rescale.slope) || !whole_number(rescale.intercept)) return ScalarType::float64;
  const ScalarType narrowest = narrowest_type(shape, rescale);
  const bool raw = shape.codec == DicomCodec::none || shape.codec == DicomCodec::rle;
  if (rank_of(narrowest) >= rank_of(stored) || !raw) return narrowest;
  count_all_bits(file, shape);
  return narrowest_type(shape, rescale);
}

DicomShape check_dicom(const DicomFile& file) {
  check_kind(file);
  auto shape = read_shape(file);
  check_amount(file, shape);
  check_geometry(file, shape);
  check_rescale(file, file.elements, dicom::slope);
  if (const auto* const item = file.elements.first_item(dicom::xray_acquisition))
    check_rescale(file, *item, dicom::slope, dicom::xray_acquisition);
  if (file.elements.find(dicom::dose_scale) != nullptr) check_rescale(file, file.elements, dicom::dose_scale);
  return shape;
}

}  // namespace ringsplat::detail
