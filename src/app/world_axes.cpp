#include "app/world_axes.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string>

#include "volume/dicom_elements.hpp"
#include "volume/formats.hpp"

namespace ringsplat::app {
namespace {

/// A header ends with an empty line.
bool nrrd_names_a_space(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  constexpr int most_lines = 1000;
  std::string line;
  for (int k = 0; k < most_lines && std::getline(in, line) && !line.empty() && line != "\r"; ++k)
    if (line.starts_with("space:") || line.starts_with("space :")) return true;
  return false;
}

/// A folder has the pages of a TIFF stack or a DICOM series.
bool has_pages(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator files(folder);
  return std::any_of(begin(files), end(files), [](const auto& file) { return detail::is_tiff(file.path()); });
}

}  // namespace

bool world_is_patient(const std::filesystem::path& volume) {
  if (std::filesystem::is_directory(volume)) return !has_pages(volume);
  std::string name = volume.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return nrrd_names_a_space(volume);
  constexpr std::array endings{".nii", ".nii.gz", ".img", ".img.gz", ".hdr", ".mha", ".mhd", ".dcm"};
  return std::any_of(endings.begin(), endings.end(),
                     [&](const char* ending) { return name.ends_with(ending); }) ||
         detail::is_dicom(volume);
}

}  // namespace ringsplat::app
