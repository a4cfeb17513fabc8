#pragma once
#include <gdcmImageReader.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "decode/dicom/checks.hpp"
#include "decode/dicom/planes.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// The pixels and the geometry of one DICOM file, by GDCM, from a copy that was checked. Holds the copy in
/// memory. Not for several threads at once.
class DicomImage {
 public:
  /// Throws InputError for a damaged or unreadable file. Returns nothing for a file that is no DICOM image:
  /// notes, a DICOMDIR, a report.
  static std::unique_ptr<DicomImage> open(const std::filesystem::path& path);

  const Grid& grid() const { return grid_; }  ///< of all frames; its type is that after rescaling
  /// Where its frames lie; nothing for a single one, and where GDCM alone knows.
  const std::optional<DicomPlanes>& planes() const { return planes_; }
  /// All frames, grid().bytes() bytes.
  void read(std::span<std::byte> out);

 private:
  std::filesystem::path path_;
  gdcm::ImageReader reader_;
  DicomShape shape_;
  Grid grid_;
  Rescale rescale_;
  std::optional<DicomPlanes> planes_;
};

}  // namespace ringsplat::detail
