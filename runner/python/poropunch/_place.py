"""Where the wheel keeps what cargo built."""

import os

_BUILT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "built")

#: The command line.
PROGRAM = os.path.join(_BUILT, "runner")
#: The model's library, which the command line looks for beside itself.
LIBRARY = os.path.join(_BUILT, "libporopunch_fmi.so")
#: The FMU.
FMU = os.path.join(_BUILT, "poropunch.fmu")
