#pragma once

/// What shells run to complete a command line: they ask the program. Files and folders they find themselves.
namespace ringsplat::app {

inline constexpr char bash_script[] =
    R"(# bash completion for ringsplat, written by ringsplat --completion bash
_ringsplat() {
  local offer current=${COMP_WORDS[COMP_CWORD]} program=${COMP_WORDS[0]/#~/$HOME}
  [[ $current != = ]] || current=
  COMPREPLY=()
  while IFS=$'\t' read -r offer _; do
    case $offer in
      :files | :folders)
        compopt -o filenames 2>/dev/null
        [[ $offer == :files ]] && offer=file || offer=directory
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -A $offer -- "$current") ;;
      *) COMPREPLY+=("$offer") ;;
    esac
  done < <("$program" --complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -F _ringsplat ringsplat
)";

inline constexpr char zsh_script[] = R"(#compdef ringsplat
# zsh completion for ringsplat, written by ringsplat --completion zsh
_ringsplat() {
  local offer tab=$'\t'
  local -a offers kinds
  for offer in "${(@f)$("${words[1]/#\~/$HOME}" --complete "${(@)words[2,CURRENT]}" 2>/dev/null)}"; do
    case $offer in
      :*) kinds+=($offer) ;;
      ?*) offers+=("${offer/$tab/:}") ;;
    esac
  done
  (( ! $#offers )) || _describe word offers
  [[ -z $kinds ]] || compset -P '--*='
  [[ -z ${kinds[(r):files]} ]] || _files
  [[ -z ${kinds[(r):folders]} ]] || _files -/
}
# Loaded as a function of this name, or read by source.
[[ $funcstack[1] == _ringsplat ]] && _ringsplat "$@" || compdef _ringsplat ringsplat
)";

inline constexpr char fish_script[] =
    R"(# fish completion for ringsplat, written by ringsplat --completion fish
function __ringsplat_offers
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    set -l before (string match -r -- '^--[^=]*=' "$current")
    for offer in ($words[1] --complete $words[2..] "$current" 2>/dev/null)
        switch $offer
            case :files
                string join \n -- "$before"(__fish_complete_path (string replace -- "$before" '' "$current"))
            case :folders
                string join \n -- "$before"(__fish_complete_directories (string replace -- "$before" '' "$current"))
            case '*'
                echo $offer
        end
    end
end
complete -c ringsplat -f -a '(__ringsplat_offers)'
)";

}  // namespace ringsplat::app
