#include "formats/left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {

void refuse_left_out(const std::filesystem::path& path, const std::string& format,
                     const std::string& library) {
  std::string option = library;
  std::transform(option.begin(), option.end(), option.begin(),
                 [](unsigned char c) { return char(std::toupper(c)); });
  throw InputError(
      fmt::format("{}: {} is read by {}, which this build does without", path.string(), format, library),
      fmt::format("build it with -DRINGSPLAT_WITH_{}=ON, or convert the file to a plain .nrrd or .mha",
                  option));
}

}  // namespace ringsplat::detail
