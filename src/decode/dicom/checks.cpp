#include "decode/dicom/checks.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>

#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* convert_hint = "convert it, for example with 'gdcmconv --raw'";

std::string described(DicomTag tag) { return fmt::format("{} {}", dicom_entry(tag).name, to_string(tag)); }

int whole(const DicomFile& file, DicomTag tag, int otherwise, int least, int most) {
  const auto numbers = checked_numbers(file, file.elements, tag);
  const double value = numbers.empty() ? otherwise : numbers[0];
  if (value != std::trunc(value) || value < least || value > most)
    refuse(file.path, fmt::format("it may be {} to {}", least, most), "{} is {:g}", described(tag), value);
  return int(value);
}

/// Transfer syntaxes by what follows the root that all have.
constexpr std::pair<const char*, DicomCodec> transfer_syntaxes[] = {
    {".1 .1.99 .2", DicomCodec::none},
    {".5", DicomCodec::rle},
    {".4.50 .4.51 .4.57 .4.70 .4.80 .4.81", DicomCodec::jpeg},
    {".4.90 .4.91", DicomCodec::jpeg_2000}};

DicomCodec codec_of(const DicomFile& file) {
  const std::string root = "1.2.840.10008.1.2";
  if (file.transfer_syntax.empty() || file.transfer_syntax == root) return DicomCodec::none;
  for (const auto& [ends, codec] : transfer_syntaxes)
    for (const auto& end : words_of(ends))
      if (file.transfer_syntax == root + end) return codec;
  refuse(file.path, convert_hint, "its pixels are encoded as '{}' (transfer syntax)",
         excerpt(file.transfer_syntax));
}

void check_amount(const DicomFile& file, const DicomShape& shape) {
  std::uint64_t stored = 0;
  for (const auto& fragment : file.pixels->fragments) stored += fragment.size();
  if (file.pixels->encapsulated != (shape.codec != DicomCodec::none))
    refuse(file.path, "write the file again",
           "its pixels are {}in fragments, as its transfer syntax '{}' has them not",
           file.pixels->encapsulated ? "" : "not ", excerpt(file.transfer_syntax));
  if (shape.codec == DicomCodec::none) return require_bytes(file.path, stored, 0, shape.bytes());
  constexpr std::uint64_t harmless = 32 << 20;  // frames of a single value may be of any ratio
  if (shape.bytes() > harmless) require_compressed_bytes(file.path, stored, shape.bytes(), any_best_ratio);
}

void check_kind(const DicomFile& file) {
  if (file.elements.text(dicom::storage_class).empty() && file.storage_class.empty())
    refuse(file.path, "take a complete DICOM file", "{} is missing", described(dicom::storage_class));
  const auto colours = file.elements.text(dicom::photometric);
  if (!colours.empty() && colours != "MONOCHROME1" && colours != "MONOCHROME2")
    refuse(file.path, "only scalar volumes can be rendered: take a series of grey images", "{} is '{}'",
           described(dicom::photometric), excerpt(colours));
}

/// Makes all allocated bits count. Values stay the same, except those of MONOCHROME1, which GDCM subtracts
/// from the highest value: refused.
void count_all_bits(const DicomFile& file, DicomShape& shape) {
  if (file.elements.text(dicom::photometric) == "MONOCHROME1" && shape.bits_stored != shape.bits_allocated)
    refuse(file.path, convert_hint, "MONOCHROME1 of {} bits stored in {} cannot be read", shape.bits_stored,
           shape.bits_allocated);
  shape.bits_stored = shape.bits_allocated;
  shape.high_bit = shape.bits_allocated - 1;
}

DicomShape read_shape(const DicomFile& file) {
  constexpr int most = std::numeric_limits<std::uint16_t>::max();
  DicomShape shape;
  shape.codec = codec_of(file);
  if (const int samples = whole(file, dicom::samples, 1, 0, most); samples != 1)
    refuse(file.path, "only scalar volumes can be rendered: take a series of grey images",
           "{} values per pixel", samples);
  shape.rows = whole(file, dicom::rows, 0, 0, most);
  shape.columns = whole(file, dicom::columns, 0, 0, most);
  if (shape.rows < 1 || shape.columns < 1)
    refuse(file.path, "take an image that has pixels", "{} rows and {} columns", shape.rows, shape.columns);
  shape.frames = whole(file, dicom::frames, 1, 1, std::numeric_limits<int>::max());
  shape.bits_allocated = whole(file, dicom::bits_allocated, 0, 0, most);
  if (shape.bits_allocated != 8 && shape.bits_allocated != 16 && shape.bits_allocated != 32)
    refuse(file.path, "convert it to 8, 16 or 32 bits", "{} bits allocated per pixel", shape.bits_allocated);
  if (shape.bits_allocated == 32 && (file.big_endian() || shape.codec != DicomCodec::none))
    refuse(file.path, convert_hint, "32 bits per pixel as '{}' (transfer syntax)",
           excerpt(file.transfer_syntax));
  shape.bits_stored = whole(file, dicom::bits_stored, shape.bits_allocated, 1, shape.bits_allocated);
  shape.high_bit =
      whole(file, dicom::high_bit, shape.bits_stored - 1, shape.bits_stored - 1, shape.bits_allocated - 1);
  shape.is_signed = whole(file, dicom::is_signed, 0, 0, 1) == 1;
  // GDCM ends the process when not all bits of a byte count.
  if (shape.bits_allocated == 8) count_all_bits(file, shape);
  return shape;
}

/// GDCM silently replaces an orientation that it does not accept.
void check_orientation(const DicomFile& file, const DicomItem& item) {
  const auto n = checked_numbers(file, item, dicom::orientation);
  if (n.empty()) return;
  const glm::dvec3 row = glm::make_vec3(n.data()), column = glm::make_vec3(n.data() + 3);
  constexpr double tolerated = 1e-3;  // GDCM's own
  const double lengths = glm::length(row) * glm::length(column);
  if (!(std::abs(glm::dot(row, column)) < tolerated * lengths))
    refuse(file.path, "correct the orientation", "{} is not of two directions at a right angle",
           described(dicom::orientation));
}

/// Whole numbers up to this are exact, and no scanner has larger ones.
Rescale check_rescale(const DicomFile& file, const DicomItem& item, DicomTag slope_tag) {
  const auto slope = checked_numbers(file, item, slope_tag);
  auto intercept = checked_numbers(file, item, dicom::intercept);
  if (slope_tag != dicom::slope) intercept.clear();
  const Rescale rescale{slope.empty() ? 1 : slope[0], intercept.empty() ? 0 : intercept[0]};
  constexpr double largest = 1e9;
  if (rescale.slope == 0 || std::abs(rescale.slope) > largest || std::abs(rescale.intercept) > largest)
    refuse(file.path, convert_hint, "pixels are to be rescaled by {:g} and {:g} (slope and intercept)",
           rescale.slope, rescale.intercept);
  return rescale;
}

constexpr ScalarType whole_types[] = {ScalarType::uint8, ScalarType::int8,   ScalarType::uint16,
                                      ScalarType::int16, ScalarType::uint32, ScalarType::int32};

/// Place among whole_types; behind them for others.
int rank_of(ScalarType type) { return int(std::ranges::find(whole_types, type) - std::begin(whole_types)); }

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

/// The numbers of a data set and of what it holds: of each frame's item, of other sequences' first ones.
void check_numbers(const DicomFile& file, const DicomItem& item) {
  for (const auto& tag : {dicom::pixel_spacing, dicom::imager_spacing, dicom::scanned_spacing,
                          dicom::plane_spacing, dicom::aspect, dicom::delta_x, dicom::delta_y})
    for (const double value : checked_numbers(file, item, tag))
      if (!(value > 0))
        refuse(file.path, "it must be positive", "{} has the value {:g}", described(tag), value);
  checked_numbers(file, item, dicom::slice_distance);
  checked_numbers(file, item, dicom::position);
  check_orientation(file, item);
  check_rescale(file, item, dicom::slope);
  check_rescale(file, item, dicom::dose_scale);
  for (const auto& [sequence, items] : item.sequences)
    for (std::size_t i = 0; i < items.size() && (i == 0 || sequence == dicom::frame_groups); ++i)
      check_numbers(file, items[i]);
}

/// GDCM takes one rescaling for all frames, and an orientation for granted.
void check_frame_groups(const DicomFile& file) {
  std::optional<Rescale> rescale;
  bool measured = false, oriented = !file.elements.text(dicom::orientation).empty();
  for (const auto& groups : {dicom::shared_groups, dicom::frame_groups})
    for (const auto& item : file.elements.items(groups)) {
      if (const auto* const plane = item.first_item(dicom::plane_orientation))
        oriented |= !plane->text(dicom::orientation).empty();
      measured |= item.first_item(dicom::pixel_measures) != nullptr;
      const auto* const pixels = item.first_item(dicom::pixel_transformation);
      if (!pixels || pixels->text(dicom::slope).empty() || pixels->text(dicom::intercept).empty()) continue;
      const auto found = check_rescale(file, *pixels, dicom::slope);
      if (rescale && (rescale->slope != found.slope || rescale->intercept != found.intercept))
        refuse(file.path, "give the frames as a series of files",
               "its frames have different rescaling (slope and intercept)");
      rescale = found;
    }
  if (measured && !oriented)
    refuse(file.path, "take a complete DICOM file", "its frames have a pixel spacing and no orientation");
}

}  // namespace

std::vector<double> checked_numbers(const DicomFile& file, const DicomItem& item, DicomTag tag) {
  auto numbers = item.numbers(tag);
  for (const double number : numbers)
    if (std::isnan(number))
      refuse(file.path, "it must be a number", "{} is '{}'", described(tag), excerpt(item.text(tag)));
  const auto count = dicom_entry(tag).count;
  if (count != 0 && !numbers.empty() && numbers.size() != count)
    refuse(file.path, fmt::format("it must have {}", count), "{} has {} numbers", described(tag),
           numbers.size());
  return numbers;
}

ScalarType stored_type(const DicomShape& shape) {
  return scalar_type_from(fmt::format("{}int{}", shape.is_signed ? "" : "u", shape.bits_allocated));
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
  check_numbers(file, file.elements);
  check_frame_groups(file);
  const auto offsets = checked_numbers(file, file.elements, dicom::frame_offsets);
  if (!offsets.empty() && offsets.size() != std::size_t(shape.frames))
    refuse(file.path, "take a complete DICOM file", "{} has {} numbers for {} frames",
           described(dicom::frame_offsets), offsets.size(), shape.frames);
  return shape;
}

}  // namespace ringsplat::detail
