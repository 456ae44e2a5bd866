#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# slurm_test.sh ALIDADE: runs the script of docs/cluster.md on a Slurm of this machine alone, kills a task, and compares the
# merged image with that of one run. The daemons of this test have a folder, a key and ports of their own. Where they are absent
# (Debian: slurmctld, slurmd, slurm-client, munge), or the user is not root, it ends with 77: skipped.
set -euo pipefail
program=$(realpath -- "$1")
page=$(realpath -- "$(dirname -- "$0")/../../docs/cluster.md")
scenes=$(realpath -- "$(dirname -- "$0")/../../scenes")
for tool in munged slurmctld slurmd sbatch scontrol squeue; do
  PATH=$PATH:/usr/sbin command -v "$tool" >/dev/null || { echo "skipped: $tool is not installed" && exit 77; }
done
((EUID == 0)) || { echo "skipped: Slurm needs root" && exit 77; }
export PATH=$PATH:/usr/sbin

folder=$(mktemp -d /tmp/alidade_slurm.XXXXXX)
chmod 755 "$folder"
daemons=()
finish() {
  local code=$?
  ((code == 0)) || tail -n 20 "$folder"/*.log || true
  if [[ -n ${job:-} ]]; then scancel --quiet "$job" ${merge:+"$merge"} || true; fi
  for daemon in "${daemons[@]}"; do kill "$daemon" 2>/dev/null || true; done
  wait
  rm -rf -- "$folder"
}
trap finish EXIT

port=$((20000 + RANDOM % 20000))
host=$(hostname -s)
mkdir "$folder"/{munge,state,spool,work}
head -c 128 /dev/urandom >"$folder/munge/key"
chmod 700 "$folder/munge" && chmod 400 "$folder/munge/key"
cat >"$folder/slurm.conf" <<CONF
ClusterName=alidade
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
# A requeued job starts when its credentials have expired.
AuthInfo=socket=$folder/munge/socket,cred_expire=10
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=batch_sched_delay=1,sched_interval=1
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobRequeue=1
KillWait=1
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf

munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
  --pid-file="$folder/munge/pid" --log-file="$folder/munged.log" --seed-file="$folder/munge/seed" 2>"$folder/munged_out.log" &
daemons+=($!)
until_true() {  # SECONDS COMMAND...
  local end=$((SECONDS + $1))
  shift
  until "$@"; do
    ((SECONDS < end)) || { echo "too late: $*" >&2 && return 1; }
    sleep 0.2
  done
}
until_true 20 test -S "$folder/munge/socket"
slurmctld -D -i >"$folder/slurmctld_out.log" 2>&1 &
daemons+=($!)
slurmd -D >"$folder/slurmd_out.log" 2>&1 &
daemons+=($!)
is_idle() { [[ $(sinfo --noheader --format=%t 2>/dev/null) == idle ]]; }
until_true 60 is_idle

# The script of the page, with what a small machine can do.
cd "$folder/work"
ln -s "$program" alidade && ln -s "$scenes" scenes
options="render scenes/courtyard.json --site courtyard --size 160x120 --samples 200 --layers color,depth,normal,id,variance"
awk '/^```bash/ { inside = ++blocks == 1; next } /^```/ { inside = 0 } inside' "$page" |
  sed -e 's/--array=1-20/--array=1-4/' -e 's/PARTS=20 /PARTS=4 /' -e 's/--cpus-per-task=16/--cpus-per-task=1/' \
    -e '/--mem=/d' -e "s|^RENDER=.*|RENDER=\"./alidade $options --checkpoint-interval 0.1 -o picture.exr\"|" >render_parts.sh
grep -q 'PARTS=4 ' render_parts.sh
grep -q 'array=1-4' render_parts.sh
./alidade $options -q -o whole.exr
merge='' job=$(sbatch --parsable render_parts.sh)
merge=$(sbatch --parsable --dependency="afterok:$job" --output=merge.log --wrap './alidade merge picture.exr.part* -o picture.exr')

until_true 120 test -f picture.state2
sleep 0.5
task=$(pgrep -f -- "^./alidade .*-o picture.exr --part 2/4 ")
echo "killing part 2, process $task"
kill -KILL "$task"
is_done() { [[ -z $(squeue --noheader --jobs="$job,$merge" 2>/dev/null) ]]; }
until_true 400 is_done
cat part2.log merge.log
[[ $(grep -c 'resuming from picture.state2' part2.log) == 1 ]] || { echo "part 2 was not resumed" >&2 && exit 1; }
cmp whole.exr picture.exr
[[ ! -e picture.state2 ]]
echo "the merged image has the bytes of one run"
