#pragma once
#include <string>
#include <vector>

namespace ringsplat::app {

/// A file named by an option; an empty name and standard output ("-") are no files.
struct NamedFile {
  std::string option, file;
};

/// Throws InputError when two outputs are the same file (under any names) or both standard output, or when an
/// output would replace an input.
void refuse_clashes(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

}  // namespace ringsplat::app
