#include "serve/picture_head.hpp"

#include <bit>
#include <concepts>

namespace ringsplat::serve {
namespace {

template <std::unsigned_integral T>
void put(std::string& bytes, std::size_t at, T value) {
  for (std::size_t k = 0; k < sizeof(T); ++k)
    bytes[at + k] = static_cast<char>(static_cast<unsigned char>(value >> (8 * k)));
}

}  // namespace

std::string picture_message(const PictureHead& head, std::string_view file) {
  std::string message(picture_head_bytes, '\0');
  message += file;
  return with_head(std::move(message), head);
}

std::string with_head(std::string message, const PictureHead& h) {
  message.replace(0, 4, "RSP1");
  put(message, 4, static_cast<std::uint32_t>(h.kind));
  put(message, 8, h.number);
  put(message, 12, h.seq);
  put(message, 16, static_cast<std::uint16_t>(h.width));
  put(message, 18, static_cast<std::uint16_t>(h.height));
  put(message, 20, static_cast<std::uint8_t>(h.level));
  put(message, 21, static_cast<std::uint8_t>(h.levels));
  put(message, 22, static_cast<std::uint8_t>(h.at_rest ? 1 : 0));
  put(message, 23, static_cast<std::uint8_t>(h.format));
  put(message, 24, std::bit_cast<std::uint32_t>(h.seconds));
  put(message, 28, std::bit_cast<std::uint32_t>(h.pictures_a_second));
  put(message, 32, std::bit_cast<std::uint64_t>(h.time));
  put(message, 40, std::bit_cast<std::uint32_t>(h.rmse));
  put(message, 44, std::uint32_t{0});
  return message;
}

}  // namespace ringsplat::serve
