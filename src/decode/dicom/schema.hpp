#pragma once
#include <cstdint>
#include <string_view>

#include "decode/dicom/elements.hpp"

namespace ringsplat::detail {

namespace dicom {
inline constexpr DicomTag storage_class{0x0008, 0x0016}, instance{0x0008, 0x0018}, modality{0x0008, 0x0060};
inline constexpr DicomTag series{0x0020, 0x000E}, number{0x0020, 0x0013}, description{0x0008, 0x103E},
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

/// An element that decides what the pixels are, where they lie or what they mean (PS3.3 and PS3.6).
struct DicomRule {
  DicomTag tag;
  std::string_view vr, name;
  int count = 1;         ///< of numbers in it; 0: any
  DicomTag parent = {};  ///< the sequence whose items have it; {0, 0}: the data set itself
};

/// Null for an element that nothing here depends on, and which is not kept.
const DicomRule* find_dicom_rule(DicomTag tag, DicomTag parent);

}  // namespace ringsplat::detail
