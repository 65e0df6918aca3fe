"""`python -m poropunch`: the same as the command `poropunch`."""

from ._command import main

main()
