#pragma once
#include <string>
#include <vector>

namespace ringsplat::app {

/// A file as an option named it; an empty name and standard output ("-") are no files.
struct NamedFile {
  std::string option, file;
};

/// Throws InputError when two outputs are the same file, by whatever names, or standard output both, or when
/// an output would replace an input.
void refuse_clashes(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

}  // namespace ringsplat::app
