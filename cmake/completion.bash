# Completion for bash: commands, flags, words and files, as the programs' --help shows them.
_raywalk() {
  local cur=${COMP_WORDS[COMP_CWORD]} flag=${COMP_WORDS[COMP_CWORD-1]} command='' word
  # bash makes three words of --flag=value.
  if [[ $cur == '=' ]]; then
    cur=''
  elif [[ $flag == '=' ]]; then
    flag=${COMP_WORDS[COMP_CWORD-2]}
  fi
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if [[ $word != -* ]]; then command=$word; break; fi
  done
  local help value='' words
  help=$("$1" ${command:+"$command"} --help 2>/dev/null)
  if [[ $flag == -* ]]; then  # what stands behind one space, as in "  -o,--out TEXT  Picture"
    value=$(sed -nE "s/^  ([^ ]*,)?$flag(,[^ ]*)? ([^ ].*)/\3/p" <<<"$help")
  fi
  if [[ -z $value && $cur == -* ]]; then
    words=$(grep -oE '^  (-.,)?--[a-z0-9-]+' <<<"$help" | tr ',' ' ')
  elif [[ -z $value && -z $command ]]; then
    words=$(sed -nE '/^subcommands:/I,/^$/s/^  ([a-z][a-z-]*) .*/\1/p' <<<"$help")
  else
    [[ -n $value ]] || value=$(sed -nE '/^Positionals:/I,/^$/s/^  [^ ]+ ([^ ].*)/\1/p' <<<"$help")
    value=$(sed -E 's/  .*//; s/ in \[.*//' <<<"$value")
    words=$(grep -oE '\b[a-z0-9][a-z0-9.-]*\b' <<<"$value")
  fi
  # Several words may have commas between them.
  mapfile -t COMPREPLY < <(compgen -P "${cur%"${cur##*,}"}" -W "$words" -- "${cur##*,}")
  if [[ $value == *CONFIG* || $value == *TEXT* && $value != *{* ]]; then
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$cur")
    compopt -o filenames 2>/dev/null
  fi
  return 0
}
complete -F _raywalk raywalk-build-lf raywalk-calibrate raywalk-capture raywalk-render raywalk-simulate
