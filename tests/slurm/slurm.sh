#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A sweep as a Slurm job array on a cluster of its own: a controller and two nodes on this machine's loopback. One node's
# slurmd is killed (-9) in the middle; the merged tables have to equal those of a local run. Ends all that it started.
# Usage: tests/slurm/slurm.sh MTF     exit code 77: no Slurm here
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
# shellcheck source=tests/slurm/study.sh
. "$here/study.sh"
mtf="$(realpath "$1")"
shards=12

PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd sbatch squeue scancel sinfo; do
  command -v "$program" >/dev/null || skip "no $program on this machine"
done

work="$(mktemp -d "${TMPDIR:-/tmp}/mtfkit_slurm.XXXXXX")"
chmod 755 "$work"
export SLURM_CONF="$work/slurm.conf"

# Ends what this script started, by the numbers that the daemons wrote.
stop() {
  local file pid
  scancel --user="$(id -un)" 2>/dev/null || true
  for file in "$work"/*.pid; do
    [ -s "$file" ] || continue
    pid="$(cat "$file")"
    kill "$pid" 2>/dev/null || true
    for _ in $(seq 50); do
      kill -0 "$pid" 2>/dev/null || break
      sleep 0.1
    done
    kill -9 "$pid" 2>/dev/null || true
  done
}
finish() {
  local status=$?
  if [ "$status" -ne 0 ] && [ "$status" -ne 77 ]; then
    tail -n 20 "$work"/*.log "$work"/plan/*.log >&2 2>/dev/null || true
  fi
  stop
  rm -rf "$work"
  exit "$status"
}
trap finish EXIT
trap 'exit 130' INT TERM

# wait_for SECONDS WHAT COMMAND...: until the command succeeds.
wait_for() {
  local seconds=$1 what=$2 end
  shift 2
  end=$((SECONDS + seconds))
  until "$@" >/dev/null 2>&1; do
    [ "$SECONDS" -lt "$end" ] || fail "waited $seconds s for $what"
    sleep 0.2
  done
}

# Four ports that nobody listens on.
free_ports() {
  /usr/bin/python3 - <<'PYTHON'
import socket
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
print(*(s.getsockname()[1] for s in sockets))
PYTHON
}
read -r port_control port_1 port_2 <<<"$(free_ports)"

user="$(id -un)"
cat >"$SLURM_CONF" <<CONF
ClusterName=mtfkit
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port_control
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=1
# A node that does not answer for this long is down, and its tasks are queued again.
SlurmdTimeout=6
KillWait=2
StateSaveLocation=$work/state
SlurmctldPidFile=$work/slurmctld.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdSpoolDir=$work/spool.%n
SlurmdPidFile=$work/slurmd.%n.pid
SlurmdLogFile=$work/slurmd.%n.log
NodeName=n1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$port_1 CPUs=1 State=UNKNOWN
NodeName=n2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=$port_2 CPUs=1 State=UNKNOWN
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$work/state" "$work/spool.n1" "$work/spool.n2"

(umask 077 && head -c 1024 /dev/urandom >"$work/munge.key")
# --force: a scratch folder below /tmp is not where munged wants its files.
munged --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
  --log-file="$work/munged.log" --seed-file="$work/munged.seed" --num-threads=2
slurmctld
slurmd -N n1
slurmd -N n2
idle() { [ "$(sinfo --noheader --states=idle --format=%D | awk '{n += $1} END {print n + 0}')" = 2 ]; }
wait_for 60 "two idle nodes" idle

cd "$work"
make_study "$mtf"
"$mtf" sweep study.toml -o local --progress none >/dev/null
"$mtf" sweep plan study.toml -o plan --shards $shards >/dev/null
"$mtf" sweep submit plan --engine slurm --submit --threads 1

busy() { [ "$(finished plan)" -ge 2 ] && squeue --noheader --states=running --nodelist=n2 | grep -q .; }
wait_for 120 "a task on n2 behind two finished shards" busy
kill -9 "$(cat slurmd.n2.pid)"
printf 'killed the slurmd of n2 with %s of %s shards finished\n' "$(finished plan)" "$shards"
[ "$(finished plan)" -lt "$shards" ] || fail "all shards were finished before the node was killed"

done_all() { [ "$(finished plan)" = "$shards" ] && ! squeue --noheader | grep -q .; }
wait_for 300 "the other shards" done_all
sinfo --noheader --Node --format='%N is %T'
"$mtf" sweep merge plan -o merged >/dev/null
same_tables local merged
