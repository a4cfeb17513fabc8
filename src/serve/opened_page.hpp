#pragma once
#include <string>

#include "serve/private_folder.hpp"

namespace ringsplat::serve {

/// The page in this machine's browser. Every user of the machine can read what a program was started with, so
/// xdg-open gets the name of a file that only its owner can read, and that leads on to the address with its
/// token. The file lasts as long as this object.
class OpenedPage {
 public:
  /// Throws RunError when there is no xdg-open or no place for the file.
  explicit OpenedPage(const std::string& url);

 private:
  PrivateFolder folder_;
};

}  // namespace ringsplat::serve
