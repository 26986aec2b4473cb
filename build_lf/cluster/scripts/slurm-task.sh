#!/usr/bin/env bash
# A task of an array job of Slurm: does a command by task.sh. If it fails, the task is queued again, on
# another node where there is one, as the fault may be the node's: its disk may be full.
#   ./slurm-task.sh STEP LINE
set -uo pipefail
cd "$(dirname "$0")" || exit 1
most_restarts=3
wrong_usage=2 # fails everywhere

./task.sh "$1" "$2" && exit
status=$?
# Cancelled, out of its time, or making room for others, of which Slurm takes care.
case $status in 130 | 143) exit "$status" ;; esac
restarts=${SLURM_RESTART_COUNT:-0}
if [ "$status" -eq "$wrong_usage" ] || [ "$restarts" -ge "$most_restarts" ]; then
  echo "$1 $2: failed ($status) on $SLURMD_NODENAME, and is not tried again"
  exit "$status"
fi
echo "$1 $2: failed ($status) on $SLURMD_NODENAME; to be tried again"
# Slurm ends a task that is queued again; the node is still to be excluded then.
trap '' TERM
# Not SLURM_JOB_ID: one task of an array has the number of the whole array.
task="${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
scontrol requeue "$task" || exit "$status"
others=$(sinfo -h -N -o %N -t idle,mixed,allocated -p "$SLURM_JOB_PARTITION" | sort -u |
  grep -cvFx "$SLURMD_NODENAME")
if [ "$others" -gt 0 ]; then
  scontrol update "JobId=$task" "ExcNodeList=$SLURMD_NODENAME"
fi
exit "$status"
