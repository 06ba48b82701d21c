#!/usr/bin/env bash
# Sweeps on real schedulers, on one machine: a Slurm cluster of one node, GNU parallel, two hosts that share a
# folder over a network, a full disk, a study in three processes, and the Kubernetes manifest against its schema.
# Run it by hand, as root on Debian:
#   tests/cluster.sh
# It installs what it needs (slurm-wlm, munge, parallel, faketime, sshfs), takes half an hour, and prints results.
# If the variable COSMIC_PROGRAM names a built program, nothing is built.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '\n== %s\n' "$1"; }
unable() {
  echo "cannot run here: $1"
  exit 77
}
fail() {
  echo "FAILED: $1" >&2
  exit 1
}

[ "$(id -u)" = 0 ] || unable 'it starts daemons, which wants root'
command -v apt-get >/dev/null || unable 'it installs packages of Debian'
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq slurm-wlm munge parallel faketime sshfs openssh-server >/dev/null 2>&1 ||
  unable 'slurm-wlm, munge, parallel, faketime and sshfs cannot be installed'

if [ -z "${COSMIC_PROGRAM:-}" ]; then
  cargo build --release --quiet -p cosmic-program
  COSMIC_PROGRAM=$PWD/target/release/cosmic
fi
# Creates a new folder with the program as `cosmic` in it.
here=$(mktemp -d)
mkdir "$here/bin"
ln -s "$(realpath "$COSMIC_PROGRAM")" "$here/bin/cosmic"
export PATH=$here/bin:$PATH
cd "$here"

# Stops everything that was started, even after a failure.
stop() {
  scancel --full --user="$(id -un)" 2>/dev/null || true
  for pid in slurmd slurmctld; do
    [ ! -f "$here/slurm/$pid.pid" ] || kill "$(cat "$here/slurm/$pid.pid")" 2>/dev/null || true
  done
  pkill -f "^$here/bin/cosmic" 2>/dev/null || true
  for mounted in one two disk; do
    ! mountpoint -q "$here/$mounted" || umount "$here/$mounted"
  done
  [ ! -f "$here/sshd.pid" ] || kill "$(cat "$here/sshd.pid")" 2>/dev/null || true
  rm -rf "$here"
}
trap stop EXIT

# Prints the results in $1.json and $1.csv without wall times, which may differ.
untimed() {
  sed -E 's/"seconds": ?[0-9.e+-]+/"seconds":0/g' "$1.json"
  # The table's column of that name.
  awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) if ($k == "seconds") skip = k } { $skip = ""; print }' OFS=, \
    "$1.csv"
}
results() {
  cosmic sweep merge "$1" --quiet
  untimed "$1/results"
}
same() {
  results "$1" >"$1.results"
  cmp serial.results "$1.results" || fail "$1: results differ from those of the serial run"
  echo "$1: same results as the serial run, byte for byte (except wall times)"
}
left() { cosmic sweep status "$1" --json | grep -c '"state": *"\(waiting\|begun\)"' || true; }
plan() { cosmic sweep plan coulomb --grid physics.friction=0.6,1,2.5 --seeds 8 --quiet --out "$1"; }

say 'serial: 24 runs'
plan serial
began=$SECONDS
cosmic sweep run serial --threads "$(nproc)" --quiet
results serial >serial.results
echo "$((SECONDS - began)) s on $(nproc) cores"

say 'Slurm: controller and node daemon on the loopback'
mkdir -p slurm/controller slurm/node /run/munge
[ -s /etc/munge/munge.key ] || dd if=/dev/urandom of=/etc/munge/munge.key bs=1024 count=1 status=none
chown munge:munge /etc/munge/munge.key /run/munge
chmod 400 /etc/munge/munge.key
pgrep -x munged >/dev/null || runuser -u munge -- munged
node=$(hostname -s)
cat >slurm/slurm.conf <<CONF
ClusterName=one
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=cred_expire=30
StateSaveLocation=$here/slurm/controller
SlurmdSpoolDir=$here/slurm/node
SlurmctldPidFile=$here/slurm/slurmctld.pid
SlurmdPidFile=$here/slurm/slurmd.pid
SlurmctldLogFile=$here/slurm/slurmctld.log
SlurmdLogFile=$here/slurm/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=1,sched_interval=2,bf_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
JobRequeue=1
ReturnToService=2
KillWait=10
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$here/slurm/slurm.conf
slurmctld
slurmd
sleep 3
sinfo

plan slurm-sweep
# Twelve consecutive runs per task take longer than the minute after which a task saves its runs.
cosmic sweep script slurm-sweep --slurm --throttle 2 --minutes 2 --seeds-per-task 12 --out array.sh
job=$(sbatch --parsable array.sh)
echo "array $job: $(grep -- --array array.sh)"
sleep 20
squeue
echo 'the second task is cancelled and requeued'
scontrol requeue "${job}_1" || scontrol requeue "${job}_12" || true
sleep 15
echo 'the node daemon is restarted'
kill "$(cat slurm/slurmd.pid)"
sleep 2
slurmd
began=$SECONDS
until [ "$(left slurm-sweep)" = 0 ]; do
  [ "$((SECONDS - began))" -lt 3600 ] || fail 'the array does not come to its end'
  sleep 5
done
grep -h 'interrupted' slurm-sweep/logs/* | sort | uniq -c || fail 'no task was stopped by its time limit'
same slurm-sweep

say 'GNU parallel: one process killed'
plan parallel-sweep
cosmic sweep script parallel-sweep --parallel --throttle 2 --out parallel.sh
bash parallel.sh &
tasks=$!
sleep 8
pkill -9 -o -f 'cosmic sweep run parallel-sweep'
wait "$tasks" || echo 'parallel says that a task failed'
echo "left: $(left parallel-sweep); started again"
cosmic sweep script parallel-sweep --parallel --throttle 2 --out parallel.sh
bash parallel.sh
same parallel-sweep

say 'two hosts that share a folder over a network, their clocks ten minutes apart; one disappears'
mkdir shared one two /run/sshd 2>/dev/null || true
ssh-keygen -q -t ed25519 -N '' -f key
ssh-keygen -q -t ed25519 -N '' -f host-key
cat >sshd.conf <<CONF
Port 2222
ListenAddress 127.0.0.1
HostKey $here/host-key
AuthorizedKeysFile $here/key.pub
PidFile $here/sshd.pid
StrictModes no
PermitRootLogin yes
UsePAM no
Subsystem sftp internal-sftp
CONF
/usr/sbin/sshd -f sshd.conf
# Each host has its own mount, which does not share locks and caches directory listings for 20 s.
for host in one two; do
  sshfs -p 2222 -o "IdentityFile=$here/key,StrictHostKeyChecking=no,UserKnownHostsFile=/dev/null" \
    "127.0.0.1:$here/shared" "$host" 2>/dev/null || fail 'no file system over the network'
done
plan one/sweep
# Each host has its own network and name. The clock of the second host is ahead; monotonic time is not affected.
host() { unshare --net --uts sh -c 'hostname "$0"; exec "$@"' "$@"; }
host one cosmic sweep run one/sweep --threads 1 --quiet &
first=$!
export FAKETIME_DONT_FAKE_MONOTONIC=1
host two faketime -f +10m cosmic sweep run two/sweep --threads 1 --quiet &
second=$!
sleep 15
pkill -9 -P "$first" 2>/dev/null || kill -9 "$first"
echo "the first host is gone after $(cosmic sweep status shared/sweep --json | grep -c '"done"') runs; the claims:"
head -qn 1 shared/sweep/claims/*/* | sort | uniq -c
began=$SECONDS
wait "$second" || fail 'the second host did not finish'
echo "the second host finished all runs, $((SECONDS - began)) s later"
same shared/sweep

say 'a disk that fills up'
mkdir disk
mount -t tmpfs -o size=12m tmpfs disk
plan disk/sweep
code=0
cosmic sweep run disk/sweep --threads "$(nproc)" --quiet || code=$?
[ "$code" = 4 ] || fail "exit code $code where no run can be written"
echo "exit code 4, left: $(left disk/sweep); the disk grows"
mount -o remount,size=1g disk
cosmic sweep run disk/sweep --threads "$(nproc)" --quiet
same disk/sweep

say 'study paper with four seeds: three processes, and in one go'
mkdir whole planned
(cd whole && cosmic study paper --seeds 4 --runs runs --out results --quiet)
cd planned
cosmic study paper --seeds 4 --plan runs
last=$(($(cosmic sweep status runs --json | grep -c '"state"') - 1))
cosmic sweep run runs --threads 1 --quiet --index "$((last / 2))-$last" &
at_work=$!
cosmic sweep run runs --threads 1 --quiet --index "$((last / 4))-$((last / 2))" &
at_work="$at_work $!"
cosmic sweep run runs --threads 1 --quiet
for process in $at_work; do wait "$process"; done
cosmic study paper --seeds 4 --runs runs --out results --quiet
cd ..
for folder in whole planned; do
  untimed "$folder/results/paper" >"$folder.results"
  rm "$folder"/results/paper.json "$folder"/results/paper.csv
  # The second to last column of its tables has wall times.
  sed -i -E 's/\| [0-9.]+ (\| ([A-Z]+|none) \|)$/| - \1/' "$folder/results/paper.md"
done
cmp whole.results planned.results || fail 'the results of the study differ'
diff -r whole/results planned/results || fail 'the document of the study differs'
echo "$((last + 1)) runs; document and figures are equal ($(find whole/results -type f | wc -l) files), and so are the numbers"

say 'Kubernetes: the manifest against the schema'
plan kubernetes-sweep
cosmic sweep script kubernetes-sweep --kubernetes --throttle 8 --out job.yaml
if python3 -m venv checker && checker/bin/pip install --quiet kubernetes-validate; then
  checker/bin/kubernetes-validate --strict job.yaml
else
  echo 'no schema checker is available, so the manifest is not validated'
fi

say 'done'
