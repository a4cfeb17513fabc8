#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "images/image_library.hpp"

namespace ringsplat {
namespace {

using OIIO::TypeDesc;

/// By SampleType.
constexpr TypeDesc::BASETYPE types[] = {TypeDesc::INT8,  TypeDesc::UINT8,  TypeDesc::INT16, TypeDesc::UINT16,
                                        TypeDesc::INT32, TypeDesc::UINT32, TypeDesc::FLOAT, TypeDesc::DOUBLE,
                                        TypeDesc::HALF,  TypeDesc::UNKNOWN};

TypeDesc type_desc(SampleType type) { return types[std::size_t(type)]; }

SampleType sample_type(TypeDesc type) {
  return SampleType(std::find(std::begin(types), std::end(types) - 1, type.basetype) - std::begin(types));
}

class OpenedFile final : public ImageFile {
 public:
  explicit OpenedFile(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}

  bool seek(int image) override { return input_->seek_subimage(image, 0); }

  ImageShape shape() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    return {spec.width,          spec.height,
            spec.depth,          spec.nchannels,
            spec.alpha_channel,  sample_type(spec.format),
            spec.format.c_str(), spec.image_bytes(true),
            spec.z_channel};
  }

  std::string text(const std::string& name) const override {
    return input_->spec().get_string_attribute(name);
  }
  int number(const std::string& name) const override { return input_->spec().get_int_attribute(name); }

  std::string read(int image, int channels, SampleType type, void* samples) override try {
    if (input_->read_image(image, 0, 0, channels, type_desc(type), samples)) return {};
    return input_->geterror();
  } catch (const std::exception& error) {
    return error.what();
  }

 private:
  std::unique_ptr<OIIO::ImageInput> input_;
};

/// OpenImageIO keeps every text that it was ever given, and each picture of a film has its own. So its writer
/// is given one that is the same for all texts of a length, whose place in the file the text then takes.
struct StandIn {
  StandIn() = default;
  explicit StandIn(const ImageData& image) {
    constexpr std::size_t worth_it = 64;
    for (const auto& [name, value] : image.attributes)
      if (const auto* said = std::get_if<std::string>(&value); said != nullptr && said->size() >= worth_it)
        text = *said;
    given.assign(text.size(), '~');
  }
  std::string text, given;  ///< empty: none
};

OIIO::ImageSpec spec_of(const ImageData& image, const StandIn& stand_in) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, type_desc(image.type));
  for (const auto& [name, value] : image.attributes)
    if (const auto* text = std::get_if<std::string>(&value))
      spec.attribute(name, !text->empty() && *text == stand_in.text ? stand_in.given : *text);
    else
      spec.attribute(name, std::get<int>(value));
  if (!image.has_depth) return spec;
  spec.z_channel = image.channels - 1;
  spec.channelnames.back() = "Z";
  if (spec.alpha_channel == spec.z_channel) spec.alpha_channel = -1;
  return spec;
}

/// Keeps a file's bytes. OpenImageIO's PNG, TGA and JPEG writers ignore failed writes, so it remembers them;
/// no exception may pass through the writers' libraries.
class BytesProxy final : public OIIO::Filesystem::IOProxy {
 public:
  BytesProxy(const std::string& path, Bytes& bytes) : IOProxy(path, Write), bytes_(bytes) {}
  const char* proxytype() const override { return "ringsplat"; }
  size_t write(const void* from, size_t count) override {
    const size_t written = pwrite(from, count, m_pos);
    m_pos += static_cast<int64_t>(written);
    return written;
  }
  size_t pwrite(const void* from, size_t count, int64_t offset) override try {
    bytes_.resize(std::max(bytes_.size(), std::size_t(offset) + count), std::byte{0});
    if (count > 0) std::memcpy(bytes_.data() + offset, from, count);  // `from` may else be null
    return count;
  } catch (const std::bad_alloc&) {
    failed_ = true;
    return 0;
  }
  size_t size() const override { return bytes_.size(); }
  bool failed() const { return failed_; }

 private:
  Bytes& bytes_;
  bool failed_ = false;
};

/// `png`: the text ends a chunk, behind its type and a key, and a sum over all of it follows.
void put_text(const StandIn& stand_in, bool png, Bytes& file) {
  constexpr std::size_t most = std::size_t{1} << 20;  // metadata come before the pixels
  auto* const bytes = reinterpret_cast<char*>(file.data());
  const std::string_view head(bytes, std::min(most, file.size()));
  const std::size_t length = stand_in.text.size();
  for (std::size_t at = 0; length > 0 && (at = head.find(stand_in.given, at)) != std::string::npos;
       at += length) {
    stand_in.text.copy(bytes + at, length);
    if (const std::size_t chunk = head.rfind("tEXt", at); png && chunk != std::string::npos) {
      const auto sum = crc32(0, reinterpret_cast<const Bytef*>(bytes + chunk), uInt(at + length - chunk));
      for (std::size_t k = 0; k < 4; ++k) bytes[at + length + k] = char(sum >> (24 - 8 * k));
    }
  }
}

/// OpenImageIO 2.4's TIFF writer claims to, but it loses the first of two directories, since it cannot read
/// back through a proxy.
bool writes_to_proxies(const OIIO::ImageOutput& output) {
  return output.supports("ioproxy") != 0 && std::string_view(output.format_name()) != "tiff";
}

/// Why the file does not hold a whole image of that format and shape; empty when it does.
std::string damage_of(const std::string& format, const std::string& name, const OIIO::ImageSpec& spec) {
  const auto input = OIIO::ImageInput::create(format);
  if (!input) return OIIO::geterror();
  OIIO::ImageSpec found;
  if (!input->open(name, found)) return input->geterror();
  if (found.width != spec.width || found.height != spec.height || found.nchannels != spec.nchannels)
    return "what was written is another image";
  std::vector<std::byte> samples(found.image_bytes(true));
  return input->read_image(0, 0, 0, found.nchannels, OIIO::TypeDesc::UNKNOWN, samples.data())
             ? std::string()
             : input->geterror();
}

/// Before 2.4.15 the library draws wrong letters for those beyond ASCII (its issue 3933): micro becomes u,
/// all others question marks.
std::string drawable(const std::string& text) {
  if (OIIO_VERSION >= 20415) return text;
  std::string ascii;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    const auto letter = std::string_view(text).substr(k, 2);
    if (byte < 0x80)
      ascii += text[k];
    else if (byte >= 0xC0)  // the first of a letter's bytes
      ascii += letter == "\xC2\xB5" || letter == "\xCE\xBC" ? 'u' : '?';
  }
  return ascii;
}

class OpenImageIo final : public ImageLibrary {
 public:
  OpenedImageFile open(const std::string& path) const override try {
    OIIO::ImageSpec keep_straight;
    keep_straight.attribute("oiio:UnassociatedAlpha", 1);
    auto input = OIIO::ImageInput::open(path, &keep_straight);
    if (!input) return {nullptr, OIIO::geterror()};
    return {std::make_unique<OpenedFile>(std::move(input)), {}};
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }

  std::string write(const std::string& path, const ImageData& image, const std::string& spare,
                    Bytes& file) const override try {
    BytesProxy proxy(path, file);
    const auto output = OIIO::ImageOutput::create(path);
    if (!output) return OIIO::geterror();
    const bool to_memory = writes_to_proxies(*output) && output->set_ioproxy(&proxy);
    const std::string& name = to_memory ? path : spare;
    const std::string_view format = output->format_name();
    const bool patched = to_memory && (format == "png" || format == "openexr");
    const StandIn stand_in = patched ? StandIn(image) : StandIn();
    const OIIO::ImageSpec spec = spec_of(image, stand_in);
    const bool written =
        output->open(name, spec) && output->write_image(spec.format, image.samples) && output->close();
    if (proxy.failed()) return no_memory;
    if (!written) return output->geterror();
    put_text(stand_in, format == "png", file);
    return to_memory ? std::string() : damage_of(output->format_name(), name, spec);
  } catch (const std::exception& error) {
    return error.what();
  }

  std::string draw_text(const std::string& given, int pixels, const std::string& font,
                        Mask& drawn) const override try {
    const std::string text = drawable(given);
    const OIIO::ROI size = OIIO::ImageBufAlgo::text_size(text, pixels, font);
    if (!size.defined()) return OIIO::has_error() ? OIIO::geterror() : "the font cannot be read";
    // The ends of a text without ink are no numbers to reckon with.
    if (size.xend <= size.xbegin || size.yend <= size.ybegin) return {};
    drawn = {size.xbegin, size.ybegin, size.width(), size.height(), {}};
    drawn.coverage.assign(std::size_t(size.width()) * std::size_t(size.height()), 0.0F);
    OIIO::ImageBuf canvas(OIIO::ImageSpec(drawn.width, drawn.height, 1, TypeDesc::FLOAT),
                          drawn.coverage.data());
    const float ink = 1;
    const bool done = OIIO::ImageBufAlgo::render_text(canvas, -drawn.x, -drawn.y, text, pixels, font, ink);
    return done ? std::string() : canvas.geterror();
  } catch (const std::exception& error) {
    return error.what();
  }
};

}  // namespace
}  // namespace ringsplat

extern "C" __attribute__((visibility("default"))) const ringsplat::ImageLibrary* ringsplat_image_library() {
  static const ringsplat::OpenImageIo library;
  return &library;
}
