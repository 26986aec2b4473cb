# shellcheck shell=bash
# A cluster on one machine, for scripts/test-cluster: sourced, not run. Needs the packages of group
# `cluster`, root, and a network and processes of its own (own_system), so that its ports are free and
# nothing outlives the script.
#
# Two nodes, roomy and tight, are a slurmd each with mounts, processes and a host name of its own: Slurm
# tells several slurmd on one machine apart only by host name unless it is built for that. There is no
# systemd, no control groups, no accounting.

# own_system SCRIPT ARGUMENT...: runs the script again in such a system, in which it returns; exits with
# 77 where that is not possible.
own_system() {
  if [ -n "${RAYWALK_OWN_SYSTEM:-}" ]; then
    ip link set lo up
    # Slurm resolves no address where a machine has but 127.0.0.1. This one is for documentation.
    ip address add 192.0.2.1/32 dev lo
    return
  fi
  if [ "$(id -u)" -ne 0 ] || ! unshare --mount --uts --net --pid --fork --mount-proc true; then
    echo "$(basename "$1"): skipped: needs root and namespaces of its own" >&2
    exit 77
  fi
  RAYWALK_OWN_SYSTEM=1 exec unshare --mount --uts --net --pid --fork --kill-child --mount-proc "$@"
}

# write_slurm_config DIR: slurm.conf and cgroup.conf. Timeouts are short, so that a node that is gone is
# known to be in some seconds.
write_slurm_config() {
  local dir=$1
  cat >"$dir/slurm.conf" <<END
ClusterName=one
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
ReturnToService=2
SlurmdParameters=config_overrides
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/%n.pid
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool-%n
SlurmctldPort=16817
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/%n.log
SchedulerParameters=sched_interval=2,sched_min_interval=0,bf_interval=2
SlurmdTimeout=4
MessageTimeout=3
BatchStartTimeout=2
KillWait=2
NodeName=roomy NodeHostname=roomy NodeAddr=127.0.0.1 Port=16818 CPUs=2 RealMemory=1000 State=UNKNOWN
NodeName=tight NodeHostname=tight NodeAddr=127.0.0.1 Port=16819 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
  mkdir "$dir/cgroups"
  printf '%s\n' CgroupPlugin=cgroup/v1 ConstrainCores=no >"$dir/cgroup.conf"
  if ! grep -q '^cgroup /sys/fs/cgroup/' /proc/mounts; then
    echo "CgroupMountpoint=$dir/cgroups" >>"$dir/cgroup.conf"
  fi
}

declare -A node_of=()  # what starts a node's first process, by name

# start_node NAME: in a system of its own, all of whose processes end with the first, which starts
# slurmd again when it ends.
start_node() {
  # shellcheck disable=SC2016  # expanded by that shell
  unshare --mount --uts --pid --fork --kill-child --mount-proc bash -c \
    'hostname "$1" && while :; do slurmd -D -f "$SLURM_CONF" -N "$1"; sleep 1; done' - "$1" \
    >>"$slurm_dir/$1.out" 2>&1 &
  node_of[$1]=$!
}

# first_process NAME: that of the node.
first_process() { pgrep -P "${node_of[$1]}"; }

# kill_slurmd NAME: its tasks go on.
kill_slurmd() { pkill -9 -x -P "$(first_process "$1")" slurmd; }

# crash_node NAME: as if its power failed.
crash_node() {
  kill -9 "${node_of[$1]}"
  wait "${node_of[$1]}" 2>/dev/null || true
}

# wait_for_nodes STATE COUNT: waits until so many nodes have that state (idle, down).
wait_for_nodes() {
  local end=$((SECONDS + 30))
  until [ "$(timeout 2 sinfo -h -N -o %T 2>/dev/null | grep -c "^$1")" -ge "$2" ]; do
    if [ $SECONDS -ge $end ]; then
      echo "$(basename "$0"): waited too long for $2 nodes that are $1" >&2
      return 1
    fi
    sleep 0.2
  done
}

# start_slurm DIR: munge, slurmctld and both nodes.
start_slurm() {
  slurm_dir=$1
  mkdir -p "$slurm_dir/state" "$slurm_dir/spool-roomy" "$slurm_dir/spool-tight"
  mkdir -m 700 "$slurm_dir/munge"
  dd if=/dev/urandom of="$slurm_dir/munge/key" bs=1024 count=1 status=none
  chmod 400 "$slurm_dir/munge/key"
  write_slurm_config "$slurm_dir"
  export SLURM_CONF=$slurm_dir/slurm.conf
  munged --foreground --force --key-file "$slurm_dir/munge/key" --socket "$slurm_dir/munge/socket" \
    --pid-file "$slurm_dir/munge/pid" --log-file "$slurm_dir/munge/log" \
    --seed-file "$slurm_dir/munge/seed" >"$slurm_dir/munged.out" 2>&1 &
  until [ -S "$slurm_dir/munge/socket" ]; do
    kill -0 $! || return 1
    sleep 0.05
  done
  slurmctld -D -f "$SLURM_CONF" >"$slurm_dir/slurmctld.out" 2>&1 &
  start_node roomy
  start_node tight
  wait_for_nodes idle 2
}
