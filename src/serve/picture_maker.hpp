#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "serve/jpeg.hpp"
#include "serve/picture_head.hpp"

namespace ringsplat::serve {

/// A finished frame on its way to the pages.
struct RenderedPicture {
  Image image;
  glm::dvec3 background{0.0};  ///< linear light
  PictureHead head;
  JpegQuality quality = JpegQuality::moving;
  std::uint64_t scene = 0;  ///< the same for pictures of the same view in the same size
};

/// Turns frames into messages, and learns what each level errs: whenever a view's best picture comes, its
/// coarser ones are compared with it. For one thread.
class PictureMaker {
 public:
  explicit PictureMaker(int levels);
  /// Fills in the head's size and error.
  std::string make(RenderedPicture& picture);
  /// Call it after make(), when the message is on its way.
  void learn(const RenderedPicture& picture);

 private:
  struct Coarse {
    int level, width, height;
    std::vector<std::uint8_t> rgb;
  };

  JpegEncoder encoder_;
  std::vector<std::uint8_t> rgb_;  ///< of the last picture made
  std::vector<float> rmse_;        ///< by level
  std::uint64_t scene_ = 0;
  std::vector<Coarse> coarse_;  ///< of that scene
};

/// RMSE in 1/255 of a picture, enlarged bilinearly to the size of the other.
float rmse_of(const std::vector<std::uint8_t>& small, int small_width, int small_height,
              const std::vector<std::uint8_t>& rgb, int width, int height);

}  // namespace ringsplat::serve
