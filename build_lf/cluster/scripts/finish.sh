#!/usr/bin/env bash
# Merges what has all of its blocks, and says what is missing; exits with 1 if anything is.
#   ./finish.sh     writes missing.txt, which is empty when all is done
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=steps.sh
. ./steps.sh

# is_done AFTER: whether nothing is missing of these steps.
is_done() {
  local after=$1 name lines rest
  while read -r name lines rest; do
    if [[ ,$after, = *,$name,* ]] && [ -n "$(missing_of "$name" "$lines")" ]; then return 1; fi
  done <steps.txt
}

finish_step() {
  local name=$1 lines=$2 after=$3 missing
  missing=$(missing_of "$name" "$lines")
  [ -n "$missing" ] || return 0
  if [[ $name = *-merge ]] && is_done "$after"; then
    mkdir -p logs
    if ./task.sh "$name" 1 >>"logs/$name-1.log" 2>&1; then return 0; fi
  fi
  echo "$name: $(wc -l <<<"$missing") of $lines missing: $(ranges <<<"$missing")" \
    "(logs/$name-$(head -n 1 <<<"$missing").log)"
}

every_step finish_step | tee missing.txt
if [ -s missing.txt ]; then
  echo "not all is done; ./submit.sh or ./parallel.sh does what is missing"
  exit 1
fi
echo "all is done"
