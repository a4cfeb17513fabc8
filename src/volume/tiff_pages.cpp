#include "volume/tiff_pages.hpp"

#include <fmt/format.h>

#include <array>

#include "ringsplat/base/error.hpp"
#include "volume/input_file.hpp"

namespace ringsplat::detail {
namespace {

class Numbers {
 public:
  Numbers(const InputFile& file, bool big_endian) : file_(file), big_endian_(big_endian) {}

  std::uint64_t at(std::uint64_t offset, std::size_t bytes) const {
    std::array<std::byte, 8> raw{};
    if (offset > file_.size() || file_.read_some(offset, std::span(raw).first(bytes)) != bytes)
      throw InputError(fmt::format("{} is cut short: a page lies behind its end", file_.path().string()),
                       "copy the file again");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8 | std::to_integer<std::uint64_t>(raw[big_endian_ ? i : bytes - 1 - i]);
    return value;
  }

 private:
  const InputFile& file_;
  bool big_endian_;
};

}  // namespace

std::uint64_t count_tiff_pages(const std::filesystem::path& path) {
  const InputFile file(path);
  std::array<std::byte, 2> order{};
  if (file.read_some(0, order) != order.size() || order[0] != order[1]) return 0;
  if (order[0] != std::byte{'I'} && order[0] != std::byte{'M'}) return 0;
  const Numbers numbers(file, order[0] == std::byte{'M'});
  constexpr std::uint64_t classic = 42, big_tiff = 43;
  const auto version = numbers.at(2, 2);
  if (version != classic && version != big_tiff) return 0;
  const bool wide = version == big_tiff;
  const std::size_t offset_bytes = wide ? 8 : 4, count_bytes = wide ? 8 : 2, entry_bytes = wide ? 20 : 12;

  const auto most = file.size() / (count_bytes + offset_bytes);
  std::uint64_t pages = 0;
  for (auto at = numbers.at(wide ? 8 : 4, offset_bytes); at != 0; ++pages) {
    if (pages > most)
      throw InputError(fmt::format("{}: its pages form a loop", path.string()), "write the file again");
    const auto entries = numbers.at(at, count_bytes);
    if (entries > file.size() / entry_bytes)
      throw InputError(fmt::format("{} is cut short or damaged at byte {}", path.string(), at),
                       "copy the file again");
    at = numbers.at(at + count_bytes + entries * entry_bytes, offset_bytes);
  }
  return pages;
}

}  // namespace ringsplat::detail
