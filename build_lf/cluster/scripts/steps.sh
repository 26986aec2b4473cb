# shellcheck shell=bash
# What the other scripts of this folder share; sourced by them.
# steps.txt has a line for each step: its name, how many commands it has, and the steps whose results
# it needs, or "-".

# every_step COMMAND: calls COMMAND NAME LINES AFTER for each step, in order, until one fails.
every_step() {
  local name lines after
  while read -r name lines after <&3; do
    "$1" "$name" "$lines" "$after" || return
  done 3<steps.txt
}

# missing_of STEP LINES: the numbers of the step's commands that are not done, one a line.
missing_of() {
  local line
  for ((line = 1; line <= $2; ++line)); do
    [ -e "state/done/$1/$line" ] || echo "$line"
  done
}

# ranges: joins ascending numbers, one a line, to the form that Slurm takes: 1-4,7.
ranges() {
  awk '
    function add() { text = text (text == "" ? "" : ",") (from == to ? from : from "-" to) }
    NR > 1 && $1 == to + 1 { to = $1; next }
    NR > 1 { add() }
    { from = to = $1 }
    END { if (NR) add(); print text }'
}

# run_until_ended COMMAND...: runs a command, which is told to end when this script is. Without that it
# would go on where only the script itself is known to the engine.
run_until_ended() {
  local child='' told='' status=0
  # Also where the signal comes while the command is being started.
  trap 'told=1; [ -z "$child" ] || kill -TERM "$child" 2>/dev/null' TERM INT HUP
  "$@" &
  child=$!
  [ -z "$told" ] || kill -TERM "$child" 2>/dev/null
  wait "$child" || status=$?
  # A signal ends the waiting, not yet the command, which is told again as it may just have begun.
  while kill -0 "$child" 2>/dev/null; do
    sleep 1
    [ -z "$told" ] || kill -TERM "$child" 2>/dev/null
  done
  # 143: by SIGTERM, also where the command ended at the same time.
  [ -z "$told" ] || [ "$status" -eq 0 ] || status=143
  trap - TERM INT HUP
  return "$status"
}
