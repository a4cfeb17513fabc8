#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ringsplat/base/image.hpp"

namespace ringsplat::serve {

enum class PictureKind : std::uint32_t { picture = 0, snapshot = 1, movie = 2 };
enum class PictureFormat : std::uint8_t { jpeg = 0, png = 1, exr = 2, mp4 = 3 };

/// What a binary message tells of the file that follows, byte by byte (docs/viewer.md), little endian.
struct PictureHead {
  std::array<char, 4> magic{'R', 'S', 'P', '1'};
  PictureKind kind = PictureKind::picture;
  std::uint32_t number = 0;  ///< to be acknowledged; of a snapshot its id
  std::uint32_t seq = 0;     ///< of the view that it shows
  std::uint16_t width = 0, height = 0;
  std::uint8_t level = 0, levels = 1;
  bool at_rest = false;  ///< nothing finer will come
  PictureFormat format = PictureFormat::jpeg;
  float seconds = 0;  ///< of rendering
  float pictures_a_second = 0;
  double time = 0;                                       ///< of the page's clock, as it was sent
  float rmse = std::numeric_limits<float>::quiet_NaN();  ///< against the best picture, in 1/255
  std::uint32_t unused = 0;
};
static_assert(sizeof(PictureHead) == 48);

/// The head's bytes and the file's.
std::string picture_message(const PictureHead& head, std::string_view file);
/// A message of the same file with another head.
std::string with_head(std::string message, const PictureHead& head);

/// A finished frame on its way to the pages.
struct RenderedPicture {
  Image image;
  glm::dvec3 background{0.0};  ///< linear light
  PictureHead head;
  bool moving = true;       ///< less quality will do
  std::uint64_t scene = 0;  ///< the same for pictures of the same view in the same size
};

/// Turns frames into messages, and learns what each level errs: whenever a view's best picture comes, its
/// coarser ones are compared with it. For one thread.
class PictureMaker {
 public:
  explicit PictureMaker(int levels);
  /// A JPEG: of quality 80 with chroma at half size while moving, of 95 with all of it at rest. Fills in the
  /// head's size and error. Throws RunError when there is no memory.
  std::string make(RenderedPicture& picture);
  /// Call it after make(), when the message is on its way.
  void learn(const RenderedPicture& picture);

 private:
  struct Coarse {
    int level, width, height;
    std::vector<std::uint8_t> rgb;
  };

  std::unique_ptr<void, int (*)(void*)> encoder_;  ///< libjpeg-turbo's
  std::vector<std::uint8_t> jpeg_;
  std::vector<std::uint8_t> rgb_;  ///< of the last picture made
  std::vector<float> rmse_;        ///< by level
  std::uint64_t scene_ = 0;
  std::vector<Coarse> coarse_;  ///< of that scene
};

/// RMSE in 1/255 of a picture, enlarged bilinearly to the size of the other.
float rmse_of(const std::vector<std::uint8_t>& small, int small_width, int small_height,
              const std::vector<std::uint8_t>& rgb, int width, int height);

}  // namespace ringsplat::serve
