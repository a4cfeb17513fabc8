#pragma once
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ringsplat::detail {

struct DicomTag {
  std::uint16_t group = 0, element = 0;
  auto operator<=>(const DicomTag&) const = default;
};
std::string to_string(DicomTag tag);  ///< "(0028,0010)"

namespace dicom {
inline constexpr DicomTag storage_class{0x0008, 0x0016}, instance{0x0008, 0x0018}, modality{0x0008, 0x0060},
    series{0x0020, 0x000E}, number{0x0020, 0x0013}, description{0x0008, 0x103E},
    series_number{0x0020, 0x0011};
inline constexpr DicomTag time_position{0x0020, 0x0100}, b_value{0x0018, 0x9087}, echo_time{0x0018, 0x0081},
    trigger_time{0x0018, 0x1060}, acquisition{0x0020, 0x0012}, acquisition_time{0x0008, 0x0032};
inline constexpr DicomTag position{0x0020, 0x0032}, orientation{0x0020, 0x0037};
inline constexpr DicomTag slice_distance{0x0018, 0x0088}, imager_spacing{0x0018, 0x1164},
    scanned_spacing{0x0018, 0x2010}, pixel_spacing{0x0028, 0x0030}, aspect{0x0028, 0x0034},
    plane_spacing{0x3002, 0x0011}, frame_offsets{0x3004, 0x000C}, dose_scale{0x3004, 0x000E};
inline constexpr DicomTag samples{0x0028, 0x0002}, photometric{0x0028, 0x0004}, frames{0x0028, 0x0008},
    rows{0x0028, 0x0010}, columns{0x0028, 0x0011}, bits_allocated{0x0028, 0x0100},
    bits_stored{0x0028, 0x0101}, high_bit{0x0028, 0x0102}, is_signed{0x0028, 0x0103};
inline constexpr DicomTag intercept{0x0028, 0x1052}, slope{0x0028, 0x1053}, rescale_type{0x0028, 0x1054};
inline constexpr DicomTag regions{0x0018, 0x6011}, delta_x{0x0018, 0x602C}, delta_y{0x0018, 0x602E};
inline constexpr DicomTag xray_acquisition{0x0018, 0x9530}, detectors{0x0054, 0x0022};
inline constexpr DicomTag shared_groups{0x5200, 0x9229}, frame_groups{0x5200, 0x9230},
    plane_position{0x0020, 0x9113}, plane_orientation{0x0020, 0x9116}, pixel_measures{0x0028, 0x9110},
    pixel_transformation{0x0028, 0x9145}, frame_content{0x0020, 0x9111}, time_index{0x0020, 0x9128};
inline constexpr DicomTag float_pixels{0x7FE0, 0x0008}, double_pixels{0x7FE0, 0x0009}, pixels{0x7FE0, 0x0010};
}  // namespace dicom

/// A data set or an item of a sequence: values, little endian and without padding, and the items of sequences
/// that say something of the pixels.
struct DicomItem {
  std::map<DicomTag, std::string> values;
  std::map<DicomTag, std::vector<DicomItem>> sequences;

  /// Or bytes; empty where it is missing.
  const std::string& text(DicomTag tag) const {
    static const std::string none;
    const auto found = values.find(tag);
    return found == values.end() ? none : found->second;
  }
  /// None where it is missing.
  const std::vector<DicomItem>& items(DicomTag sequence) const {
    static const std::vector<DicomItem> none;
    const auto found = sequences.find(sequence);
    return found == sequences.end() ? none : found->second;
  }
  /// Null where there is none.
  const DicomItem* first_item(DicomTag sequence) const {
    return items(sequence).empty() ? nullptr : &items(sequence).front();
  }
  /// Of an element that is of numbers; NaN for each that is none or not finite.
  std::vector<double> numbers(DicomTag tag) const;
};

struct DicomPixels {
  bool encapsulated = false;                ///< compressed, in fragments; the first is an offset table
  std::vector<std::string_view> fragments;  ///< one when not encapsulated
  std::size_t begin = 0, end = 0;           ///< of the value in DicomFile::data, with what ends it
};

struct DicomFile {
  std::filesystem::path path;
  std::shared_ptr<const void> memory;          ///< of `data`
  std::string_view data;                       ///< without zeros behind it; the inflated data set alone
  std::string transfer_syntax, storage_class;  ///< UIDs of the file's own meta information
  DicomItem elements;
  std::optional<DicomPixels> pixels;

  bool big_endian() const { return transfer_syntax == "1.2.840.10008.1.2.2"; }
  bool deflated() const { return transfer_syntax == "1.2.840.10008.1.2.1.99"; }
};

/// Follows the element headers of a DICOM file (PS3.10 section 7, PS3.5 section 7) to its end and checks that
/// every element lies within the file and what contains it: GDCM's assertions end the process for others.
/// Returns nothing for a file that is not DICOM; throws InputError for one that is cut short or damaged.
std::optional<DicomFile> read_dicom_file(const std::filesystem::path& path);

/// An element's name, kind and count of numbers, by the standard's dictionary.
struct DicomEntry {
  std::string name, vr;
  std::size_t count = 1;  ///< 0: any
};
DicomEntry dicom_entry(DicomTag tag);

}  // namespace ringsplat::detail
