#include "decode/dicom/elements.hpp"

#include <fmt/format.h>
#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <new>
#include <span>
#include <string_view>
#include <utility>

#include "base/byte_order.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t preamble = 128;
constexpr std::uint32_t undefined_length = 0xFFFFFFFF;
constexpr int deepest = 32;                       // nested sequences
constexpr std::uint64_t longest_value = 1 << 20;  // of those that are kept

constexpr DicomTag transfer_syntax{0x0002, 0x0010}, meta_storage_class{0x0002, 0x0002};
constexpr DicomTag item_begin{0xFFFE, 0xE000}, item_end{0xFFFE, 0xE00D}, sequence_end{0xFFFE, 0xE0DD};
/// Sequences that say something of the pixels; the items of others are not kept.
constexpr DicomTag kept_sequences[] = {
    dicom::regions,           dicom::xray_acquisition, dicom::detectors,
    dicom::shared_groups,     dicom::frame_groups,     dicom::plane_position,
    dicom::plane_orientation, dicom::pixel_measures,   dicom::pixel_transformation,
    dicom::frame_content};
constexpr std::uint16_t meta_group = 0x0002, delimiter_group = 0xFFFE;

/// Of elements that are kept.
constexpr std::uint16_t geometry_group = 0x0020, pixel_group = 0x0028;
constexpr std::uint16_t kept_groups[] = {0x0008, 0x0018, geometry_group, pixel_group, 0x3002, 0x3004};

struct Element {
  DicomTag tag;
  std::uint64_t begin = 0;  ///< of its value in the file
  std::uint32_t length = 0;
  std::string vr;  ///< empty where the encoding has none
  bool open_ended() const { return length == undefined_length; }
  std::uint64_t end() const { return begin + length; }
};

struct Encoding {
  bool explicit_vr = true, big_endian = false;
};

class Parser {
 public:
  explicit Parser(DicomFile& file) : file_(file) {}

  void parse() {
    auto at = parse_meta();
    // PS3.6, table A-1; every compressed syntax has explicit element headers.
    const auto& uid = file_.transfer_syntax;
    encoding_ = {.explicit_vr = !uid.empty() && uid != "1.2.840.10008.1.2", .big_endian = file_.big_endian()};
    if (uid == "1.2.840.10008.1.2.1.99") {
      file_.inflated = std::make_unique<MemoryFile>();
      inflate_from(at);
      file_.data = std::make_unique<InputFile>(file_.inflated->path());
      at = 0;
    }
    file_.end = size();
    parse_elements(at, size(), encoding_, &file_.elements, 0);
    if (!file_.pixels && !file_.elements.text(dicom::rows).empty()) fail(size());
  }

 private:
  std::uint64_t size() const { return file_.data->size(); }

  [[noreturn]] void fail(std::uint64_t at) const {
    throw InputError(fmt::format("{} is cut short or damaged at byte {}", file_.path.string(), at),
                     "copy the file again");
  }

  /// `end`: of what contains the element.
  Element element_at(std::uint64_t at, std::uint64_t end, const Encoding& encoding) const {
    std::array<std::byte, 12> header{};
    const auto got = std::min<std::uint64_t>(file_.data->read_some(at, header), end - at);
    if (got < 8) fail(end);
    const BinaryFields fields(header, encoding.big_endian);
    Element e;
    e.tag = {fields.at<std::uint16_t>(0), fields.at<std::uint16_t>(2)};
    e.begin = at + 8;
    if (!encoding.explicit_vr || e.tag.group == delimiter_group) {
      e.length = fields.at<std::uint32_t>(4);
    } else {
      e.vr = {char(header[4]), char(header[5])};
      if (!std::ranges::all_of(e.vr, [](unsigned char c) { return std::isupper(c) != 0; })) fail(at + 4);
      e.length = fields.at<std::uint16_t>(6);
      constexpr std::string_view long_vrs = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
      if (long_vrs.find(e.vr) != std::string_view::npos) {
        if (got < header.size()) fail(end);
        e.begin = at + header.size();
        e.length = fields.at<std::uint32_t>(8);
      }
    }
    if (!e.open_ended() && e.end() > end) fail(end);
    return e;
  }

  /// Meta elements are always explicit and little-endian; they end where another group begins.
  std::uint64_t parse_meta() {
    std::uint64_t at = preamble + 4;
    while (at < size()) {
      std::array<std::byte, 2> group{};
      if (file_.data->read_some(at, group) < group.size()) fail(size());
      if (BinaryFields(group, false).at<std::uint16_t>(0) != meta_group) break;
      const Element e = element_at(at, size(), {});
      if (e.open_ended()) fail(at);
      if (e.tag == transfer_syntax) file_.transfer_syntax = text_of(e);
      if (e.tag == meta_storage_class) file_.storage_class = text_of(e);
      at = e.end();
    }
    return at;
  }

  /// Of a raw deflate stream (RFC 1951) that begins at `at`.
  void inflate_from(std::uint64_t at) {
    constexpr int no_header = -15;  // zlib.h, inflateInit2
    auto in = file_.bytes(at, size());
    z_stream stream{};
    if (inflateInit2(&stream, no_header) != Z_OK) throw std::bad_alloc();
    stream.next_in = reinterpret_cast<Bytef*>(in.data());
    stream.avail_in = static_cast<uInt>(in.size());
    std::vector<std::byte> decoded(64 * 1024);
    int result = Z_OK;
    while (result == Z_OK) {
      stream.next_out = reinterpret_cast<Bytef*>(decoded.data());
      stream.avail_out = static_cast<uInt>(decoded.size());
      result = inflate(&stream, Z_NO_FLUSH);
      file_.inflated->append(std::span(decoded).first(decoded.size() - stream.avail_out));
    }
    inflateEnd(&stream);
    if (result != Z_STREAM_END)
      refuse(file_.path, "copy the file again", "the compressed data is cut short or damaged");
  }

  std::string bytes_of(const Element& e) const {
    if (e.length > longest_value) fail(e.begin);
    return file_.bytes(e.begin, e.end());
  }
  std::string text_of(const Element& e) const {
    auto text = bytes_of(e);
    while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
    return text;
  }

  /// Parses elements up to `end`, or to the delimiter of an item of undefined length. `into` is null when
  /// nothing is to be kept. Returns where they end.
  std::uint64_t parse_elements(std::uint64_t at, std::uint64_t end, const Encoding& encoding, DicomItem* into,
                               int depth) {
    if (depth > deepest) fail(at);
    while (at < end) {
      if (depth == 0 && file_.pixels && only_zeros(at)) {
        file_.end = at;
        return end;
      }
      const Element e = element_at(at, end, encoding);
      if (e.tag == item_end && depth > 0) return e.begin;
      if (e.tag.group == delimiter_group) fail(at);
      if (depth == 0 && e.tag.group == dicom::pixels.group) {
        at = parse_pixels(e, end);
        if (e.tag == dicom::pixels) file_.pixels->begin = e.begin, file_.pixels->end = at;
      } else
        at = parse_element(e, end, encoding, into, depth);
    }
    return end;
  }

  std::uint64_t parse_element(const Element& e, std::uint64_t end, const Encoding& encoding, DicomItem* into,
                              int depth) {
    const bool sequence = into != nullptr && std::ranges::count(kept_sequences, e.tag) > 0;
    if (!sequence && !e.open_ended()) {
      if (into != nullptr && e.length <= longest_value) keep(e, *into);
      return e.end();
    }
    std::vector<DicomItem> items;
    // UN of undefined length: its content is implicit whatever the file is (PS3.5, 6.2.2).
    const Encoding inner = e.vr == "UN" ? Encoding{.explicit_vr = false} : encoding;
    const auto after =
        parse_items(e, e.open_ended() ? end : e.end(), inner, sequence ? &items : nullptr, depth + 1);
    if (sequence && !into->sequences.emplace(e.tag, std::move(items)).second) fail_twice(e.tag);
    return after;
  }

  std::uint64_t parse_items(const Element& sequence, std::uint64_t end, const Encoding& encoding,
                            std::vector<DicomItem>* items, int depth) {
    for (auto at = sequence.begin; at < end;) {
      const Element e = element_at(at, end, encoding);
      if (e.tag == sequence_end && sequence.open_ended()) return e.begin;
      if (e.tag != item_begin) fail(at);
      if (items != nullptr) items->emplace_back();
      // Items that are not kept may be an icon's compressed pixels, without elements.
      if (items == nullptr && !e.open_ended())
        at = e.end();
      else
        at = parse_elements(e.begin, e.open_ended() ? end : e.end(), encoding,
                            items != nullptr ? &items->back() : nullptr, depth);
    }
    if (sequence.open_ended()) fail(end);
    return end;
  }

  void keep(const Element& e, DicomItem& into) {
    const auto group = e.tag.group;
    if (std::find(std::begin(kept_groups), std::end(kept_groups), group) == std::end(kept_groups)) return;
    const auto vr = dicom_entry(e.tag).vr;
    const bool binary = vr == "US" || vr == "UL" || vr == "FD";
    auto value = binary ? bytes_of(e) : text_of(e);
    if (encoding_.big_endian && binary) std::reverse(value.begin(), value.end());
    const bool counts = group == geometry_group || group == pixel_group;
    if (!value.empty() && !into.values.emplace(e.tag, std::move(value)).second && counts) fail_twice(e.tag);
  }

  [[noreturn]] void fail_twice(DicomTag tag) const {
    refuse(file_.path, "copy the file again", "element {} is there twice", to_string(tag));
  }

  std::uint64_t parse_pixels(const Element& e, std::uint64_t end) {
    if (e.tag == dicom::float_pixels || e.tag == dicom::double_pixels)
      refuse(file_.path, "convert it to integers, or to another format",
             "its pixels are floating-point numbers");
    if (e.tag != dicom::pixels && !e.open_ended()) return e.end();
    if (e.tag != dicom::pixels) fail(e.begin);
    if (file_.pixels) fail_twice(e.tag);
    file_.pixels.emplace();
    file_.pixels->encapsulated = e.open_ended();
    if (!e.open_ended()) {
      file_.pixels->fragments.push_back({e.begin, e.length});
      return e.end();
    }
    for (auto at = e.begin; at < end;) {
      const Element part = element_at(at, end, encoding_);
      if (part.tag == sequence_end) return part.begin;
      if (part.tag != item_begin || part.open_ended()) fail(at);
      file_.pixels->fragments.push_back({part.begin, part.length});
      at = part.end();
    }
    fail(end);
  }

  /// Some media pad a file to whole blocks.
  bool only_zeros(std::uint64_t at) const {
    std::vector<std::byte> window(64 * 1024);
    for (std::size_t got = 0; (got = file_.data->read_some(at, window)) > 0; at += got)
      if (std::any_of(window.begin(), window.begin() + std::ptrdiff_t(got),
                      [](std::byte b) { return b != std::byte{0}; }))
        return false;
    return true;
  }

  DicomFile& file_;
  Encoding encoding_;
};

}  // namespace

std::string to_string(DicomTag tag) { return fmt::format("({:04X},{:04X})", tag.group, tag.element); }

const std::string& DicomItem::text(DicomTag tag) const {
  static const std::string none;
  const auto found = values.find(tag);
  return found == values.end() ? none : found->second;
}

const std::vector<DicomItem>& DicomItem::items(DicomTag sequence) const {
  static const std::vector<DicomItem> none;
  const auto found = sequences.find(sequence);
  return found == sequences.end() ? none : found->second;
}

const DicomItem* DicomItem::first_item(DicomTag sequence) const {
  return items(sequence).empty() ? nullptr : &items(sequence).front();
}

std::vector<double> DicomItem::numbers(DicomTag tag) const {
  const auto& value = text(tag);
  const auto finite = [](double number) { return std::isfinite(number) ? number : NAN; };
  const auto binary = [&](auto number) -> std::vector<double> {
    if (value.size() != sizeof number) return {NAN};
    std::memcpy(&number, value.data(), sizeof number);
    return {finite(double(number))};
  };
  if (value.empty()) return {};
  const auto vr = dicom_entry(tag).vr;
  if (vr == "US") return binary(std::uint16_t{});
  if (vr == "UL") return binary(std::uint32_t{});
  if (vr == "FD") return binary(double{});
  std::vector<double> numbers;
  for (const auto part : split(value, "\\"))
    numbers.push_back(finite(number_in<double>(trimmed(std::string(part))).value_or(NAN)));
  return numbers;
}

std::string DicomFile::bytes(std::uint64_t begin, std::uint64_t to) const {
  std::string bytes(std::size_t(to - begin), '\0');
  data->read(begin, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

DicomEntry dicom_entry(DicomTag tag) {
  const auto& entry = gdcm::Global::GetInstance().GetDicts().GetDictEntry(gdcm::Tag(tag.group, tag.element));
  const auto count = entry.GetVM() == gdcm::VM::VM2_n ? 0 : entry.GetVM().GetLength();
  return {entry.GetName(), gdcm::VR::GetVRString(entry.GetVR()), count};
}

std::optional<DicomFile> read_dicom_file(const std::filesystem::path& path) {
  if (!is_dicom(path)) return {};
  DicomFile file;
  file.path = path;
  file.data = std::make_unique<InputFile>(path);
  Parser(file).parse();
  return file;
}

}  // namespace ringsplat::detail
