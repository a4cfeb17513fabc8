#pragma once
#include <span>
#include <string_view>

namespace ringsplat::serve {

/// One file of the page, compiled in from src/serve/page.
struct PageFile {
  std::string_view name;  ///< below that folder: "index.html"
  std::string_view bytes;
};

std::span<const PageFile> page_files();

}  // namespace ringsplat::serve
