#pragma once
#include <cstddef>
#include <vector>

#include "formats/dicom/checks.hpp"
#include "formats/dicom/elements.hpp"

namespace ringsplat::detail {

/// The fragments of each frame of encapsulated pixels (PS3.5, annex A.4), without the offset table. Throws
/// InputError when they cannot be told apart.
std::vector<std::vector<DicomFragment>> dicom_frames(const DicomFile& file, const DicomShape& shape);

/// A frame's bytes, its fragments joined.
std::vector<std::byte> join_fragments(const DicomFile& file, const std::vector<DicomFragment>& fragments);

/// Decodes a frame of run lengths (PS3.5, annex G) to little-endian pixels. Throws InputError for a frame
/// that lacks pixels.
std::vector<std::byte> decode_rle(const DicomFile& file, const DicomShape& shape,
                                  const std::vector<std::byte>& frame);

/// Checks that a frame's JPEG, JPEG-LS or JPEG 2000 header agrees with the DICOM header, and that all its
/// segments lie within the frame. Otherwise GDCM would end the process or write beyond its memory. Returns
/// the frame without segments that decide no pixel, such as comments, on which GDCM stumbles too, and without
/// bytes behind its end. Throws InputError.
std::vector<std::byte> sound_jpeg_frame(const DicomFile& file, const DicomShape& shape,
                                        const std::vector<std::byte>& frame);

}  // namespace ringsplat::detail
