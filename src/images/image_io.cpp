#include "images/image_io.hpp"

#include <array>
#include <bit>
#include <limits>
#include <utility>

#include "base/output_file.hpp"
#include "base/srgb.hpp"
#include "base/text.hpp"
#include "images/image_file.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* ending;
  bool linear_float, alpha;
};
constexpr Format formats[] = {{".exr", true, true},   {".png", false, true}, {".tif", false, true},
                              {".tiff", false, true}, {".tga", false, true}, {".jpg", false, false},
                              {".jpeg", false, false}};

const Format* format_of(const fs::path& file) {
  const std::string ending = detail::lower_case(file.extension().string());
  const auto found = std::ranges::find(formats, ending, &Format::ending);
  return found == std::end(formats) ? nullptr : found;
}

/// Pixels as RGBA, or as RGB over a background.
Image::Floats linear_pixels(const Image& image, const std::optional<glm::dvec3>& background) {
  if (!background) return image.rgba;
  Image::Floats rgb(image.rgba.size() / 4 * 3);
  const glm::vec3 behind(*background);
  for (std::size_t p = 0; p < image.rgba.size() / 4; ++p) {
    const float left = 1 - image.rgba[4 * p + 3];
    for (int c = 0; c < 3; ++c)
      rgb[3 * p + std::size_t(c)] = image.rgba[4 * p + std::size_t(c)] + left * behind[c];
  }
  return rgb;
}

/// The same bytes as to_byte(linear_to_srgb(v)) without a power for each value, which would take longer than
/// rendering.
class SrgbBytes {
 public:
  SrgbBytes() {
    for (int byte = 1; byte < 256; ++byte) first_[std::size_t(byte)] = first_with(byte);
    first_[256] = std::numeric_limits<float>::infinity();
    int byte = 0;
    for (std::size_t k = 0; k < guess_.size(); ++k) {
      const float low = float(k) / float(guess_.size() - 1);
      while (low >= first_[std::size_t(byte) + 1]) ++byte;
      guess_[k] = static_cast<std::uint8_t>(byte);
    }
  }
  /// `v` in [0, 1]; not-a-number becomes 0.
  std::uint8_t operator()(float v) const {
    if (!(v > 0)) return 0;
    std::size_t byte = guess_[static_cast<std::size_t>(v * float(guess_.size() - 1))];
    while (v >= first_[byte + 1]) ++byte;
    return static_cast<std::uint8_t>(byte);
  }

 private:
  /// The least float that becomes `byte` or more. Non-negative floats sort like their bits.
  static float first_with(int byte) {
    std::uint32_t below = 0, from = std::bit_cast<std::uint32_t>(1.0F);
    while (from - below > 1) {
      const std::uint32_t middle = below + (from - below) / 2;
      (to_byte(linear_to_srgb(std::bit_cast<float>(middle))) >= byte ? from : below) = middle;
    }
    return std::bit_cast<float>(from);
  }

  std::array<float, 257> first_{};          ///< by byte: the least float that becomes it
  std::array<std::uint8_t, 4097> guess_{};  ///< the byte of k / 4096
};

std::vector<std::uint8_t> display_pixels(const Image::Floats& linear, std::size_t channels) {
  static const SrgbBytes to_srgb;
  std::vector<std::uint8_t> bytes(linear.size());
  for (std::size_t at = 0; at < linear.size(); at += channels) {
    const float alpha = channels == 4 ? linear[at + 3] : 1.0F;
    for (std::size_t c = 0; c < 3; ++c)
      bytes[at + c] = alpha > 0 ? to_srgb(std::min(linear[at + c] / alpha, 1.0F)) : std::uint8_t{0};
    if (channels == 4) bytes[at + 3] = to_byte(alpha);
  }
  return bytes;
}

std::vector<ImageData::Attribute> attributes_of(const Format& format, const std::string& settings) {
  std::vector<ImageData::Attribute> attributes{{"Software", "ringsplat " RINGSPLAT_VERSION}};
  const auto add = [&](const char* name, auto value) { attributes.push_back({name, value}); };
  if (!settings.empty()) {
    add("ImageDescription", settings);
    add("ringsplat:settings", settings);
  }
  add("oiio:ColorSpace", format.linear_float ? "Linear" : "sRGB");
  if (!format.linear_float) add("oiio:UnassociatedAlpha", 1);
  const std::string ending = format.ending;
  // Otherwise these writers add the time, and equal pictures give different files.
  if (ending == ".exr" || ending == ".tif" || ending == ".tiff") add("DateTime", "");
  // A tenth of the usual way's time, and about as small a file: run lengths, and each row less the one above.
  constexpr int filter_up = 32;
  if (ending == ".png") add("compression", "rle"), add("png:filter", filter_up);
  if (ending == ".jpg" || ending == ".jpeg") add("compression", "jpeg:95");
  return attributes;
}

/// A file's channels as RGBA: grey becomes three channels, a missing alpha opaque.
Image as_rgba(const ImageShape& shape, const std::vector<float>& values) {
  Image image(shape.width, shape.height);
  const int alpha = shape.alpha_channel, channels = shape.channels;
  const bool grey = channels - (alpha >= 0 ? 1 : 0) < 3;
  for (std::size_t p = 0; p < image.rgba.size() / 4; ++p) {
    const float* from = values.data() + p * std::size_t(channels);
    float* to = image.rgba.data() + 4 * p;
    for (int c = 0; c < 3; ++c) to[c] = from[grey ? 0 : c];
    to[3] = alpha >= 0 ? from[alpha] : 1.0F;
    if (shape.depth_channel >= 0) image.depth.push_back(from[shape.depth_channel]);
  }
  return image;
}

/// An image as a file of that format holds it. What `data` names lies in the rest.
struct FilePixels {
  FilePixels(const Image& image, const Format& format, const std::optional<glm::dvec3>& background,
             const std::string& settings, const Overlay& overlay)
      : linear(linear_pixels(image, background)),
        data{image.width,        image.height,
             background ? 3 : 4, format.linear_float ? SampleType::float32 : SampleType::uint8,
             linear.data(),      attributes_of(format, settings)} {
    if (format.linear_float) {
      lay_over(overlay, image.width, image.height, data.channels, std::span<float>(linear));
      if (!image.depth.empty()) add_depth(image.depth);
      return;
    }
    display = display_pixels(linear, std::size_t(data.channels));
    lay_over(overlay, image.width, image.height, data.channels, std::span<std::uint8_t>(display));
    data.samples = display.data();
  }
  FilePixels(const FilePixels&) = delete;
  FilePixels& operator=(const FilePixels&) = delete;

  void add_depth(const Image::Floats& depth) {
    Image::Floats all;
    all.reserve(linear.size() + depth.size());
    for (auto pixel = linear.begin(); const float z : depth) {
      for (int c = 0; c < data.channels; ++c) all.push_back(*pixel++);
      all.push_back(z);
    }
    linear = std::move(all);
    data.samples = linear.data();
    ++data.channels;
    data.has_depth = true;
  }

  Image::Floats linear;
  std::vector<std::uint8_t> display;
  ImageData data;
};

}  // namespace

void check_image_name(const fs::path& file, const std::string& option, bool transparent) {
  const Format* format = format_of(file);
  if (format == nullptr)
    throw InputError(fmt::format("{} {} has no ending of a known picture format", option, file.string()),
                     "use .png, .exr, .tif, .tga or .jpg");
  if (transparent && !format->alpha)
    throw InputError(fmt::format("{} {}: this format cannot hold transparency", option, file.string()),
                     "give a --background, or write a .png");
}

void write_image(const Image& image, const fs::path& file, const std::optional<glm::dvec3>& background,
                 const std::string& settings, const Overlay& overlay) {
  check_image_name(file, "the picture", !background);
  OutputFile out(file);
  out.write(image_file_bytes(file.string(),
                             FilePixels(image, *format_of(file), background, settings, overlay).data));
  out.commit();
}

void write_image(const Image& image, const fs::path& file, const std::optional<glm::dvec3>& background) {
  write_image(image, file, background, {});
}

Bytes image_bytes(const Image& image, const std::string& ending, const std::optional<glm::dvec3>& background,
                  const std::string& settings, const Overlay& overlay) {
  const std::string file = "picture" + ending;
  check_image_name(file, "the picture", !background);
  return image_file_bytes(file, FilePixels(image, *format_of(file), background, settings, overlay).data);
}

std::vector<std::uint8_t> display_bytes(const Image& image, const std::optional<glm::dvec3>& background,
                                        const Overlay& overlay) {
  return FilePixels(image, *format_of("picture.png"), background, {}, overlay).display;
}

StoredImage read_image(const fs::path& file) {
  const auto bad = [&](const std::string& why) {
    return InputError(fmt::format("{} is not a readable picture: {}", file.string(), detail::one_line(why)),
                      "compare works on .png, .exr, .tif and the like");
  };
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored))
    throw InputError(fmt::format("there is no picture {}", file.string()), "check the path");
  const auto [opened, problem] = open_image_file(file);
  if (!opened) throw bad(problem);
  const ImageShape shape = opened->shape();
  if (shape.width < 1 || shape.height < 1 || shape.depth > 1 || shape.channels < 1)
    throw bad("it is not one flat picture");
  std::vector<float> values(std::size_t(shape.width) * std::size_t(shape.height) *
                            std::size_t(shape.channels));
  if (const std::string failure = opened->read(0, shape.channels, SampleType::float32, values.data());
      !failure.empty())
    throw bad(failure);

  const std::string settings = opened->text("ringsplat:settings");
  using enum SampleType;
  const bool linear = shape.type == float16 || shape.type == float32 || shape.type == float64;
  StoredImage stored{as_rgba(shape, values), linear, shape.alpha_channel >= 0,
                     settings.empty() ? opened->text("ImageDescription") : settings};
  if (stored.has_alpha && opened->number("oiio:UnassociatedAlpha") != 0)
    for (std::size_t at = 0; at < stored.image.rgba.size(); at += 4)
      for (std::size_t c = 0; c < 3; ++c) stored.image.rgba[at + c] *= stored.image.rgba[at + 3];
  return stored;
}

StoredImage to_linear(StoredImage stored) {
  if (std::exchange(stored.linear, true)) return stored;
  for (std::size_t at = 0; at < stored.image.rgba.size(); at += 4) {
    const float alpha = stored.image.rgba[at + 3];
    for (std::size_t c = 0; c < 3 && alpha > 0; ++c)
      stored.image.rgba[at + c] = alpha * srgb_to_linear(stored.image.rgba[at + c] / alpha);
  }
  return stored;
}

}  // namespace ringsplat
