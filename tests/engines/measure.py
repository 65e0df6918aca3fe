"""What studies cost. Numbers of runner/src/study/README.md come from here; run it on a quiet machine.

    measure.py efficiency STUDY_TABLE   units of a table of specimens by 1, 2 and 4 workers
    measure.py gather [UNITS]           plan, status and gather of a hundred thousand units, whose results are links to a few
    measure.py operations               system calls on files of one unit (needs strace)
    measure.py cluster                  simulation of a thousand cores that work on 1e5 units over one file server
The overhead of an engine: tests/engines/run, whose last lines have it.
"""

import collections
import heapq
import json
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUNNER = os.environ.get("RUNNER", str(ROOT / "target/release/runner"))
DATA = ROOT / "data/measurement/table1-one-cycle/P2.csv"
FIT = ["--", "--mesh", "coarse", "--profile", "none"]


def run(*words):
    """Wall time (s), CPU time (s) and memory (MB) of a command."""
    began = time.monotonic()
    process = subprocess.Popen([RUNNER, *map(str, words)], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    assert status == 0, words
    return time.monotonic() - began, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def units(study):
    return [json.loads(line) for line in open(study / "units.jsonl")]


def results(study):
    return [json.loads(f.read_text()) for f in (study / "results/results").glob("*/*.json")]


def efficiency(table):
    one = None
    for workers in (1, 2, 4):
        with tempfile.TemporaryDirectory() as folder:
            study = Path(folder) / "study"
            run("study", "plan", table, "--out", study, *FIT)
            wall, cpu, _ = run("study", "work", study, "--all", "--jobs", workers)
            inside = [r["run"] for r in results(study)]
        one = one or wall
        overhead = 1e3 * sum(r["overhead_seconds"] for r in inside) / len(inside)
        print(
            f"{workers} workers: {len(inside)} units in {wall:.1f} s, {one / wall:.2f} times as fast as one, "
            f"{cpu:.1f} s of CPU; reading, checking and writing {overhead:.2f} ms a unit"
        )


def gather(count):
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR", "/tmp")) as folder:
        folder = Path(folder)
        table = folder / "specimens.csv"
        with open(table, "w") as file:
            file.write("specimen,files,group,geometry.sample_height [mm]\n")
            for k in range(count):
                file.write(f"s{k},{DATA},{'ab'[k % 2]},{10 + 1e-6 * k:.6f}\n")
        study = folder / "study"
        print("plan:   %.1f s wall, %.1f s CPU, %.0f MB" % run("study", "plan", table, "--out", study, *FIT))
        run("study", "work", study, "--unit", "1-8")
        done = sorted((study / "results/results").glob("*/*.json"))
        for k, unit in enumerate(units(study)):
            place = study / "results/results" / unit["key"][:2] / f"{unit['key']}.json"
            place.parent.mkdir(exist_ok=True)
            if not place.exists():
                os.link(done[k % len(done)], place)
        print("status: %.1f s wall, %.1f s CPU, %.0f MB" % run("study", "status", study))
        print("gather: %.1f s wall, %.1f s CPU, %.0f MB" % run("study", "gather", study))
        for file in sorted((study / "gathered").iterdir()):
            print(f"  {file.name}: {file.stat().st_size / 1e6:.1f} MB")


# Calls that ask a file server's metadata; reads of what is open do not.
METADATA = "open,openat,creat,stat,newfstatat,statx,access,faccessat2,mkdir,mkdirat,unlink,unlinkat,rename,renameat2,link,linkat,fsync,chmod,fchmod,utimensat,getdents64"


def operations():
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "study"
        table = Path(folder) / "sets.csv"
        table.write_text("material.equilibrium.mu [Pa]\n-200\n-210\n-220\n")
        run("study", "plan", table, "--question", "batch", "--rows", "1", "--out", study, "--", "--mesh", "coarse")
        run("study", "work", study, "--unit", "1")
        trace = Path(folder) / "trace"
        subprocess.run(
            ["strace", "-f", "-y", "-qq", "-e", f"trace={METADATA}", "-o", trace, RUNNER, "study", "work", study, "--unit", "2"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        counts = collections.Counter()
        for line in trace.read_text().splitlines():
            # What lies on the shared file system: plan and results; the program and its libraries once per task.
            call = re.match(r"\d+ +(\w+)\(", line)
            if call and str(study) in line:
                counts[call.group(1)] += 1
        print(f"{sum(counts.values())} operations on plan and results:", dict(counts))


def cluster():
    """A thousand workers take units of a task of 100; a server answers metadata operations one after another."""
    cores, count, per_task, mean = 1000, 100_000, 100, 10.0
    for server, rate in (("a slow one, 1000 operations a second", 1e3), ("an ordinary one, 10,000", 1e4)):
        for at_start, told in ((0.0, "all tasks start at once"), (60.0, "tasks start within a minute")):
            rng = random.Random(1)
            free, waited, busiest = 0.0, 0.0, collections.Counter()
            events = [(rng.uniform(0, at_start) if at_start else 0.0, worker, 0, True) for worker in range(cores)]
            heapq.heapify(events)
            end = 0.0
            while events:
                now, worker, done, begins = heapq.heappop(events)
                # The program and its FMU are loaded with 40 lookups at a task's start; then before and after each unit.
                asked = BEFORE + (40 if begins and done == 0 else 0) if begins else AFTER
                free = max(free, now) + asked / rate
                waited += free - now
                busiest[int(now)] += asked
                end = max(end, free)
                if begins:
                    # Fits differ by a factor of two either way.
                    heapq.heappush(events, (free + mean * rng.lognormvariate(-0.125, 0.5), worker, done, False))
                elif done + 1 < per_task and worker * per_task + done + 1 < count:
                    heapq.heappush(events, (free, worker, done + 1, True))
            ideal = count * mean / cores
            print(
                f"{server}; {told}: {end:.0f} s where {ideal:.0f} s is the work alone; waiting for files "
                f"{waited / count:.2f} s a unit, {100 * waited / (count * mean):.1f} % of its work; at most "
                f"{max(busiest.values())} operations asked for in one second"
            )


# Of one unit, as `operations` counts them, before and after its command.
BEFORE, AFTER = 9, 8

if __name__ == "__main__":
    what, *more = sys.argv[1:]
    if what == "efficiency":
        efficiency(Path(more[0]).resolve())
    elif what == "gather":
        gather(int(more[0]) if more else 100_000)
    elif what == "operations":
        operations()
    else:
        cluster()
