# SPDX-License-Identifier: Apache-2.0
# Completion of `mtf` in bash: candidates are what `mtf --complete` lists (completion.h).

_mtf() {
  local word line glue="" home='~/' program words=()
  COMPREPLY=()
  # Bash takes "a=b" and "a:b" apart; quotes and backslashes are still there.
  for word in "${COMP_WORDS[@]:1:COMP_CWORD}"; do
    word=${word//[\\\"\']/}
    [[ $word == "$home"* ]] && word=$HOME/${word#"$home"}
    if [[ ${#words[@]} -gt 0 && ( $glue || $word =~ ^[=:]+$ ) ]]; then
      words[-1]+=$word
    else
      words+=("$word")
    fi
    [[ $word =~ ^[=:]+$ ]] && glue=yes || glue=""
  done
  program=${COMP_WORDS[0]}
  [[ $program == "$home"* ]] && program=$HOME/${program#"$home"}
  [[ $glue ]] && word=""
  local files=""
  while IFS= read -r line; do
    if [[ -z $line ]]; then
      files=yes
    elif [[ $files ]]; then
      COMPREPLY+=("$line")
    else
      COMPREPLY+=("$(printf %q "$line")")
    fi
  done < <("$program" --complete "${words[@]}" 2>/dev/null </dev/null)
  if [[ $files ]]; then
    compopt -o filenames 2>/dev/null
    while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -f -- "$word")
  elif [[ ${#COMPREPLY[@]} -eq 1 && $COMPREPLY == *= ]]; then
    compopt -o nospace 2>/dev/null
  fi
}
complete -F _mtf mtf
