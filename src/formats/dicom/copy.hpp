#pragma once
#include "base/memory_file.hpp"
#include "formats/dicom/checks.hpp"
#include "formats/dicom/elements.hpp"

namespace ringsplat::detail {

/// Writes a DICOM file anew for GDCM, which never sees the original. The copy is explicit little endian and
/// has only elements whose values were checked; run lengths are decoded, other compressed frames have one
/// fragment each. Throws InputError for frames that are not what the header says.
MemoryFile copy_dicom(const DicomFile& file, const DicomShape& shape);

}  // namespace ringsplat::detail
