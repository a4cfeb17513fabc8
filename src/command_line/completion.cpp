#include "command_line/command_line.hpp"

#include <algorithm>
#include <string_view>

#include "classify/colour_maps.hpp"
#include "options/option_values.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

// What shells run to complete a command line: they ask the program. Files they find themselves.
constexpr char bash_script[] =
    R"(# bash completion for ringsplat, written by ringsplat --completion bash
_ringsplat() {
  local offer current=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]/#~/$HOME}
  [[ $current != = ]] || current=
  COMPREPLY=()
  while IFS=$'\t' read -r offer _; do
    case $offer in
      :files)
        compopt -o filenames 2>/dev/null
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -A file -- "$current") ;;
      *) COMPREPLY+=("$offer") ;;
    esac
  done < <("$program" --complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -F _ringsplat ringsplat
)";

constexpr char zsh_script[] = R"(#compdef ringsplat
# zsh completion for ringsplat, written by ringsplat --completion zsh
_ringsplat() {
  local offer files tab=$'\t'
  local -a offers
  for offer in "${(@f)$("${words[1]/#\~/$HOME}" --complete "${(@)words[2,CURRENT]}" 2>/dev/null)}"; do
    case $offer in
      :files) files=1 ;;
      ?*) offers+=("${offer/$tab/:}") ;;
    esac
  done
  (( ! $#offers )) || _describe word offers
  [[ -z $files ]] || { compset -P '--*='; _files }
}
# Loaded as a function of this name, or read by source.
[[ $funcstack[1] == _ringsplat ]] && _ringsplat "$@" || compdef _ringsplat ringsplat
)";

constexpr char fish_script[] =
    R"(# fish completion for ringsplat, written by ringsplat --completion fish
function __ringsplat_offers
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    set -l before (string match -r -- '^--[^=]*=' "$current")
    for offer in ($words[1] --complete $words[2..] "$current" 2>/dev/null)
        switch $offer
            case :files
                string join \n -- "$before"(__fish_complete_path (string replace -- "$before" '' "$current"))
            case '*'
                echo $offer
        end
    end
end
complete -c ringsplat -f -a '(__ringsplat_offers)'
)";

/// Lines for those words that begin with what is typed.
class Offers {
 public:
  /// `before`: what is typed before the value, as in --option=value.
  Offers(std::string before, std::string typed) : before_(std::move(before)), typed_(std::move(typed)) {}
  void add(const std::string& word, const std::string& meaning = {}) {
    if (!word.starts_with(typed_)) return;
    lines_ += before_ + word + (meaning.empty() ? "" : "\t" + meaning) + "\n";
  }
  void add_files() { lines_ += ":files\n"; }
  const std::string& lines() const { return lines_; }

 private:
  std::string before_, typed_, lines_;
};

/// What an option does, on a line beside its name.
std::string short_help(const std::string& help) {
  constexpr std::size_t longest = 76;
  const std::string first = help.substr(0, help.find(';'));
  return first.size() <= longest ? first : first.substr(0, first.rfind(' ', longest)) + " ...";
}

template <class Range>
void offer_names(Offers& offers, const Range& range) {
  for (const auto& entry : range) offers.add(entry.name, short_help(entry.description));
}

/// Words that an option's form does not list.
void offer_known(Offers& offers, const Option& option) {
  if (option.has_name("--tf")) offer_names(offers, preset_names());
  if (option.has_name("--colours")) {
    auto maps = colour_map_names();
    for (auto& map : maps) std::replace(map.name.begin(), map.name.end(), ' ', '-');  // also known so
    offer_names(offers, maps);
    offers.add("list", "shows the names");
  }
  if (option.has_name("--background"))
    for (const auto& name : colour_names()) offers.add(name);
  if (option.has_name("--type"))
    for (const char* type : {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"})
      offers.add(type);
  if (option.is_positional() && option.form == "NAME") offer_names(offers, synth_names());
}

/// Words of a form stand for themselves; what is a kind of value has a capital letter.
bool is_word(std::string_view part) {
  return !part.empty() && part.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-") == part.npos;
}

void offer_values(Offers& offers, const Option& option) {
  offer_known(offers, option);
  bool files = option.is_positional() && option.form.size() == 1;  // pictures to compare
  // A choice's words are its reader's form, whatever form its row shows.
  const std::string& form =
      option.reader.form.find('|') != std::string::npos ? option.reader.form : option.form;
  for (const auto part : split(form, "|")) {
    if (is_word(part)) offers.add(std::string(part));
    files = files || part.starts_with("FILE") || part.starts_with("VOLUME");
  }
  if (files) offers.add_files();
}

/// The option whose value the last word is, or null.
const Option* option_before(const Words& words, const OptionList& list) {
  for (std::size_t back = 2; back <= words.size(); ++back) {
    const Option* const option = list.find(words[words.size() - back]);
    if (option != nullptr && !option->is_positional())
      return int(back) - 2 < option->reader.words ? option : nullptr;
  }
  return nullptr;
}

}  // namespace

std::string completion_script(const std::string& shell) {
  if (shell == "bash") return bash_script;
  if (shell == "zsh") return zsh_script;
  if (shell == "fish") return fish_script;
  refuse_choice("--completion", shell, completion_shells);
}

std::string completions(const OptionList& program, std::span<const BoundSubcommand> subcommands,
                        Words words) {
  if (words.empty()) words.emplace_back();
  // bash makes three words of --option=value.
  if (words.back() == "=") words.back().clear();
  std::erase(words, "=");
  const auto chosen = std::find_if(subcommands.begin(), subcommands.end(), [&](const auto& one) {
    return std::find(words.begin(), words.end() - 1, one.what->name) != words.end() - 1;
  });
  OptionList list;
  if (chosen != subcommands.end()) list = chosen->options;
  list.insert(list.end(), program.begin(), program.end());

  const std::string current = words.back();
  const auto equals = current.starts_with("--") ? current.find('=') : std::string::npos;
  if (equals != std::string::npos) {
    Offers offers(current.substr(0, equals + 1), current.substr(equals + 1));
    if (const Option* option = list.find(current.substr(0, equals))) offer_values(offers, *option);
    return offers.lines();
  }
  Offers offers("", current);
  if (const Option* option = option_before(words, list)) {
    offer_values(offers, *option);
  } else if (current.starts_with("-")) {
    for (const Option& one : list)
      if (!one.is_positional())
        for (const auto& name : one.names) offers.add(name, short_help(one.help));
  } else if (chosen == subcommands.end()) {
    for (const auto& one : subcommands) offers.add(one.what->name, one.what->description);
  } else {
    for (const Option& argument : list)
      if (argument.is_positional()) return offer_values(offers, argument), offers.lines();
  }
  return offers.lines();
}

}  // namespace ringsplat::app
