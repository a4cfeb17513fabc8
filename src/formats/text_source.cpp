#include "formats/text_source.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/text_reader.hpp"
#include "formats/whole_source.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

/// Writers print whole numbers as "1e+06" too.
template <class T>
std::optional<T> voxel_in(const std::string& word) {
  const auto number = number_in<double>(word);
  if (!number) return {};
  if constexpr (std::is_integral_v<T>)
    if (!(*number >= double(std::numeric_limits<T>::min()) &&
          *number <= double(std::numeric_limits<T>::max())) ||
        *number != std::trunc(*number))
      return {};
  return T(*number);
}

class TextSource final : public WholeFileSource {
 public:
  TextSource(const Grid& grid, const std::filesystem::path& path, std::uint64_t offset, std::uint64_t end)
      : WholeFileSource(grid, path), offset_(offset), end_(end) {
    require_numbers(path_, offset_, std::uint64_t(grid.voxels()), end_);
  }

 private:
  void decode_file(std::span<std::byte> voxels) override {
    const InputFile file(path_);
    TextReader text(file, offset_, end_);
    visit_type(grid().type, [&](auto type) {
      using T = decltype(type);
      auto* values = reinterpret_cast<T*>(voxels.data());
      for (std::int64_t i = 0; i < grid().voxels(); ++i) {
        const auto word = text.word();
        const auto value = voxel_in<T>(word);
        if (!value)
          throw InputError(fmt::format("{}: voxel {}, '{}', is not a number of type {}", path_.string(), i,
                                       excerpt(word), to_string(grid().type)),
                           "correct the file or its type");
        values[i] = *value;
      }
    });
  }

  std::uint64_t offset_, end_;
};

}  // namespace

std::unique_ptr<VolumeSource> text_source(const Grid& grid, const std::filesystem::path& file,
                                          std::uint64_t offset, std::uint64_t end) {
  return std::make_unique<TextSource>(grid, file, offset, end);
}

}  // namespace ringsplat::detail
