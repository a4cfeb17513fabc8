#include "formats/dicom/copy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "formats/dicom/frames.hpp"
#include "formats/dicom/schema.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr DicomTag item_begin{0xFFFE, 0xE000}, sequence_end{0xFFFE, 0xE0DD};
constexpr std::uint32_t undefined_length = 0xFFFFFFFF;

std::string little(std::uint64_t value, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += char(value >> (8 * i) & 0xFF);
  return text;
}

std::string tag_bytes(DicomTag tag) { return little(tag.group, 2) + little(tag.element, 2); }

/// Explicit little endian (PS3.5, section 7.1.2).
std::string element(DicomTag tag, std::string_view vr, std::string value) {
  if (value.size() % 2 != 0) value += vr == "UI" || vr[0] == 'O' ? '\0' : ' ';
  const bool is_long = vr == "SQ" || vr[0] == 'O';
  const auto length = is_long ? little(0, 2) + little(value.size(), 4) : little(value.size(), 2);
  return tag_bytes(tag) + std::string(vr) + length + value;
}

std::string short_element(DicomTag tag, int value) {
  return element(tag, "US", little(std::uint64_t(value), 2));
}

/// A text value reduced to its numbers, with the digits of the file.
std::string plain_numbers(const std::string& value) {
  std::string plain;
  for (std::size_t at = 0; at <= value.size();) {
    const auto end = std::min(value.find('\\', at), value.size());
    if (at > 0) plain += '\\';
    plain += trimmed(value.substr(at, end - at));
    at = end + 1;
  }
  return plain;
}

class Copy {
 public:
  Copy(const DicomFile& file, const DicomShape& shape) : file_(file), shape_(shape) {}

  MemoryFile write() {
    auto text = std::string(128, '\0') + "DICM" + meta();
    // The pixels' shape comes from what was checked.
    DicomItem rest = file_.elements;
    for (const auto tag : {dicom::samples, dicom::frames, dicom::rows, dicom::columns, dicom::bits_allocated,
                           dicom::bits_stored, dicom::high_bit, dicom::is_signed})
      rest.values.erase(tag);
    // GDCM takes the distance of the first two frames.
    if (shape_.frames < 2) rest.values.erase(dicom::frame_offsets);
    rest.values.try_emplace(dicom::storage_class, file_.storage_class);
    rest.values.try_emplace(dicom::photometric, "MONOCHROME2");
    auto elements = encoded(rest, {});
    add_shape(elements);
    for (const auto& [tag, bytes] : elements) text += bytes;
    append(text);
    write_pixels();
    return std::move(out_);
  }

 private:
  using Elements = std::map<DicomTag, std::string>;

  void append(const std::string& text) { out_.append(std::as_bytes(std::span(text))); }

  std::string meta() const {
    const auto& classes =
        file_.storage_class.empty() ? *file_.elements.find(dicom::storage_class) : file_.storage_class;
    const auto* const instance = file_.elements.find(dicom::instance);
    const std::string syntax = compressed() ? file_.transfer_syntax : "1.2.840.10008.1.2.1";
    const auto body = element({2, 1}, "OB", std::string("\0\1", 2)) + element({2, 2}, "UI", uid(classes)) +
                      element({2, 3}, "UI", instance == nullptr ? "1.2.3" : uid(*instance)) +
                      element({2, 0x10}, "UI", syntax) + element({2, 0x12}, "UI", "1.2.3");
    return element({2, 0}, "UL", little(body.size(), 4)) + body;
  }

  bool compressed() const { return shape_.codec != DicomCodec::none && shape_.codec != DicomCodec::rle; }

  std::string uid(const std::string& text) const {
    constexpr std::size_t longest = 64;
    if (text.size() > longest || text.find_first_not_of("0123456789.") != std::string::npos)
      throw InputError(fmt::format("{}: '{}' is no UID", file_.path.string(), excerpt(text)),
                       "copy the file again");
    return text;
  }

  void add_shape(Elements& elements) const {
    for (const auto& [tag, value] : {std::pair(dicom::samples, 1),
                                     {dicom::rows, shape_.rows},
                                     {dicom::columns, shape_.columns},
                                     {dicom::bits_allocated, shape_.bits_allocated},
                                     {dicom::bits_stored, shape_.bits_stored},
                                     {dicom::high_bit, shape_.high_bit},
                                     {dicom::is_signed, int(shape_.is_signed)}})
      elements[tag] = short_element(tag, value);
    if (shape_.frames > 1)
      elements[dicom::frames] = element(dicom::frames, "IS", std::to_string(shape_.frames));
  }

  Elements encoded(const DicomItem& item, DicomTag parent) const {
    Elements elements;
    for (const auto& [tag, value] : item.values)
      if (find_dicom_rule(tag, parent)->told) elements[tag] = encoded(tag, value, parent);
    for (const auto& [tag, items] : item.sequences)
      if (!find_dicom_rule(tag, parent)->told)
        continue;
      else if (auto bytes = encoded(tag, items); !bytes.empty())
        elements[tag] = std::move(bytes);
    return elements;
  }

  std::string encoded(DicomTag tag, const std::string& value, DicomTag parent) const {
    const auto vr = find_dicom_rule(tag, parent)->vr;
    if (vr == "UI") return element(tag, vr, uid(value));
    if (vr == "CS") return element(tag, vr, excerpt(value));
    if (vr == "DS" || vr == "IS") {
      auto numbers = plain_numbers(value);
      constexpr std::size_t longest = std::numeric_limits<std::uint16_t>::max() - 1;
      if (numbers.size() > longest)
        throw InputError(
            fmt::format("{}: {} bytes of numbers in {}", file_.path.string(), numbers.size(), to_string(tag)),
            "copy the file again");
      return element(tag, vr, std::move(numbers));
    }
    return element(tag, vr, value);
  }

  /// Leaves out a sequence without a whole item: GDCM would use its first item all the same.
  std::string encoded(DicomTag tag, const std::vector<DicomItem>& items) const {
    std::string body;
    for (const auto& item : items) {
      std::string bytes;
      for (const auto& [inner, text] : encoded(item, tag)) bytes += text;
      if (!whole(tag, item)) break;
      body += tag_bytes(item_begin) + little(bytes.size(), 4) + bytes;
    }
    return body.empty() ? body : element(tag, "SQ", std::move(body));
  }

  static bool whole(DicomTag sequence, const DicomItem& item) {
    for (const auto tag : {dicom::position, dicom::orientation, dicom::pixel_spacing, dicom::intercept,
                           dicom::slope, dicom::delta_x, dicom::delta_y}) {
      const auto* const rule = find_dicom_rule(tag, sequence);
      if (rule != nullptr && rule->required && item.find(tag) == nullptr) return false;
    }
    return true;
  }

  void write_pixels() {
    const char* const vr = shape_.bits_allocated == 8 || compressed() ? "OB" : "OW";
    const auto length = shape_.bytes() + shape_.bytes() % 2;
    if (length >= undefined_length)
      throw InputError(fmt::format("{}: {} bytes of pixels", file_.path.string(), shape_.bytes()),
                       "give the frames as a series of files");
    append(tag_bytes(dicom::pixels) + vr + little(0, 2) +
           little(compressed() ? undefined_length : length, 4));
    if (shape_.codec == DicomCodec::none) {
      copy_pixels();
    } else {
      if (compressed()) append(tag_bytes(item_begin) + little(0, 4));
      for (const auto& fragments : dicom_frames(file_, shape_)) write_frame(join_fragments(file_, fragments));
    }
    if (compressed()) return append(tag_bytes(sequence_end) + little(0, 4));
    if (length != shape_.bytes()) append(std::string(1, '\0'));
  }

  void write_frame(std::vector<std::byte> frame) {
    if (!compressed()) return out_.append(decode_rle(file_, shape_, frame));
    frame = sound_jpeg_frame(file_, shape_, frame);
    if (frame.size() % 2 != 0) frame.push_back(std::byte{0});
    append(tag_bytes(item_begin) + little(frame.size(), 4));
    out_.append(frame);
  }

  void copy_pixels() {
    const auto begin = file_.pixels->fragments[0].begin;
    const std::uint64_t bytes = shape_.bytes();
    const std::uint64_t stored = file_.pixels->fragments[0].length;
    // 16-bit words are in the file's byte order, also when they hold single bytes.
    const std::size_t swapped = !file_.big_endian     ? 1
                                : file_.pixels->words ? 2
                                                      : std::size_t(shape_.bytes_per_voxel());
    std::vector<std::byte> window(1 << 20);
    for (std::uint64_t done = 0; done < bytes;) {
      const auto wanted =
          std::min<std::uint64_t>(window.size(), std::min(stored, bytes + bytes % swapped) - done);
      const auto part = std::span(window).first(std::size_t(wanted));
      file_.data->read(begin + done, part);
      for (std::size_t i = 0; swapped == 2 && i + 1 < part.size(); i += 2) std::swap(part[i], part[i + 1]);
      out_.append(part.first(std::size_t(std::min<std::uint64_t>(wanted, bytes - done))));
      done += wanted;
    }
  }

  const DicomFile& file_;
  const DicomShape& shape_;
  MemoryFile out_;
};

}  // namespace

MemoryFile copy_dicom(const DicomFile& file, const DicomShape& shape) { return Copy(file, shape).write(); }

}  // namespace ringsplat::detail
