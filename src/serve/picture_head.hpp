#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace ringsplat::serve {

enum class PictureKind : std::uint32_t { picture = 0, snapshot = 1, movie = 2 };
enum class PictureFormat : std::uint8_t { jpeg = 0, png = 1, exr = 2, mp4 = 3 };

/// What a binary message tells of the file that follows (docs/viewer.md has the bytes).
struct PictureHead {
  PictureKind kind = PictureKind::picture;
  std::uint32_t number = 0;  ///< to be acknowledged; of a snapshot its id
  std::uint32_t seq = 0;     ///< of the view that it shows
  int width = 0, height = 0;
  int level = 0, levels = 1;
  bool at_rest = false;  ///< nothing finer will come
  PictureFormat format = PictureFormat::jpeg;
  float seconds = 0;  ///< of rendering
  float pictures_a_second = 0;
  double time = 0;                                       ///< of the page's clock, as it was sent
  float rmse = std::numeric_limits<float>::quiet_NaN();  ///< against the best picture, in 1/255
};

inline constexpr std::size_t picture_head_bytes = 48;

/// The head's bytes, little endian, and the file's.
std::string picture_message(const PictureHead& head, std::string_view file);
/// A message of the same file with another head.
std::string with_head(std::string message, const PictureHead& head);

}  // namespace ringsplat::serve
