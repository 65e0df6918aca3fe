"""The command `poropunch`: the program of the wheel in the place of Python."""

import os
import sys

from ._place import PROGRAM


def main() -> None:
    os.execv(PROGRAM, ["poropunch", *sys.argv[1:]])
