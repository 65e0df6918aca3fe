# HyperQueue: one process holds the server and its workers, as its package for Python has them; a new one has a new directory.
# shellcheck shell=bash disable=SC2154
PATH=$(dirname "$python"):$PATH
hyperqueue_start() {
    hyperqueue_starts=$((${hyperqueue_starts:-0} + 1))
    export HQ_SERVER_DIR=$work/queue.$hyperqueue_starts
    "$python" "$here/cluster.py" "$HQ_SERVER_DIR" >"$work/queue.$hyperqueue_starts.log" 2>&1 &
    hyperqueue_server=$!
    until grep -qs ready "$work/queue.$hyperqueue_starts.log"; do
        kill -0 "$hyperqueue_server" || { cat "$work/queue.$hyperqueue_starts.log"; exit 1; }
        sleep 0.2
    done
}
hyperqueue_stop() { kill_all "$hyperqueue_server"; }
hyperqueue_revive() { kill -0 "$hyperqueue_server" 2>/dev/null || hyperqueue_start; }
hyperqueue_forget() { :; }
# What a worker runs, with all that it started.
hyperqueue_kill_worker() {
    # shellcheck disable=SC2046
    kill_all $(pgrep -P "$hyperqueue_server" | head -1)
}
# Without what the workers run, which ends or goes on as it likes.
hyperqueue_kill_server() {
    kill -9 "$hyperqueue_server"
    wait "$hyperqueue_server" 2>/dev/null || true
}
hyperqueue_slots() { echo 2; }
