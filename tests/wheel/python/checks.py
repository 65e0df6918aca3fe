"""What the tests of the Python package share. Their first argument is the folder data/."""

import sys
import time
from pathlib import Path

DATA = Path(sys.argv[1])
P2 = DATA / "measurement" / "table1-one-cycle" / "P2.csv"


def refuses(kind, part, call):
    """`call` raises a `kind` that says `part`."""
    try:
        call()
    except kind as error:
        assert part in str(error), f"{part!r} is not in {error}"
    else:
        raise AssertionError(f"not refused: {part}")


def run_all(tests):
    """Runs every function `test_...` of a module, and prints what each costs."""
    for name, test in list(tests.items()):
        if name.startswith("test_"):
            start = time.perf_counter()
            test()
            print(f"{name}: {time.perf_counter() - start:.1f} s", flush=True)
