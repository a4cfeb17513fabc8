#pragma once
#include <optional>
#include <string>

#include "decode/dicom/checks.hpp"
#include "decode/dicom/elements.hpp"

namespace ringsplat::detail {

/// The bytes of a file that GDCM would not read, or not rightly, as it does: with one fragment a frame,
/// without segments of JPEG that decide no pixel, without what media pad it with. Nothing for other files.
/// Throws InputError for frames that cannot be told apart, are cut short, or not as the header says.
std::optional<std::string> bytes_for_gdcm(const DicomFile& file, const DicomShape& shape);

}  // namespace ringsplat::detail
