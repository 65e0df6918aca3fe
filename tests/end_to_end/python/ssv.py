"""Reads parameter sets as FMPy does, after a check by the standard's schema; prints name, type, value, unit."""

import sys

from fmpy.ssp.ssd import read_ssv

for parameter in read_ssv(sys.argv[1]).parameters:
    print(parameter.name, parameter.type, parameter.value, getattr(parameter, "unit", None) or "-", sep="\t")
