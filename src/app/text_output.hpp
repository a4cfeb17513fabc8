#pragma once
#include <string>

namespace ringsplat::app {

/// Whether the name of a file of text says standard output: "-".
bool is_stdout(const std::string& file);

/// Throws InputError naming `option` when the file cannot be written (base/output_file.hpp); standard output
/// always can.
void check_can_write_text(const std::string& file, const std::string& option);

/// A whole text into a file, or to standard output. Throws RunError (disk full, ...).
void write_text_output(const std::string& file, const std::string& text);

/// Throws RunError when something that was printed could not be written. The program does at its end.
void flush_stdout();

}  // namespace ringsplat::app
