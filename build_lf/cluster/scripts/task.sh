#!/usr/bin/env bash
# Does one command of a step, unless it is done, and notes when it is.
#   ./task.sh STEP LINE     line LINE of commands/STEP.txt
set -euo pipefail
cd "$(dirname "$0")"
step=$1 line=$2
done="state/done/$step/$line"
if [ -e "$done" ]; then
  echo "$step $line: done before"
  exit 0
fi
command=$(sed -n "${line}p" "commands/$step.txt")
if [ -z "$command" ]; then
  echo "task.sh: commands/$step.txt has no line $line" >&2
  exit 2
fi
echo "== $step $line on $(hostname), $(date '+%F %T')"
bash -c "$command"
mkdir -p "state/done/$step"
: >"$done"
