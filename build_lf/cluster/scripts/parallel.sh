#!/usr/bin/env bash
# Does what is not done yet by GNU parallel, on this machine or on several that it reaches by ssh and
# that all see this folder and the pictures under the same paths. Give it again to do what is missing.
#   ./parallel.sh [OPTION OF PARALLEL...]
#   ./parallel.sh --sshlogin :,hall1,hall2     on this machine and two others
#   ./parallel.sh --jobs 4                     four tasks at a time on each machine
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=steps.sh
. ./steps.sh
options=("$@")

# A task that fails is tried three times, on other machines where there are any.
run_step() {
  local name=$1 missing
  missing=$(missing_of "$name" "$2")
  [ -n "$missing" ] || return 0
  echo "== $name: $(ranges <<<"$missing") of $2"
  parallel --jobs 1 --retries 3 --halt soon,fail=1 --workdir "$PWD" --joblog "+logs/$name.jobs" \
    "${options[@]}" ./task.sh "$name" '{}' '>>' "logs/$name-{}.log" '2>&1' <<<"$missing"
}

mkdir -p logs
every_step run_step || true
./finish.sh
