#pragma once
#include <string>
#include <string_view>

namespace ringsplat::serve {

/// A hash as a Content-Security-Policy names what may stand in a page: "'sha256-...'".
std::string policy_source(std::string_view hexadecimal);

/// A gzip file, the same for the same bytes.
std::string gzipped(std::string_view bytes);

}  // namespace ringsplat::serve
