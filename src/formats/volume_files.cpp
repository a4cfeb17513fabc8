#include "formats/volume_files.hpp"

#include <fmt/format.h>
#include <fmt/printf.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

#include "base/fingerprint.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t most_hashed = 64 << 10;  ///< bytes at either end of a file
/// Bytes hashed of all of a volume's files together, but at least `least_hashed` of each: many small files on
/// a shared disk are slow to read.
constexpr std::uint64_t most_hashed_in_all = 16 << 20;
constexpr std::uint64_t least_hashed = 4 << 10;

std::string hash_of(const InputFile& file, std::uint64_t offset, std::uint64_t bytes) {
  std::vector<std::byte> part(bytes);
  file.read(offset, part);
  return fmt::format("{:016x}", fingerprint(part));
}

/// `of`: what the fields' names end with.
void add_facts(const InputFile& file, std::uint64_t offset, std::uint64_t bytes, std::uint64_t most,
               const std::string& of, Facts& facts) {
  const auto hashed = std::min(bytes, most);
  facts.push_back({"file size" + of, fmt::format("{} bytes", file.size())});
  facts.push_back({"hash of the first bytes" + of, hash_of(file, offset, hashed)});
  facts.push_back({"hash of the last bytes" + of, hash_of(file, offset + bytes - hashed, hashed)});
}

FileStamp stamp_at(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0)
    throw InputError(fmt::format("cannot open {}: {}", file.string(), std::strerror(errno)),
                     "check the path and the permissions");
  return stamp_of(status);
}

}  // namespace

std::vector<std::string> numbered_names(const std::string& pattern, std::int64_t first, std::int64_t count,
                                        std::int64_t step) {
  const auto percent = pattern.find('%'), letter = pattern.find_first_not_of("0123456789", percent + 1);
  constexpr std::size_t most_digits = 3;
  std::vector<std::string> names;
  if (percent == std::string::npos || letter == std::string::npos || pattern[letter] != 'd' ||
      letter - percent > 1 + most_digits || pattern.find('%', letter) != std::string::npos)
    return names;
  for (std::int64_t k = 0; k < count; ++k) names.push_back(fmt::sprintf(pattern, first + k * step));
  return names;
}

VolumeFiles::VolumeFiles(const std::vector<std::filesystem::path>& files) {
  for (const auto& file : files) {
    if (!files_.empty() && files_.back() == file) continue;
    files_.push_back(file);
    stamps_.emplace(file.string(), stamp_at(file));
  }
}

void VolumeFiles::require_unchanged(const std::filesystem::path& file) const {
  require_same_stamp(file, stamps_.at(file.string()), stamp_at(file));
}

Facts VolumeFiles::facts() const {
  if (files_.size() == 1) return facts(0, stamps_.at(files_[0].string()).bytes);
  Facts facts{{"number of files", fmt::format("{}", files_.size())}};
  const auto most = std::clamp(most_hashed_in_all / (2 * files_.size()), least_hashed, most_hashed);
  for (std::size_t k = 0; k < files_.size(); ++k)
    facts.push_back({fmt::format("file {}", k + 1), files_[k].filename().string()});
  for (const auto& path : files_) {
    const InputFile file(path);
    add_facts(file, 0, file.size(), most, " of " + path.filename().string(), facts);
  }
  return facts;
}

Facts VolumeFiles::facts(std::uint64_t offset, std::uint64_t bytes) const {
  Facts facts;
  add_facts(InputFile(files_[0]), offset, bytes, most_hashed, "", facts);
  return facts;
}

void LayeredSource::read_slices(int first, int count, std::span<std::byte> out) {
  const std::size_t bytes = grid_.slice_bytes(Axis::z);
  for (int z = first; z < first + count;) {
    const int begin = z / depth_ * depth_, end = std::min(begin + depth_, grid_.dims.z),
              stop = std::min(end, first + count);
    const auto part = out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes);
    if (z == begin && stop == end) {
      read_layer(begin, end, part);
    } else {
      if (kept_first_ != begin) {
        kept_first_ = -1;
        kept_.resize(std::size_t(end - begin) * bytes);
        read_layer(begin, end, kept_);
        kept_first_ = begin;
      }
      std::memcpy(part.data(), kept_.data() + std::size_t(z - begin) * bytes, part.size());
    }
    z = stop;
  }
}

Facts LayeredSource::facts() const {
  Facts facts = encoding_;
  std::ranges::copy(files_.facts(), std::back_inserter(facts));
  return facts;
}

void LayeredSource::set_layer(std::uint64_t slices) {
  constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20;
  const auto depth = std::min<std::uint64_t>(slices, std::uint64_t(grid_.dims.z));
  const std::uint64_t most = std::max<std::uint64_t>(1, most_bytes / grid_.slice_bytes(Axis::z));
  const std::uint64_t parts = (depth + most - 1) / most;
  depth_ = int((depth + parts - 1) / parts);
}

}  // namespace ringsplat::detail
