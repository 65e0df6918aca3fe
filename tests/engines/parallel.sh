# GNU parallel: its server is the process that the submission runs, its workers are that one's children.
# shellcheck shell=bash disable=SC2154
parallel_start() { :; }
parallel_stop() { :; }
parallel_revive() { :; }
parallel_forget() { :; }
parallel_processes() {
    local process
    for process in $(descendants "$submission"); do
        grep -qs "$1" "/proc/$process/cmdline" && echo "$process"
    done
}
parallel_kill_worker() {
    kill_all $(parallel_processes 'study.work' | head -1)
}
# Without its children, which end or go on as they like.
parallel_kill_server() {
    # shellcheck disable=SC2046
    kill -9 $(parallel_processes 'parallel' | head -1) 2>/dev/null || true
}
parallel_slots() { nproc; }
