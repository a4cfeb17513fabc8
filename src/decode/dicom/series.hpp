#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "decode/dicom/planes.hpp"

namespace ringsplat::detail {

/// What is known of a DICOM image without its pixels.
struct DicomHeader {
  std::filesystem::path file;
  std::string instance;  ///< SOP Instance UID
  int frames = 1;
  DicomTimes times{};  ///< of a single frame
};

struct DicomSeries {
  std::string uid, description, modality, number, rescale_type;
  std::vector<DicomHeader> images = {};  ///< by their paths; copies of an image are left out
  /// Of all images.
  std::size_t slices() const {
    std::size_t sum = 0;
    for (const DicomHeader& image : images) sum += std::size_t(image.frames);
    return sum;
  }
};

/// The series in a folder and, when `deep`, in those below it; by UID. Symbolic links are followed, loops do
/// no harm. Warns of files that cannot be read; throws InputError, the first complaint, when none can, and
/// for folders with more files than a study has.
std::vector<DicomSeries> find_series(const std::filesystem::path& folder, bool deep);

/// The series of one image; with that image only when it is no DICOM image (none) or is multi-frame (one).
std::vector<DicomSeries> find_series_of(const std::filesystem::path& file);

/// Number of slices, modality, series number, description and the UID's ending, a line each.
std::vector<std::string> describe(const std::vector<DicomSeries>& series);

/// The series that `wanted` names: its UID, number, description, or beginning or ending of its UID. Without
/// it the longest, with a warning when there are several. Throws InputError when none or several are meant.
/// `where`: the folder, for messages.
const DicomSeries& choose_series(const std::vector<DicomSeries>& series, const std::string& wanted,
                                 const std::string& where);

}  // namespace ringsplat::detail
