#include "decode/dicom/elements.hpp"

#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <new>
#include <span>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t preamble = 128;
constexpr std::uint32_t undefined_length = 0xFFFFFFFF;
constexpr int deepest = 32;  // nested sequences

constexpr DicomTag transfer_syntax{0x0002, 0x0010}, meta_storage_class{0x0002, 0x0002};
constexpr DicomTag item_begin{0xFFFE, 0xE000}, item_end{0xFFFE, 0xE00D}, sequence_end{0xFFFE, 0xE0DD};
/// Sequences that say something of the pixels; the items of others are not kept.
constexpr DicomTag kept_sequences[] = {
    dicom::regions,           dicom::xray_acquisition, dicom::detectors,
    dicom::shared_groups,     dicom::frame_groups,     dicom::plane_position,
    dicom::plane_orientation, dicom::pixel_measures,   dicom::pixel_transformation,
    dicom::frame_content};
constexpr std::uint16_t delimiter_group = 0xFFFE;

/// Of elements that are kept.
constexpr std::uint16_t geometry_group = 0x0020, pixel_group = 0x0028;
constexpr std::uint16_t kept_groups[] = {0x0008, 0x0018, geometry_group, pixel_group, 0x3002, 0x3004};

struct Element {
  DicomTag tag;
  std::string_view vr = {};        ///< empty where the encoding has none
  std::size_t begin = 0, end = 0;  ///< of its value; of an open-ended one that of what contains it
  bool open_ended = false;         ///< a delimiter ends it
};

struct Encoding {
  bool explicit_vr = true, big_endian = false;
};

class Parser {
 public:
  explicit Parser(DicomFile& file) : file_(file) {}

  void parse() {
    parse_meta();
    // PS3.6, table A-1; every compressed syntax has explicit element headers.
    const auto& uid = file_.transfer_syntax;
    encoding_ = {.explicit_vr = !uid.empty() && uid != "1.2.840.10008.1.2", .big_endian = file_.big_endian()};
    if (file_.deflated()) inflate();
    parse_elements(file_.data.size(), encoding_, &file_.elements, 0);
    if (!file_.pixels && !file_.elements.text(dicom::rows).empty()) fail(file_.data.size());
  }

 private:
  [[noreturn]] void fail(std::size_t at) const {
    throw InputError(fmt::format("{} is cut short or damaged at byte {}", file_.path.string(), at),
                     "copy the file again");
  }
  [[noreturn]] void fail_twice(DicomTag tag) const {
    refuse(file_.path, "copy the file again", "element {} is there twice", to_string(tag));
  }

  /// Goes on to its value. `end`: of what contains the element.
  Element next_element(std::size_t end, const Encoding& encoding) {
    constexpr std::size_t short_header = 8, long_header = 12;
    const auto header = file_.data.substr(at_, std::min(long_header, end - at_));
    if (header.size() < short_header) fail(end);
    const BinaryFields fields(std::as_bytes(std::span(header)), encoding.big_endian);
    Element e{.tag = {fields.at<std::uint16_t>(0), fields.at<std::uint16_t>(2)}, .begin = at_ + short_header};
    auto length = fields.at<std::uint32_t>(4);
    if (encoding.explicit_vr && e.tag.group != delimiter_group) {
      e.vr = header.substr(4, 2);
      if (!std::ranges::all_of(e.vr, [](unsigned char c) { return std::isupper(c) != 0; })) fail(at_ + 4);
      length = fields.at<std::uint16_t>(6);
      constexpr std::string_view long_vrs = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
      if (long_vrs.find(e.vr) != std::string_view::npos) {
        if (header.size() < long_header) fail(end);
        e.begin = at_ + long_header;
        length = fields.at<std::uint32_t>(8);
      }
    }
    e.open_ended = length == undefined_length;
    e.end = e.open_ended ? end : e.begin + length;
    if (e.end > end) fail(end);
    at_ = e.begin;
    return e;
  }

  /// Meta elements are always explicit and little-endian; they end where another group begins.
  void parse_meta() {
    at_ = preamble + 4;
    while (file_.data.substr(at_, 2) == "\x02\0"sv) {
      const Element e = next_element(file_.data.size(), {});
      if (e.open_ended) fail(e.begin);
      if (e.tag == transfer_syntax) file_.transfer_syntax = text_of(e);
      if (e.tag == meta_storage_class) file_.storage_class = text_of(e);
      at_ = e.end;
    }
  }

  /// Goes on in what a raw deflate stream (RFC 1951) holds.
  void inflate() {
    constexpr int no_header = -15;  // zlib.h, inflateInit2
    std::string in(file_.data.substr(at_)), part(64 * 1024, '\0');
    const auto inflated = std::make_shared<std::string>();
    z_stream stream{};
    if (inflateInit2(&stream, no_header) != Z_OK) throw std::bad_alloc();
    stream.next_in = reinterpret_cast<Bytef*>(in.data());
    stream.avail_in = static_cast<uInt>(in.size());
    int result = Z_OK;
    while (result == Z_OK) {
      stream.next_out = reinterpret_cast<Bytef*>(part.data());
      stream.avail_out = static_cast<uInt>(part.size());
      result = ::inflate(&stream, Z_NO_FLUSH);
      inflated->append(part, 0, part.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    if (result != Z_STREAM_END)
      refuse(file_.path, "copy the file again", "the compressed data is cut short or damaged");
    file_.memory = inflated;
    file_.data = *inflated;
    at_ = 0;
  }

  std::string_view value_of(const Element& e) const { return file_.data.substr(e.begin, e.end - e.begin); }
  std::string text_of(const Element& e) const {
    const auto value = value_of(e);
    return std::string(value.substr(0, value.find_last_not_of("\0 "sv) + 1));
  }

  /// Parses elements up to `end`, or to the delimiter of an open-ended item. `into` is null when nothing is
  /// to be kept.
  void parse_elements(std::size_t end, const Encoding& encoding, DicomItem* into, int depth) {
    if (depth > deepest) fail(at_);
    while (at_ < end) {
      // Some media pad a file to whole blocks.
      if (depth == 0 && file_.pixels && file_.data.find_first_not_of('\0', at_) == std::string_view::npos) {
        file_.data = file_.data.substr(0, at_);
        return;
      }
      const auto begin = at_;
      const Element e = next_element(end, encoding);
      if (e.tag == item_end && depth > 0) return;
      if (e.tag.group == delimiter_group) fail(begin);
      if (depth == 0 && e.tag.group == dicom::pixels.group)
        parse_pixels(e);
      else
        parse_element(e, encoding, into, depth);
    }
  }

  void parse_element(const Element& e, const Encoding& encoding, DicomItem* into, int depth) {
    const bool sequence = into != nullptr && std::ranges::count(kept_sequences, e.tag) > 0;
    if (!sequence && !e.open_ended) {
      if (into != nullptr && std::ranges::count(kept_groups, e.tag.group) > 0) keep(e, *into);
      at_ = e.end;
      return;
    }
    std::vector<DicomItem> items;
    // UN of undefined length: its content is implicit whatever the file is (PS3.5, 6.2.2).
    const Encoding inner = e.vr == "UN" ? Encoding{.explicit_vr = false} : encoding;
    parse_items(e, inner, sequence ? &items : nullptr, depth + 1);
    if (sequence && !into->sequences.emplace(e.tag, std::move(items)).second) fail_twice(e.tag);
  }

  void parse_items(const Element& sequence, const Encoding& encoding, std::vector<DicomItem>* items,
                   int depth) {
    while (at_ < sequence.end) {
      const auto begin = at_;
      const Element e = next_element(sequence.end, encoding);
      if (e.tag == sequence_end && sequence.open_ended) return;
      if (e.tag != item_begin) fail(begin);
      if (items != nullptr) items->emplace_back();
      // Items that are not kept may be an icon's compressed pixels, without elements.
      if (items == nullptr && !e.open_ended)
        at_ = e.end;
      else
        parse_elements(e.end, encoding, items != nullptr ? &items->back() : nullptr, depth);
    }
    if (sequence.open_ended) fail(sequence.end);
  }

  void keep(const Element& e, DicomItem& into) {
    const auto vr = dicom_entry(e.tag).vr;
    const bool binary = vr == "US" || vr == "UL" || vr == "FD";
    auto value = binary ? std::string(value_of(e)) : text_of(e);
    if (encoding_.big_endian && binary) std::reverse(value.begin(), value.end());
    const bool counts = e.tag.group == geometry_group || e.tag.group == pixel_group;
    if (!value.empty() && !into.values.emplace(e.tag, std::move(value)).second && counts) fail_twice(e.tag);
  }

  void parse_pixels(const Element& e) {
    if (e.tag == dicom::float_pixels || e.tag == dicom::double_pixels)
      refuse(file_.path, "convert it to integers, or to another format",
             "its pixels are floating-point numbers");
    if (e.tag != dicom::pixels && e.open_ended) fail(e.begin);
    if (e.tag == dicom::pixels && file_.pixels) fail_twice(e.tag);
    if (!e.open_ended) at_ = e.end;
    if (e.tag != dicom::pixels) return;
    auto& pixels = file_.pixels.emplace();
    pixels.encapsulated = e.open_ended;
    pixels.begin = e.begin;
    if (!e.open_ended) pixels.fragments = {value_of(e)};
    while (e.open_ended) {
      const Element part = next_element(e.end, encoding_);
      if (part.tag == sequence_end) break;
      if (part.tag != item_begin || part.open_ended) fail(part.begin);
      pixels.fragments.push_back(value_of(part));
      at_ = part.end;
    }
    pixels.end = at_;
  }

  DicomFile& file_;
  Encoding encoding_;
  std::size_t at_ = 0;  ///< in its data
};

}  // namespace

std::string to_string(DicomTag tag) { return fmt::format("({:04X},{:04X})", tag.group, tag.element); }

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
  return mapped(split(value, "\\"), [&](std::string_view part) {
    return finite(number_in<double>(trimmed(part)).value_or(NAN));
  });
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
  const InputFile input(path);
  const auto bytes = input.mapped();
  file.memory = bytes;
  file.data = {bytes.get(), std::size_t(input.size())};
  Parser(file).parse();
  return file;
}

}  // namespace ringsplat::detail
