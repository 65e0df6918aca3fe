"""The Python package over the program: what needs no extension module. Arguments: the folder data/."""

import os
import signal
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy
import pandas
from checks import P2, refuses, run_all

import poropunch
from poropunch import _data, _place, _program
from poropunch.results import diagnosis
from poropunch.results._read import read


def test_doctests():
    import doctest

    for module in (_program, _data):
        failed, tried = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
        assert tried and not failed, module


def test_the_module_alone_loads_neither_numpy_nor_pandas():
    code = "import sys, poropunch._command; assert not {'numpy', 'pandas'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_command():
    said = subprocess.run([sys.executable, "-m", "poropunch", "--version"], check=True, capture_output=True, text=True)
    assert said.stdout.split()[1].startswith("0."), said


def test_inspect_reads_paths_tables_and_arrays_alike():
    table = pandas.read_csv(P2, comment="#")
    table = table[["time_s", "displacement_mm", "force_mN"]]
    columns = tuple(table[name].to_numpy() for name in table)
    peaks = []
    for given in (table, columns, numpy.column_stack(columns), {"P2": table}):
        seen = poropunch.inspect(given)
        assert seen.report.schema.startswith("poropunch.inspection/"), seen.report.schema
        peaks.append(seen.cycles["peak_mn_median"][0])
        assert seen.report.tests[0].cycles[0].peak_mn.median == peaks[-1]
    assert seen.report.tests[0].name == "P2"
    assert 11.5 < peaks[0] < 12.5 and len(set(peaks)) == 1, peaks
    assert poropunch.inspect(P2).report.tests[0].points == len(table)


def test_identify():
    events = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = poropunch.identify(P2, mesh="coarse", progress=events.append, fix={"material.permeability": "2.3e-9 mm^2"})
    # Geometry that was not given is a warning, raised where the user called.
    told = [w for w in caught if w.category is poropunch.PoropunchWarning]
    assert any("punch radius" in str(w.message) and w.filename == __file__ for w in told), [(str(w.message), w.filename) for w in told]
    assert found.converged and "K0" not in found.parameters.index
    # 234 Pa went into the data (README: 245 [219, 272] on the standard mesh).
    assert 210 < found.derived.value["G_inf"] < 280, found.derived
    curves = found.curves
    assert numpy.abs(curves.model_mN - curves.measured_mN).max() < 1 and set(curves.measurement) == {"P2"}
    assert any(e["event"] == "iteration" and e["chi_square"] > 0 for e in events)
    page = found._repr_html_()
    assert page.startswith("<iframe srcdoc=") and "&lt;svg" in page
    assert str(found).startswith(found.report.verdict.headline)


def test_a_fit_that_does_not_converge_warns_and_returns():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = poropunch.identify(P2, mesh="coarse", max_evaluations=2)
    assert not found.converged and any("did not converge" in str(w.message) for w in caught)


def test_errors():
    refuses(ValueError, "cannot be read", lambda: poropunch.inspect("nowhere.csv"))
    refuses(ValueError, "--nonsense", lambda: poropunch.inspect(P2, nonsense=1))
    refuses(ValueError, "material.permeability", lambda: poropunch.identify(P2, fix={"material.permeabilty": "1 mm^2"}))
    refuses(ValueError, "(n, 3)", lambda: poropunch.inspect(numpy.zeros((5, 2))))
    refuses(ValueError, "equal length", lambda: poropunch.inspect((numpy.zeros(5), numpy.zeros(4), numpy.zeros(5))))
    refuses(ValueError, "name of a test", lambda: poropunch.inspect({"a/b": numpy.zeros((5, 3))}))


def test_results_of_every_kind_are_read():
    course = {"with": "step", "from_s": 3.0}
    leftover = {"course": course, "off_contact": None, "part": 0.5, "specimens": None, "test": "P2"}
    found = read(diagnosis.Leftover, {**leftover, "of a later version": 1})
    assert found.course == course and found.test == "P2"


def test_interrupt():
    """Ctrl-C reaches the program, which keeps what is done, and Python, which goes on."""
    with tempfile.TemporaryDirectory() as folder:
        code = (
            "import signal, sys, poropunch\n"
            # Tests that run in the background inherit that Ctrl-C is ignored.
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "try:\n"
            "    poropunch.identify(sys.argv[1], out=sys.argv[2], progress=lambda e: print(e['event'], flush=True))\n"
            "except KeyboardInterrupt:\n"
            "    print('stopped', flush=True)\n"
        )
        out = Path(folder) / "out"
        line = [sys.executable, "-W", "ignore", "-c", code, str(P2), str(out)]
        with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as python:
            for said in python.stdout:
                if said.strip() == "iteration":
                    break
            python.send_signal(signal.SIGINT)
            rest = python.stdout.read()
        assert rest.strip().endswith("stopped") and python.returncode == 0, rest
        # Nothing of it runs on, and what was done is there to be resumed.
        assert not running(out) and any((out / "cache").iterdir())


def running(out):
    """Whether a program still works on a directory."""
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(out).encode() in process.read_bytes() and int(process.parent.name) != os.getpid():
                return True
        except OSError:
            pass
    return False


run_all(globals())
assert _place.PROGRAM.startswith(os.getcwd())
