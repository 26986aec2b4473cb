#!/usr/bin/env bash
# Hands what is not done yet to Slurm: an array job for each step, each after those it needs, and a
# last job that says what is missing. Give it again to do what is missing.
#   ./submit.sh [OPTION OF SBATCH...]     for example ./submit.sh --partition=long --account=film
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=steps.sh
. ./steps.sh
options=("$@")
declare -A job_of=()
jobs=''

submit_step() {
  local name=$1 after=$3 missing needed='' step
  missing=$(missing_of "$name" "$2" | ranges)
  [ -n "$missing" ] || return 0
  for step in ${after//,/ }; do
    needed+=${job_of[$step]:+:${job_of[$step]}}
  done
  job_of[$name]=$(sbatch --parsable --chdir="$PWD" --array="$missing" --kill-on-invalid-dep=yes \
    ${needed:+"--dependency=afterok$needed"} "${options[@]}" "slurm/$name.sbatch")
  job_of[$name]=${job_of[$name]%%;*}
  jobs+=:${job_of[$name]}
  echo "job ${job_of[$name]}: $name, block $missing of $2"
}

mkdir -p logs
every_step submit_step
if [ -z "$jobs" ]; then
  echo "all is done"
  exit 0
fi
last=$(sbatch --parsable --chdir="$PWD" --dependency="afterany$jobs" "${options[@]}" \
  slurm/finish.sbatch)
echo "job ${last%%;*}: the last; it writes what is missing to missing.txt"
