#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/input_file.hpp"

namespace ringsplat::detail {

[[noreturn]] void fail_nrrd(const std::filesystem::path& path, const std::string& what);

/// The lines "field: value" of an NRRD's header, and the names of data files behind its last line.
class NrrdFields {
 public:
  explicit NrrdFields(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t end() const { return end_; }  ///< the byte behind the header
  /// Behind "data file: LIST".
  const std::vector<std::string>& listed() const { return listed_; }

  /// Empty when it is missing. `field`: the first of its spellings, as in "data file".
  std::string value(const std::string& field) const;
  std::string required(const std::string& field) const;
  std::vector<std::string> words(const std::string& field) const;
  /// One word an axis; none when the field is missing.
  std::vector<std::string> words_of_axes(const std::string& field, std::size_t axes) const;
  /// One number an axis, NaN where there is none; none when the field is missing.
  std::vector<double> numbers_of_axes(const std::string& field, std::size_t axes) const;
  /// The vectors "(1,2,3)" of as many finite numbers, empty ones for "none"; none when the field is missing.
  std::vector<std::vector<double>> vectors(const std::string& field, int axes_of_space) const;
  std::int64_t integer(const std::string& field, std::int64_t otherwise) const;
  [[noreturn]] void fail(const std::string& field) const;

 private:
  void take(const std::string& line);
  std::vector<double> vector_in(const std::string& text, const std::string& field, int axes_of_space) const;

  std::filesystem::path path_;
  std::uint64_t end_ = 0;
  std::map<std::string, std::string> values_;
  std::vector<std::string> listed_;
};

}  // namespace ringsplat::detail
