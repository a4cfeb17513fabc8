#include "decode/dicom/frames.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

using namespace std::string_view_literals;

[[noreturn]] void fail(const DicomFile& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.path.string(), what), "copy or write the file again");
}

std::uint32_t little32(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i - 1]);
  return value;
}
std::string little32(std::uint64_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += char(value >> (8 * i));
  return bytes;
}

std::string bytes_between(const DicomFile& file, std::uint64_t begin, std::uint64_t end) {
  std::string bytes(std::size_t(end - begin), '\0');
  file.data->read(begin, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}
std::string bytes_of(const DicomFile& file, const DicomFragment& fragment) {
  return bytes_between(file, fragment.begin, fragment.begin + fragment.length);
}

/// The frames' bytes (PS3.5, annex A.4): of fragments the first is a table of where the frames begin.
std::vector<std::string> frames_of(const DicomFile& file, const DicomShape& shape) {
  const auto count = std::size_t(shape.frames);
  const auto& all = file.pixels->fragments;
  if (all.size() < 2) fail(file, "its pixels have no fragments");
  const bool has_table = all[0].length == 4 * count;
  const std::string table = has_table ? bytes_of(file, all[0]) : std::string();
  const bool one_each = all.size() == count + 1;
  std::vector<std::string> frames;
  for (auto fragment = all.begin() + 1; fragment != all.end(); ++fragment) {
    const auto next = frames.size();
    const bool begins =
        one_each || (count == 1 && next == 0) ||
        (next < count && has_table &&
         fragment->begin - all[1].begin == little32(std::string_view(table).substr(4 * next)));
    if (begins) frames.emplace_back();
    if (frames.empty()) break;
    frames.back() += bytes_of(file, *fragment);
  }
  if (frames.size() != count)
    fail(file, fmt::format("{} fragments cannot be told to be {} frames", all.size() - 1, count));
  return frames;
}

/// GDCM fills what a frame lacks, and reads run lengths of other pixels.
void require_whole(const DicomFile& file, const DicomShape& shape, std::string& frame) {
  if (shape.codec == DicomCodec::rle) {
    if (frame.size() < 4 || little32(frame) != shape.bytes_per_voxel())
      fail(file, fmt::format("a frame of run lengths is not of {} segments", shape.bytes_per_voxel()));
    return;
  }
  const auto end = frame.rfind("\xFF\xD9"sv);
  if (end == std::string::npos) fail(file, "a compressed frame is cut short or damaged");
  frame.resize(end + 2);
}

/// A JPEG frame without comments and applications' segments, on which GDCM stumbles, and fill bytes.
std::string without_notes(const DicomFile& file, const std::string& frame) {
  constexpr unsigned scan = 0xDA, first_application = 0xE0, last_application = 0xEF, comment = 0xFE;
  std::string kept = frame.substr(0, 2);
  for (std::size_t at = 2;;) {
    while (at + 1 < frame.size() && frame[at] == '\xFF' && frame[at + 1] == '\xFF') ++at;
    if (at + 4 > frame.size() || frame[at] != '\xFF')
      fail(file, "a compressed frame is cut short or damaged");
    const auto byte = [&](std::size_t i) { return unsigned(static_cast<unsigned char>(frame[at + i])); };
    const unsigned marker = byte(1);
    if (marker == scan) return kept + frame.substr(at);
    const std::size_t length = 2 + 256 * byte(2) + byte(3);
    if (marker != comment && (marker < first_application || marker > last_application))
      kept += frame.substr(at, length);
    at += length;
  }
}

}  // namespace

std::optional<std::string> bytes_for_gdcm(const DicomFile& file, const DicomShape& shape) {
  if (shape.codec == DicomCodec::none) {
    if (file.inflated || file.end == file.data->size()) return {};
    return bytes_between(file, 0, file.end);
  }
  const std::string item("\xFE\xFF\x00\xE0", 4), end("\xFE\xFF\xDD\xE0\0\0\0\0", 8);
  std::string bytes = bytes_between(file, 0, file.pixels->begin) + item + little32(0);
  for (auto& frame : frames_of(file, shape)) {
    require_whole(file, shape, frame);
    if (shape.codec != DicomCodec::rle && shape.codec != DicomCodec::jpeg_2000)
      frame = without_notes(file, frame);
    if (frame.size() % 2 != 0) frame += '\0';
    bytes += item + little32(frame.size()) + frame;
  }
  return bytes + end + bytes_between(file, file.pixels->end, file.end);
}

}  // namespace ringsplat::detail
