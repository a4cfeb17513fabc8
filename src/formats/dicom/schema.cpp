#include "formats/dicom/schema.hpp"

#include <algorithm>
#include <array>

namespace ringsplat::detail {
namespace {

using namespace dicom;

constexpr DicomRule untold(DicomTag tag, std::string_view vr, std::string_view name, DicomTag parent = {}) {
  return {.tag = tag, .vr = vr, .name = name, .parent = parent, .told = false};
}

constexpr std::array rules{
    DicomRule{storage_class, "UI", "SOP Class UID"},
    DicomRule{instance, "UI", "SOP Instance UID"},
    DicomRule{modality, "CS", "Modality"},
    DicomRule{series, "UI", "Series Instance UID"},
    untold(description, "LO", "Series Description"),
    untold(series_number, "IS", "Series Number"),
    untold(number, "IS", "Instance Number"),
    untold(time_position, "IS", "Temporal Position Identifier"),
    untold(b_value, "FD", "Diffusion b-value"),
    untold(echo_time, "DS", "Echo Time"),
    untold(trigger_time, "DS", "Trigger Time"),
    untold(acquisition, "IS", "Acquisition Number"),
    untold(acquisition_time, "TM", "Acquisition Time"),
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
    untold(rescale_type, "LO", "Rescale Type"),
    DicomRule{regions, "SQ", "Sequence of Ultrasound Regions"},
    DicomRule{delta_x, "FD", "Physical Delta X", 1, regions, true},
    DicomRule{delta_y, "FD", "Physical Delta Y", 1, regions, true},
    DicomRule{xray_acquisition, "SQ", "X-Ray 3D Acquisition Sequence"},
    DicomRule{intercept, "DS", "Rescale Intercept", 1, xray_acquisition, true},
    DicomRule{slope, "DS", "Rescale Slope", 1, xray_acquisition, true},
    DicomRule{detectors, "SQ", "Detector Information Sequence"},
    DicomRule{position, "DS", "Image Position Patient", 3, detectors, true},
    DicomRule{orientation, "DS", "Image Orientation Patient", 6, detectors},
    DicomRule{shared_groups, "SQ", "Shared Functional Groups Sequence"},
    DicomRule{frame_groups, "SQ", "Per-Frame Functional Groups Sequence"},
    DicomRule{plane_position, "SQ", "Plane Position Sequence", 1, shared_groups},
    DicomRule{plane_orientation, "SQ", "Plane Orientation Sequence", 1, shared_groups},
    DicomRule{pixel_measures, "SQ", "Pixel Measures Sequence", 1, shared_groups},
    DicomRule{pixel_transformation, "SQ", "Pixel Value Transformation Sequence", 1, shared_groups},
    untold(frame_content, "SQ", "Frame Content Sequence", shared_groups),
    untold(time_index, "UL", "Temporal Position Index", frame_content),
    DicomRule{position, "DS", "Image Position Patient", 3, plane_position, true},
    DicomRule{orientation, "DS", "Image Orientation Patient", 6, plane_orientation, true},
    DicomRule{pixel_spacing, "DS", "Pixel Spacing", 2, pixel_measures, true},
    DicomRule{slice_distance, "DS", "Spacing Between Slices", 1, pixel_measures},
    DicomRule{intercept, "DS", "Rescale Intercept", 1, pixel_transformation, true},
    DicomRule{slope, "DS", "Rescale Slope", 1, pixel_transformation, true},
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
