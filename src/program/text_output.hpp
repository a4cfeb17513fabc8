#pragma once
#include <string>

namespace ringsplat::app {

/// True when a text file's name means standard output: "-".
bool is_stdout(const std::string& file);

/// Throws InputError that names `option` when the file cannot be written (base/output_file.hpp). Standard
/// output always passes.
void check_can_write_text(const std::string& file, const std::string& option);

/// Writes a whole text to a file or to standard output. Throws RunError (disk full, ...).
void write_text_output(const std::string& file, const std::string& text);

/// Throws RunError when printed text could not be written. Call it at the program's end.
void flush_stdout();

}  // namespace ringsplat::app
