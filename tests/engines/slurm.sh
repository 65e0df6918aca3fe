# Slurm: munge, a controller and two nodes of two slots.
# shellcheck shell=bash disable=SC2154
export SLURM_CONF=$work/slurm.conf
slurm_start() {
    local host
    # Slurm listens only where some address is not the loopback's; this one is the loopback's, too, and nothing uses it.
    ip address add 198.18.0.1/32 dev lo
    host=$(hostname -s)
    cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/builtin
# Tasks that end together are replaced after one second, not three.
SchedulerParameters=batch_sched_delay=1
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool.%n
SlurmctldPidFile=$work/controller.pid
SlurmdPidFile=$work/%n.pid
SlurmctldLogFile=$work/controller.log
SlurmdLogFile=$work/%n.log
SlurmctldPort=36817
MpiDefault=none
ReturnToService=2
SlurmdTimeout=15
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=37001 CPUs=2 RealMemory=2000
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=37002 CPUs=2 RealMemory=2000
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
END
    mkdir "$work/state" "$work/spool.n1" "$work/spool.n2"
    head -c 1024 /dev/urandom >"$work/munge.key"
    chmod 400 "$work/munge.key"
    munged --force --socket="$work/munge.socket" --key-file="$work/munge.key" --pid-file="$work/munged.pid" \
        --log-file="$work/munged.log" --seed-file="$work/munge.seed"
    slurmctld
    slurmd -N n1
    slurmd -N n2
}
slurm_stop() {
    local name
    for name in n1 n2 controller munged; do kill -9 "$(cat "$work/$name.pid")" 2>/dev/null || true; done
}
# What was killed may stay as a zombie for a while.
slurm_is_up() { grep -qs '^State:[[:space:]]*[^ZX]' "/proc/$(cat "$work/$1.pid")/status"; }
slurm_revive() {
    slurm_is_up controller || slurmctld
    local node
    for node in n1 n2; do slurm_is_up "$node" || slurmd -N "$node"; done
    # A controller that lost its last seconds gives out the same numbers again and drains the nodes for it: the administrator's to undo.
    for node in $(sinfo -h -N -t drain -o %N); do scontrol update NodeName="$node" State=RESUME || true; done
}
slurm_forget() { scancel --user=root || true; }
# A node, with all that it runs.
slurm_kill_worker() {
    local node=n$((RANDOM % 2 + 1)) job
    for job in $(squeue -h -t R -w "$node" -o %A); do
        # shellcheck disable=SC2046
        kill_all $(pgrep -f "^slurmstepd: \[$job\." || true)
    done
    slurm_end "$node"
}
slurm_kill_server() { slurm_end controller; }
slurm_end() {
    kill -9 "$(cat "$work/$1.pid")"
    while slurm_is_up "$1"; do sleep 0.1; done
}
slurm_slots() { echo 4; }
