#include "command_line/version_text.hpp"

#include <vector>

#include "options/option_values.hpp"
#include "ringsplat/config.hpp"

namespace ringsplat::app {

std::string version_text(const std::string& mpi) {
  std::vector<std::string> with, without;
  const auto add = [&](bool there, const std::string& name) { (there ? with : without).push_back(name); };
  add(!mpi.empty(), mpi.empty() ? "MPI" : mpi);
  add(RINGSPLAT_WITH_OPENIMAGEIO, "OpenImageIO");
  std::string text = "ringsplat " RINGSPLAT_VERSION;
  if (!with.empty()) text += "\nwith " + joined(with, ", ");
  if (!without.empty()) text += "\nwithout " + joined(without, ", ");
  return text;
}

}  // namespace ringsplat::app
