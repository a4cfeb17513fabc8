#pragma once
#include <string>

namespace ringsplat::decode {

/// From when it is made, what libraries print goes nowhere but here.
class ForeignLines {
 public:
  ForeignLines();
  /// The first line since it was last asked for; empty for none.
  std::string first_line();

 private:
  int caught_;  ///< descriptor of what they print
};

}  // namespace ringsplat::decode
