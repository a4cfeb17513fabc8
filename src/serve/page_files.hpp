#pragma once
#include <span>
#include <string_view>

namespace ringsplat::serve {

/// One file of the page, compiled in from src/serve/page.
struct PageFile {
  std::string_view name;  ///< below that folder: "index.html", which has all others in it
  std::string_view bytes;
};

std::span<const PageFile> page_files();

/// SHA-256, in hexadecimal digits, of what index.html has in it and of itself.
struct PageHashes {
  std::string_view script, style, page;
};

PageHashes page_hashes();

}  // namespace ringsplat::serve
