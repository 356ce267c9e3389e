# shellcheck shell=bash
# Bash completion for metabuffer. It asks the program for commands, options and keys, and has no lists of its own.
_metabuffer_words() {
  local command=$1
  # A line of the help that begins an entry: two spaces, and the name.
  if [[ -z $command ]]; then
    "$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$ s/^  \([a-z]\+\) .*/\1/p'
  else
    "$program" "$command" --help 2>/dev/null | grep -oE '^  (-[a-zA-Z],)?--[a-z-]+' | grep -oE '\-\-[a-z-]+'
  fi
}

# The values in braces after an option: --level TEXT:{tlm,rtl,functional}.
_metabuffer_values() {
  "$program" "$1" --help 2>/dev/null | sed -n "s/^  \(-[a-zA-Z],\)\?$2 [A-Z]*:{\([^}]*\)}.*/\2/p" | tr ',' ' '
}

_metabuffer() {
  local program=$1 current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command="" word values
  COMPREPLY=()
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if [[ $word != -* ]]; then command=$word; break; fi
  done
  if [[ -z $command ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_metabuffer_words '') --help --version" -- "$current")
    return
  fi
  case $previous in
    --set | --minimize | --over | --x | --y)
      mapfile -t COMPREPLY < <(compgen -S = -W "$("$program" keys 2>/dev/null | grep -oE '^ *[a-z_]+(\.[a-z_]+)+')" -- "$current")
      compopt -o nospace
      return
      ;;
    --*)
      values=$(_metabuffer_values "$command" "$previous")
      if [[ -n $values ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current")
        return
      fi
      ;;
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_metabuffer_words "$command")" -- "$current")
  else
    compopt -o filenames
    mapfile -t COMPREPLY < <(compgen -f -- "$current")
  fi
}
complete -F _metabuffer metabuffer
