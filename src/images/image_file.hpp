#pragma once
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "ringsplat/base/bytes.hpp"

/// Image files, by OpenImageIO. Loading it with its libraries takes longer than rendering a picture, so it is
/// loaded when the first file is opened or written. Functions here throw RunError when it cannot be loaded.
namespace ringsplat {

/// `other`: samples that cannot be read as one of these. The first ones are a volume's ScalarType.
enum class SampleType { int8, uint8, int16, uint16, int32, uint32, float32, float64, float16, other };

/// One of a file's images.
struct ImageShape {
  int width, height, depth, channels;
  int alpha_channel;  ///< below 0: none
  SampleType type;
  std::string type_name;  ///< as OpenImageIO calls it
  std::uint64_t bytes;    ///< of all samples, uncompressed
  int depth_channel;      ///< below 0: none
};

/// A file open for reading. Not for several threads at once.
class ImageFile {
 public:
  virtual ~ImageFile() = default;
  /// Goes to the image with that number, from 0; false: there is none.
  virtual bool seek(int image) = 0;
  /// The current image, at first number 0.
  virtual ImageShape shape() const = 0;
  /// The image's attribute of that name; empty or 0 when it has none.
  virtual std::string text(const std::string& name) const = 0;
  virtual int number(const std::string& name) const = 0;
  /// Reads the first `channels` of an image's pixels, rows from the top, as samples of that type. Straight
  /// alpha stays straight. Returns what went wrong, or an empty text.
  virtual std::string read(int image, int channels, SampleType type, void* samples) = 0;
};

/// Loads the library for pictures that are to be written: in get(), or if wanted before that on another
/// thread, which ends with what is returned. get() throws InputError when it cannot be loaded.
std::shared_future<void> load_image_library(bool meanwhile);

struct OpenedImageFile {
  std::unique_ptr<ImageFile> file;  ///< null: it is no image file
  std::string problem;              ///< why not, if it is none
};
OpenedImageFile open_image_file(const std::filesystem::path& path);

/// An image to be written.
struct ImageData {
  int width, height, channels;  ///< red, green, blue and, if more, alpha; and depth
  SampleType type;              ///< in memory and, where the format has it, in the file
  const void* samples;          ///< rows from the top, pixel by pixel
  struct Attribute {
    std::string name;
    std::variant<int, std::string> value;
  };
  std::vector<Attribute> attributes;  ///< with OpenImageIO's names
  bool has_depth = false;             ///< in the last channel
};

/// The bytes of an image file; the path's ending names the format. Throws RunError naming the file and the
/// reason.
Bytes image_file_bytes(const std::string& path, const ImageData& image);

}  // namespace ringsplat
