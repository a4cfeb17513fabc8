#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/output_file.hpp"
#include "base/printable.hpp"

namespace ringsplat::app {

/// True when a text file's name means standard output: "-".
inline bool is_stdout(const std::string& file) { return file == "-"; }

/// Throws InputError that names `option` when the file cannot be written (base/output_file.hpp). Standard
/// output always passes.
inline void check_can_write_text(const std::string& file, const std::string& option) {
  if (!is_stdout(file)) check_can_write(file, option);
}

/// Writes a whole text to a file or to standard output. Throws RunError (disk full, ...).
void write_text_output(const std::string& file, const std::string& text);

/// Throws RunError when printed text could not be written. Call it at the program's end.
void flush_stdout();

/// A file named by an option; an empty name and standard output ("-") are no files.
struct NamedFile {
  std::string option, file;
};

/// Throws InputError when two outputs are the same file (under any names) or both standard output, or when an
/// output would replace an input or lie among the slices of one.
void refuse_clashes(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// Turns every minus zero into zero.
template <class Json>
void make_plain(Json& j) {
  if (j.is_structured())
    for (auto& part : j) make_plain(part);
  else if (j.is_number_float())
    j = plain(j.template get<double>());
}

/// A JSON text for people and programs: no minus zero, and bytes that are not UTF-8 (in file names) are
/// replaced. `indent` -1: on one line.
template <class Json>
std::string plain_json_text(Json j, int indent = -1) {
  make_plain(j);
  return j.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ringsplat::app
