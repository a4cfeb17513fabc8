#include "options/completion.hpp"

#include "options/completion_model.hpp"
#include "options/option_row.hpp"

namespace ringsplat::app {

std::string completion(const CLI::App& program, const std::string& shell) {
  const auto commands = completed_commands(program);
  if (shell == "bash") return bash_completion(commands);
  if (shell == "zsh") return zsh_completion(commands);
  if (shell == "fish") return fish_completion(commands);
  refuse_choice("--completion", shell, completion_shells);
}

}  // namespace ringsplat::app
