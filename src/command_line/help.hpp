#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace ringsplat::app {

/// Writes --help and --help-all. Of a subcommand that names everyday options --help shows these alone, in few
/// words, so that they fit one screen.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(column); }
  /// "--zoom NUMBER [1]": CLI11's own line glues the default to the type and counts values.
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;

 private:
  static constexpr std::size_t column = 34;  ///< where an option's help begins
  std::string everyday_entry(const CLI::Option& option) const;
  std::string everyday_groups(const CLI::App& app, const std::string& everyday) const;
};

}  // namespace ringsplat::app
