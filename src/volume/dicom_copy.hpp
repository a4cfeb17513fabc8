#pragma once
#include "volume/dicom_checks.hpp"
#include "volume/dicom_elements.hpp"
#include "volume/memory_file.hpp"

namespace ringsplat::detail {

/// Writes a DICOM file anew for GDCM, which never sees the original: explicit little endian, of the elements
/// only those whose values were checked, run lengths decoded, one fragment for each other compressed frame.
/// Throws InputError for frames that are not what the header says.
MemoryFile copy_dicom(const DicomFile& file, const DicomShape& shape);

}  // namespace ringsplat::detail
