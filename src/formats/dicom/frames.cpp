#include "formats/dicom/frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

[[noreturn]] void fail(const DicomFile& file, const std::string& what) {
  throw InputError(fmt::format("{}: {}", file.path.string(), what), "copy or write the file again");
}

std::uint32_t little32(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = value << 8 | std::to_integer<std::uint32_t>(bytes[i - 1]);
  return value;
}

/// Decodes run lengths and hands on `count` bytes one by one.
template <class Put>
bool unpack(std::span<const std::byte> in, std::size_t count, Put&& put) {
  std::size_t done = 0;
  for (std::size_t at = 0; done < count && at < in.size();) {
    const auto control = std::to_integer<int>(in[at++]);
    constexpr int no_operation = 128;
    if (control == no_operation) continue;
    const bool run = control > no_operation;
    const auto length = std::size_t(run ? 257 - control : control + 1);
    if (in.size() - at < (run ? 1 : length)) return false;
    for (std::size_t i = 0; i < length && done < count; ++i) put(done++, in[run ? at : at + i]);
    at += run ? 1 : length;
  }
  return done == count;
}

}  // namespace

std::vector<std::vector<DicomFragment>> dicom_frames(const DicomFile& file, const DicomShape& shape) {
  const auto count = std::size_t(shape.frames);
  const auto& all = file.pixels->fragments;
  if (all.size() < 2) fail(file, "its pixels have no fragments");
  const std::vector<DicomFragment> fragments(all.begin() + 1, all.end());
  if (count == 1) return {fragments};
  std::vector<std::vector<DicomFragment>> frames;
  if (fragments.size() == count) {
    for (const auto& fragment : fragments) frames.push_back({fragment});
    return frames;
  }
  std::vector<std::uint32_t> offsets;
  if (all[0].length == 4 * count) {
    const auto table = join_fragments(file, {all[0]});
    for (std::size_t i = 0; i < count; ++i) offsets.push_back(little32(std::span(table).subspan(4 * i, 4)));
  }
  for (const auto& fragment : fragments) {
    if (frames.size() < offsets.size() && fragment.begin - fragments[0].begin == offsets[frames.size()])
      frames.emplace_back();
    if (frames.empty()) break;
    frames.back().push_back(fragment);
  }
  if (frames.size() != count)
    fail(file, fmt::format("{} fragments cannot be told to be {} frames", fragments.size(), count));
  return frames;
}

std::vector<std::byte> join_fragments(const DicomFile& file, const std::vector<DicomFragment>& fragments) {
  std::vector<std::byte> bytes;
  for (const auto& fragment : fragments) {
    const auto at = bytes.size();
    bytes.resize(at + std::size_t(fragment.length));
    file.data->read(fragment.begin, std::span(bytes).subspan(at));
  }
  return bytes;
}

std::vector<std::byte> decode_rle(const DicomFile& file, const DicomShape& shape,
                                  const std::vector<std::byte>& frame) {
  constexpr std::size_t header_bytes = 64;
  const auto planes = std::size_t(shape.bytes_per_voxel());
  const auto voxels = std::size_t(shape.frame_voxels());
  if (frame.size() < header_bytes || little32(frame) != planes)
    fail(file, fmt::format("a frame of run lengths is not of {} segments", planes));
  std::vector<std::byte> pixels(voxels * planes);
  for (std::size_t plane = 0; plane < planes; ++plane) {
    const auto word = [&](std::size_t i) {
      return std::size_t(little32(std::span(frame).subspan(4 * i, 4)));
    };
    const auto begin = word(plane + 1), end = plane + 1 < planes ? word(plane + 2) : frame.size();
    // The first segment has the highest bytes.
    const auto shift = planes - 1 - plane;
    if (begin < header_bytes || end < begin || end > frame.size() ||
        !unpack(std::span(frame).subspan(begin, end - begin), voxels,
                [&](std::size_t i, std::byte value) { pixels[i * planes + shift] = value; }))
      fail(file, "a frame of run lengths is cut short or damaged");
  }
  return pixels;
}

}  // namespace ringsplat::detail
