#!/usr/bin/env bash
# The scripts of docs/clusters.md, on one machine: the Slurm array on a cluster of one node, GNU parallel, and the
# Kubernetes manifest against its schema. Run it as root, with slurm-wlm, munge and parallel installed; what is missing is
# skipped. COSMIC_PROGRAM names a built program.
set -euo pipefail
cd "$(dirname "$0")/.."
page=$PWD/docs/clusters.md

say() { printf '\n== %s\n' "$1"; }
fail() {
  echo "FAILED: $1" >&2
  exit 1
}
# Prints the code of the section $1.
section() { awk -v name="## $1" '/^## / { on = $0 == name } on && /^```/ { code = !code; next } on && code' "$page"; }

if [ -z "${COSMIC_PROGRAM:-}" ]; then
  cargo build --release --quiet -p cosmic-program
  COSMIC_PROGRAM=$PWD/target/release/cosmic
fi
here=$(mktemp -d)
mkdir "$here/bin"
ln -s "$(realpath "$COSMIC_PROGRAM")" "$here/bin/cosmic"
export PATH=$here/bin:$PATH
cd "$here"
# Stops everything that was started, even after a failure.
stop() {
  for pid in slurmd slurmctld; do
    [ ! -f "$here/slurm/$pid.pid" ] || kill "$(cat "$here/slurm/$pid.pid")" 2>/dev/null || true
  done
  rm -rf "$here"
}
trap stop EXIT

# Prints the results of the sweep $1 without wall times, which may differ.
results() {
  cosmic sweep merge "$1" --quiet
  awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) if ($k == "seconds") skip = k } { $skip = ""; print }' OFS=, \
    "$1/results.csv"
}
same() {
  results sweeps/friction >array.csv
  cmp serial.csv array.csv || fail "$1: the results differ from those of a single process"
  rm -r sweeps
  echo "$1: the results of a single process, byte for byte"
}

say 'a single process: 24 runs'
grep -m 1 '^cosmic sweep run coulomb' "$page" | sed 's/sweeps\/friction .*/serial --quiet/' >serial.sh
bash serial.sh
results serial >serial.csv

say 'Slurm'
if [ "$(id -u)" = 0 ] && command -v slurmctld slurmd munged >/dev/null; then
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
StateSaveLocation=$here/slurm/controller
SlurmdSpoolDir=$here/slurm/node
SlurmctldPidFile=$here/slurm/slurmctld.pid
SlurmdPidFile=$here/slurm/slurmd.pid
SlurmctldLogFile=$here/slurm/slurmctld.log
SlurmdLogFile=$here/slurm/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerParameters=batch_sched_delay=1,sched_interval=2,bf_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
JobRequeue=1
ReturnToService=2
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$here/slurm/slurm.conf
  slurmctld
  slurmd
  sleep 3
  section Slurm >array.sh
  job=$(sbatch --parsable array.sh)
  sleep 10
  echo 'the signal that a task gets before its time is up, and one task requeued by hand'
  scancel --batch --signal=TERM "${job}_0" || true
  scontrol requeue "${job}_1" || true
  began=$SECONDS
  while squeue --noheader | grep -q .; do
    [ "$((SECONDS - began))" -lt 1800 ] || fail 'the array does not come to its end'
    sleep 2
  done
  same Slurm
else
  echo 'no Slurm, or not root: skipped'
fi

say 'GNU parallel'
if command -v parallel >/dev/null; then
  section 'GNU parallel' >parallel.sh
  bash parallel.sh >/dev/null 2>&1
  same parallel
else
  echo 'no GNU parallel: skipped'
fi

say 'Kubernetes: the manifest against the schema'
section Kubernetes >job.yaml
if python3 -m venv checker >/dev/null 2>&1 && checker/bin/pip install --quiet kubernetes-validate >/dev/null 2>&1; then
  checker/bin/kubernetes-validate --strict job.yaml
else
  echo 'no checker of the schema: skipped'
fi
