#pragma once
#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.hpp"
#include "base/memory_file.hpp"

namespace ringsplat::detail {

struct DicomTag {
  std::uint16_t group = 0, element = 0;
  auto operator<=>(const DicomTag&) const = default;
};
std::string to_string(DicomTag tag);  ///< "(0028,0010)"

/// The kept part of a data set: values of a few elements, little endian and without padding, and the items of
/// a few sequences.
struct DicomItem {
  std::map<DicomTag, std::string> values;
  std::map<DicomTag, std::vector<DicomItem>> sequences;

  const std::string* find(DicomTag tag) const;
  const DicomItem* first_item(DicomTag sequence) const;  ///< null where there is none
};

struct DicomFragment {
  std::uint64_t begin = 0, length = 0;
};

/// Where the pixels are in DicomFile::data.
struct DicomPixels {
  bool encapsulated = false;             ///< compressed, in fragments; the first is an offset table
  bool words = false;                    ///< VR OW: 16-bit words
  std::vector<DicomFragment> fragments;  ///< one when not encapsulated
  std::uint64_t begin = 0, end = 0;      ///< of the value, with what ends it
};

struct DicomFile {
  std::filesystem::path path;
  std::optional<MemoryFile> inflated;  ///< of a deflated data set; `data` then reads it
  std::unique_ptr<InputFile> data;
  std::string transfer_syntax, storage_class;  ///< UIDs of the file's own meta information
  bool big_endian = false;
  std::uint64_t end = 0;  ///< of the elements; zeros may follow
  DicomItem elements;
  std::optional<DicomPixels> pixels;
};

/// Follows the element headers of a DICOM file (PS3.10 section 7, PS3.5 section 7) to its end and checks that
/// every element lies within the file and what contains it. Returns nothing for a file that is not DICOM;
/// throws InputError for one that is cut short or damaged.
std::optional<DicomFile> read_dicom_file(const std::filesystem::path& path);

}  // namespace ringsplat::detail
