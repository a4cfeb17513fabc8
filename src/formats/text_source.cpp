#include "formats/text_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
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

class Words {
 public:
  Words(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t end)
      : file_(path), offset_(offset), end_(end) {}

  /// The next word; empty at the end. A word longer than any number is split.
  std::string next() {
    constexpr std::size_t longest = 400;
    std::string word;
    for (auto c = peek(); c && word.size() < longest; c = peek()) {
      const bool blank = std::isspace(static_cast<unsigned char>(*c)) != 0;
      if (blank && !word.empty()) break;
      ++at_;
      if (!blank) word += *c;
    }
    return word;
  }

 private:
  std::optional<char> peek() {
    if (at_ == got_) {
      offset_ += got_;
      at_ = 0;
      const auto wanted = std::min<std::uint64_t>(window_.size(), end_ - std::min(end_, offset_));
      got_ = file_.read_some(offset_, std::span(window_).first(std::size_t(wanted)));
      if (got_ == 0) return {};
    }
    return char(window_[at_]);
  }

  InputFile file_;
  std::uint64_t offset_, end_;
  std::vector<std::byte> window_ = std::vector<std::byte>(64 * 1024);
  std::size_t at_ = 0, got_ = 0;
};

class TextSource final : public WholeSource {
 public:
  TextSource(const Grid& grid, std::filesystem::path path, std::uint64_t offset, std::uint64_t end)
      : WholeSource(grid), path_(std::move(path)), offset_(offset), end_(end) {
    require_numbers(path_, offset_, std::uint64_t(grid.voxels()), end_);
  }

 private:
  void decode(std::span<std::byte> voxels) override {
    Words words(path_, offset_, end_);
    visit_type(grid().type, [&](auto type) {
      using T = decltype(type);
      auto* values = reinterpret_cast<T*>(voxels.data());
      for (std::int64_t i = 0; i < grid().voxels(); ++i) {
        const auto word = words.next();
        const auto value = voxel_in<T>(word);
        if (!value)
          throw InputError(fmt::format("{}: voxel {}, '{}', is not a number of type {}", path_.string(), i,
                                       excerpt(word), to_string(grid().type)),
                           "correct the file or its type");
        values[i] = *value;
      }
    });
  }

  std::filesystem::path path_;
  std::uint64_t offset_, end_;
};

}  // namespace

std::unique_ptr<VolumeSource> text_source(const Grid& grid, const std::filesystem::path& file,
                                          std::uint64_t offset, std::uint64_t end) {
  return std::make_unique<TextSource>(grid, file, offset, end);
}

}  // namespace ringsplat::detail
