#include "formats/volume_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

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
  Fingerprint hash;
  hash.add(part);
  return fmt::format("{:016x}", hash.value());
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

void add_facts_of(const InputFile& file, std::uint64_t offset, std::uint64_t bytes, Facts& facts) {
  add_facts(file, offset, bytes, most_hashed, "", facts);
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
  Facts facts{{"number of files", fmt::format("{}", files_.size())}};
  const auto most = std::clamp(most_hashed_in_all / (2 * std::max<std::uint64_t>(1, files_.size())),
                               least_hashed, most_hashed);
  for (std::size_t k = 0; k < files_.size(); ++k)
    facts.push_back({fmt::format("file {}", k + 1), files_[k].filename().string()});
  for (const auto& path : files_) {
    const InputFile file(path);
    add_facts(file, 0, file.size(), most, " of " + path.filename().string(), facts);
  }
  return facts;
}

}  // namespace ringsplat::detail
