#include "serve/private_folder.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <system_error>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {
namespace {

std::filesystem::path temporary_folder() {
  std::error_code error;
  return std::filesystem::temp_directory_path(error);  // empty when there is none
}

}  // namespace

PrivateFolder::PrivateFolder(const std::filesystem::path& parent, const std::string& purpose) {
  std::string name = (parent / ("ringsplat-" + purpose + "-XXXXXX")).string();
  if (parent.empty() || mkdtemp(name.data()) == nullptr)
    throw RunError(fmt::format("there is no temporary folder for a {}: {}", purpose,
                               std::generic_category().message(parent.empty() ? ENOENT : errno)),
                   "set TMPDIR to a folder on rank 0's machine");
  path_ = name;
}

PrivateFolder::PrivateFolder(const std::string& purpose) : PrivateFolder(temporary_folder(), purpose) {}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace ringsplat::serve
