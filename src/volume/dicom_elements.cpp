#include "volume/dicom_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string>
#include <string_view>

#include "ringsplat/base/error.hpp"
#include "volume/input_file.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t preamble = 128;
constexpr std::uint32_t undefined_length = 0xFFFFFFFF;

struct Tag {
  std::uint16_t group = 0, element = 0;
  bool operator==(const Tag&) const = default;
};
constexpr Tag transfer_syntax{0x0002, 0x0010}, pixel_data{0x7FE0, 0x0010};
constexpr Tag item{0xFFFE, 0xE000}, sequence_end{0xFFFE, 0xE0DD};
constexpr std::uint16_t meta_group = 0x0002, image_group = 0x0028, delimiter_group = 0xFFFE;

struct Element {
  Tag tag;
  std::uint64_t begin = 0;  ///< of its value in the file
  std::uint32_t length = 0;
  bool unknown = false;  ///< VR UN: when open-ended, its content is encoded otherwise
};

enum class Encoding { explicit_vr, implicit_vr, not_followed };

class Walker {
 public:
  explicit Walker(const std::filesystem::path& path) : file_(path) {}

  bool is_dicom() const {
    std::array<std::byte, 4> magic{};
    return file_.read_some(preamble, magic) == magic.size() && as_text(magic) == "DICM";
  }

  DicomElements follow() {
    std::uint64_t at = preamble + 4;
    Encoding encoding = follow_meta(at);
    DicomElements found;
    if (encoding == Encoding::not_followed) return not_followed();
    // An undefined length means that the content follows as elements of its own until a delimiter.
    for (int depth = 0; at < file_.size();) {
      const Element e = element_at(at, encoding);
      const bool open_ended = e.length == undefined_length;
      if (e.tag == pixel_data && depth == 0) {
        found.has_pixels = true;
        if (open_ended) return found;
        require_within(e);
        found.pixel_bytes = e.length;
        return found;
      }
      if (open_ended && e.unknown) return not_followed();
      if (e.tag == sequence_end)
        --depth;
      else if (open_ended && e.tag != item)
        ++depth;
      if (!open_ended) require_within(e);
      if (depth == 0) note(e, found);
      at = e.begin + (open_ended ? 0 : e.length);
    }
    return {};
  }

 private:
  static DicomElements not_followed() { return {.has_pixels = true, .followed = false}; }

  /// PS3.3, section C.7.6.3: the sizes are unsigned 16-bit numbers.
  void note(const Element& e, DicomElements& found) const {
    if (e.tag.group != image_group || e.length != 2) return;
    int* const value = e.tag.element == 0x0002   ? &found.samples
                       : e.tag.element == 0x0010 ? &found.rows
                       : e.tag.element == 0x0011 ? &found.columns
                       : e.tag.element == 0x0100 ? &found.bits_allocated
                                                 : nullptr;
    if (value == nullptr) return;
    std::array<std::byte, 2> bytes{};
    file_.read(e.begin, bytes);
    *value = int(little(as_text(bytes)));
  }

  template <std::size_t N>
  static std::string_view as_text(const std::array<std::byte, N>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), N};
  }

  static std::uint32_t little(std::string_view bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = bytes.size(); i > 0; --i)
      value = value << 8 | static_cast<unsigned char>(bytes[i - 1]);
    return value;
  }

  [[noreturn]] void fail(std::uint64_t at) const {
    throw InputError(fmt::format("{} is cut short or damaged at byte {}", file_.path().string(), at),
                     "copy the file again");
  }

  void require_within(const Element& e) const {
    if (e.begin + e.length > file_.size()) fail(file_.size());
  }

  /// Meta elements are always explicit; their end is where another group begins.
  Encoding follow_meta(std::uint64_t& at) const {
    Encoding encoding = Encoding::implicit_vr;
    while (at < file_.size()) {
      const Element e = element_at(at, Encoding::explicit_vr, true);
      if (e.tag.group != meta_group) break;
      require_within(e);
      if (e.tag == transfer_syntax) encoding = encoding_of(e);
      at = e.begin + e.length;
    }
    return encoding;
  }

  /// PS3.6, table A-1; every compressed syntax has explicit element headers.
  Encoding encoding_of(const Element& e) const {
    std::string uid(std::min<std::uint32_t>(e.length, 64), '\0');
    file_.read(e.begin, std::as_writable_bytes(std::span(uid)));
    while (!uid.empty() && (uid.back() == '\0' || uid.back() == ' ')) uid.pop_back();
    if (uid == "1.2.840.10008.1.2") return Encoding::implicit_vr;
    const bool big_endian = uid == "1.2.840.10008.1.2.2", deflated = uid == "1.2.840.10008.1.2.1.99";
    return big_endian || deflated ? Encoding::not_followed : Encoding::explicit_vr;
  }

  /// `meta_only`: the element of another group may be encoded in any way, only its tag is wanted.
  Element element_at(std::uint64_t at, Encoding encoding, bool meta_only = false) const {
    std::array<std::byte, 12> header{};
    const auto got = file_.read_some(at, header);
    const auto text = as_text(header).substr(0, got);
    if (got < 8) fail(file_.size());
    Element e;
    e.tag = {std::uint16_t(little(text.substr(0, 2))), std::uint16_t(little(text.substr(2, 2)))};
    if (meta_only && e.tag.group != meta_group) return e;
    const bool has_vr = encoding == Encoding::explicit_vr && e.tag.group != delimiter_group;
    e.begin = at + 8;
    e.length = has_vr ? little(text.substr(6, 2)) : little(text.substr(4, 4));
    if (!has_vr) return e;
    const auto vr = text.substr(4, 2);
    if (std::isupper(static_cast<unsigned char>(vr[0])) == 0 ||
        std::isupper(static_cast<unsigned char>(vr[1])) == 0)
      fail(at + 4);
    constexpr std::string_view long_vrs = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    if (long_vrs.find(vr) == std::string_view::npos) return e;
    if (got < header.size()) fail(file_.size());
    e.begin = at + header.size();
    e.length = little(text.substr(8, 4));
    e.unknown = vr == "UN";
    return e;
  }

  InputFile file_;
};

}  // namespace

std::optional<DicomElements> follow_dicom_elements(const std::filesystem::path& path) {
  Walker walker(path);
  if (!walker.is_dicom()) return {};
  return walker.follow();
}

}  // namespace ringsplat::detail
