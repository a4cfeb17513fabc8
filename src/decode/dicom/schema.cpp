#include "decode/dicom/schema.hpp"

#include <algorithm>
#include <array>

namespace ringsplat::detail {
namespace {

using namespace dicom;

constexpr std::array rules{
    DicomRule{storage_class, "UI", "SOP Class UID"},
    DicomRule{instance, "UI", "SOP Instance UID"},
    DicomRule{modality, "CS", "Modality"},
    DicomRule{series, "UI", "Series Instance UID"},
    DicomRule{description, "LO", "Series Description"},
    DicomRule{series_number, "IS", "Series Number"},
    DicomRule{number, "IS", "Instance Number"},
    DicomRule{time_position, "IS", "Temporal Position Identifier"},
    DicomRule{b_value, "FD", "Diffusion b-value"},
    DicomRule{echo_time, "DS", "Echo Time"},
    DicomRule{trigger_time, "DS", "Trigger Time"},
    DicomRule{acquisition, "IS", "Acquisition Number"},
    DicomRule{acquisition_time, "TM", "Acquisition Time"},
    DicomRule{position, "DS", "Image Position Patient", 3},
    DicomRule{orientation, "DS", "Image Orientation Patient", 6},
    DicomRule{slice_distance, "DS", "Spacing Between Slices"},
    DicomRule{imager_spacing, "DS", "Imager Pixel Spacing", 2},
    DicomRule{scanned_spacing, "DS", "Nominal Scanned Pixel Spacing", 2},
    DicomRule{pixel_spacing, "DS", "Pixel Spacing", 2},
    DicomRule{aspect, "IS", "Pixel Aspect Ratio", 2},
    DicomRule{plane_spacing, "DS", "Image Plane Pixel Spacing", 2},
    DicomRule{frame_offsets, "DS", "Grid Frame Offset Vector", 0},
    DicomRule{dose_scale, "DS", "Dose Grid Scaling"},
    DicomRule{samples, "US", "Samples per Pixel"},
    DicomRule{photometric, "CS", "Photometric Interpretation"},
    DicomRule{frames, "IS", "Number of Frames"},
    DicomRule{rows, "US", "Rows"},
    DicomRule{columns, "US", "Columns"},
    DicomRule{bits_allocated, "US", "Bits Allocated"},
    DicomRule{bits_stored, "US", "Bits Stored"},
    DicomRule{high_bit, "US", "High Bit"},
    DicomRule{is_signed, "US", "Pixel Representation"},
    DicomRule{intercept, "DS", "Rescale Intercept"},
    DicomRule{slope, "DS", "Rescale Slope"},
    DicomRule{rescale_type, "LO", "Rescale Type"},
    DicomRule{regions, "SQ", "Sequence of Ultrasound Regions"},
    DicomRule{delta_x, "FD", "Physical Delta X", 1, regions},
    DicomRule{delta_y, "FD", "Physical Delta Y", 1, regions},
    DicomRule{xray_acquisition, "SQ", "X-Ray 3D Acquisition Sequence"},
    DicomRule{intercept, "DS", "Rescale Intercept", 1, xray_acquisition},
    DicomRule{slope, "DS", "Rescale Slope", 1, xray_acquisition},
    DicomRule{detectors, "SQ", "Detector Information Sequence"},
    DicomRule{position, "DS", "Image Position Patient", 3, detectors},
    DicomRule{orientation, "DS", "Image Orientation Patient", 6, detectors},
    DicomRule{shared_groups, "SQ", "Shared Functional Groups Sequence"},
    DicomRule{frame_groups, "SQ", "Per-Frame Functional Groups Sequence"},
    DicomRule{plane_position, "SQ", "Plane Position Sequence", 1, shared_groups},
    DicomRule{plane_orientation, "SQ", "Plane Orientation Sequence", 1, shared_groups},
    DicomRule{pixel_measures, "SQ", "Pixel Measures Sequence", 1, shared_groups},
    DicomRule{pixel_transformation, "SQ", "Pixel Value Transformation Sequence", 1, shared_groups},
    DicomRule{frame_content, "SQ", "Frame Content Sequence", 1, shared_groups},
    DicomRule{time_index, "UL", "Temporal Position Index", 1, frame_content},
    DicomRule{position, "DS", "Image Position Patient", 3, plane_position},
    DicomRule{orientation, "DS", "Image Orientation Patient", 6, plane_orientation},
    DicomRule{pixel_spacing, "DS", "Pixel Spacing", 2, pixel_measures},
    DicomRule{slice_distance, "DS", "Spacing Between Slices", 1, pixel_measures},
    DicomRule{intercept, "DS", "Rescale Intercept", 1, pixel_transformation},
    DicomRule{slope, "DS", "Rescale Slope", 1, pixel_transformation},
};

}  // namespace

const DicomRule* find_dicom_rule(DicomTag tag, DicomTag parent) {
  // Frames have the same groups as all of them together.
  if (parent == frame_groups) parent = shared_groups;
  const auto* const found = std::find_if(rules.begin(), rules.end(), [&](const DicomRule& rule) {
    return rule.tag == tag && rule.parent == parent;
  });
  return found == rules.end() ? nullptr : found;
}

}  // namespace ringsplat::detail
