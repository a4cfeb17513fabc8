#pragma once
#include <string_view>

namespace ringsplat::serve {

/// The page, which has its style sheet and all modules of src/serve/page in it.
struct PageFile {
  std::string_view html, gzipped;
  std::string_view script_hash, style_hash, hash;  ///< SHA-256 in hexadecimal digits
};

extern const PageFile page_file;

}  // namespace ringsplat::serve
