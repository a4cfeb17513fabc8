// PNG files by libpng, for builds without OpenImageIO.
#include <png.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <list>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "images/image_library.hpp"

namespace ringsplat {
namespace {

constexpr const char* rebuild = "build it with -DRINGSPLAT_WITH_OPENIMAGEIO=ON";

/// What libpng said last. Its errors leave by longjmp, so this is all that an error may touch.
struct PngError {
  std::array<char, 200> text{};
};

[[noreturn]] void leave(png_structp png, png_const_charp text) {
  auto* const error = static_cast<PngError*>(png_get_error_ptr(png));
  std::snprintf(error->text.data(), error->text.size(), "libpng: %s", text);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

constexpr int in_native_order =
    std::endian::native == std::endian::little ? PNG_TRANSFORM_SWAP_ENDIAN : PNG_TRANSFORM_IDENTITY;

/// The first `channels` of each pixel, as shares of the largest value.
template <class Stored>
void convert(const ImageShape& shape, png_bytepp rows, int channels, float* samples) {
  constexpr float step = 1.0F / float(std::numeric_limits<Stored>::max());
  for (int y = 0; y < shape.height; ++y)
    for (int x = 0; x < shape.width; ++x)
      for (int c = 0; c < channels; ++c)
        *samples++ = float(reinterpret_cast<const Stored*>(rows[y])[x * shape.channels + c]) * step;
}

/// A file whose pixels come as 8 or 16 bits a channel, whatever they are in it.
class PngFile final : public ImageFile {
 public:
  PngFile() = default;
  ~PngFile() override {
    png_destroy_read_struct(&png_, &info_, nullptr);
    if (file_ != nullptr) std::fclose(file_);
  }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  /// Returns what went wrong, or an empty text.
  std::string open(const std::string& path) {
    file_ = std::fopen(path.c_str(), "rb");
    if (file_ == nullptr) return std::strerror(errno);
    std::array<png_byte, 8> signature{};
    if (std::fread(signature.data(), 1, signature.size(), file_) != signature.size() ||
        png_sig_cmp(signature.data(), 0, signature.size()) != 0)
      return std::string("it is no PNG, and this build has no OpenImageIO for others: ") + rebuild;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &error_, leave, ignore_warning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) return no_memory;
    return read_all() ? std::string() : error_.text.data();
  }

  bool seek(int image) override { return image == 0; }
  ImageShape shape() const override {
    const int width = int(png_get_image_width(png_, info_)), height = int(png_get_image_height(png_, info_)),
              channels = png_get_channels(png_, info_);
    return {width,
            height,
            1,
            channels,
            channels % 2 == 0 ? channels - 1 : -1,
            is_wide() ? SampleType::uint16 : SampleType::uint8,
            is_wide() ? "uint16" : "uint8",
            std::uint64_t(width) * std::uint64_t(height) * std::uint64_t(channels * (is_wide() ? 2 : 1))};
  }
  std::string text(const std::string& name) const override {
    png_textp entries = nullptr;
    const int count = png_get_text(png_, info_, &entries, nullptr);
    for (int k = count - 1; k >= 0; --k)
      if (entries[k].key == (name == "ImageDescription" ? "Description" : name)) return entries[k].text;
    return {};
  }
  int number(const std::string& name) const override {
    return name == "oiio:UnassociatedAlpha" && shape().alpha_channel >= 0 ? 1 : 0;
  }

  std::string read(int image, int channels, SampleType type, void* samples) override {
    if (image != 0) return "a PNG holds one image";
    if (type != SampleType::float32) return "its samples cannot be read as this type";
    const auto as_shares = is_wide() ? convert<std::uint16_t> : convert<std::uint8_t>;
    as_shares(shape(), png_get_rows(png_, info_), channels, static_cast<float*>(samples));
    return {};
  }

 private:
  bool is_wide() const { return png_get_bit_depth(png_, info_) == 16; }

  bool read_all() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_init_io(png_, file_);
    png_set_sig_bytes(png_, 8);
    // It expands palettes, 1 to 4 bits and a transparent colour.
    png_read_png(png_, info_, PNG_TRANSFORM_EXPAND | in_native_order, nullptr);
    return true;
  }

  PngError error_;
  std::FILE* file_ = nullptr;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

/// Writes into memory; what is used behind setjmp lies in members.
class PngWriter {
 public:
  PngWriter(const ImageData& image, Bytes& file) : image_(image), file_(file) {
    const std::size_t row = std::size_t(image.width) * std::size_t(image.channels);
    auto* const first = static_cast<png_byte*>(const_cast<void*>(image.samples));  // libpng only reads them
    for (int y = 0; y < image.height; ++y) rows_.push_back(first + std::size_t(y) * row);
    for (const auto& [name, value] : image.attributes)
      if (const auto* const text = std::get_if<std::string>(&value); text != nullptr && is_text(name, *text))
        add_text(name == "ImageDescription" ? "Description" : name, *text);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  std::string write() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error_, leave, ignore_warning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) return no_memory;
    return write_all() ? std::string() : error_.text.data();
  }

 private:
  /// Other attributes tell OpenImageIO how to write.
  static bool is_text(const std::string& name, const std::string& text) {
    return !text.empty() && name.size() < 80 && !name.starts_with("oiio:") && name != "compression";
  }
  void add_text(std::string name, const std::string& text) {
    names_.push_back(std::move(name));
    png_text entry{};
    entry.compression = PNG_TEXT_COMPRESSION_NONE;
    entry.key = const_cast<char*>(names_.back().c_str());
    entry.text = const_cast<char*>(text.c_str());
    entry.text_length = text.size();
    texts_.push_back(entry);
  }

  static void append(png_structp png, png_bytep bytes, png_size_t count) {
    Bytes& file = static_cast<PngWriter*>(png_get_io_ptr(png))->file_;
    bool stored = true;
    try {
      file.insert(file.end(), reinterpret_cast<std::byte*>(bytes),
                  reinterpret_cast<std::byte*>(bytes) + count);
    } catch (const std::bad_alloc&) {
      stored = false;
    }
    if (!stored) png_error(png, no_memory);
  }

  bool write_all() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, this, append, nullptr);
    png_set_IHDR(png_, info_, png_uint_32(image_.width), png_uint_32(image_.height), 8,
                 image_.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_ABSOLUTE);
    if (!texts_.empty()) png_set_text(png_, info_, texts_.data(), int(texts_.size()));
    constexpr int run_lengths = 3;  // zlib's Z_RLE; both as images/image_io.cpp has them of OpenImageIO
    png_set_compression_strategy(png_, run_lengths);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
    png_set_rows(png_, info_, rows_.data());
    png_write_png(png_, info_, PNG_TRANSFORM_IDENTITY, nullptr);
    return true;
  }

  const ImageData& image_;
  Bytes& file_;
  std::vector<png_bytep> rows_;
  std::list<std::string> names_;
  std::vector<png_text> texts_;
  PngError error_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

class PngLibrary final : public ImageLibrary {
 public:
  OpenedImageFile open(const std::string& path) const override try {
    auto file = std::make_unique<PngFile>();
    if (std::string problem = file->open(path); !problem.empty()) return {nullptr, problem};
    return {std::move(file), {}};
  } catch (const std::exception& error) {
    return {nullptr, error.what()};
  }

  std::string write(const std::string& path, const ImageData& image, const std::string& /*spare*/,
                    Bytes& file) const override try {
    if (!path.ends_with(".png") && !path.ends_with(".PNG"))
      return std::string("this build has no OpenImageIO and writes PNG only: ") + rebuild;
    if (image.type != SampleType::uint8 || image.channels < 3 || image.channels > 4)
      return "this build writes 3 or 4 channels of 8 bits";
    return PngWriter(image, file).write();
  } catch (const std::exception& error) {
    return error.what();
  }

  std::string draw_text(const std::string&, int, const std::string&, Mask&) const override {
    return std::string("this build has no OpenImageIO: ") + rebuild;
  }
};

}  // namespace
}  // namespace ringsplat

extern "C" __attribute__((visibility("default"))) const ringsplat::ImageLibrary* ringsplat_image_library() {
  static const ringsplat::PngLibrary library;
  return &library;
}
