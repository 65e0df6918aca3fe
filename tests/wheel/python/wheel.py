"""The installed wheel. Arguments: the folder data/. Prints what starting it costs."""

import concurrent.futures
import doctest
import importlib
import importlib.metadata
import pkgutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import threading
import time
from pathlib import Path

import numpy
import pandas
from checks import P2, refuses, run_all

import poropunch

COMMAND = Path(sysconfig.get_path("scripts")) / "poropunch"
COARSE = {"mesh.preset": "coarse"}


def command_line(*words):
    """The curve that `poropunch simulate` writes, columns by name (mN)."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "curve.csv"
        subprocess.run([COMMAND, "simulate", *words, "--out", file], check=True, capture_output=True)
        return pandas.read_csv(file, comment="#")


def test_doctests():
    for found in pkgutil.walk_packages(poropunch.__path__, "poropunch."):
        if not found.name.endswith(("__main__", "_native")):
            module = importlib.import_module(found.name)
            assert not doctest.testmod(module, optionflags=doctest.ELLIPSIS).failed, found.name
    assert not doctest.testmod(poropunch).failed


def test_version_and_costs():
    said = subprocess.run([COMMAND, "--version"], check=True, capture_output=True, text=True).stdout
    assert said.split()[1] == poropunch.__version__, said

    def cost(*line):
        times = []
        for _ in range(10):
            start = time.perf_counter()
            subprocess.run(line, check=True, capture_output=True)
            times.append(time.perf_counter() - start)
        return f"{1e3 * min(times):.0f} ms"

    print("poropunch --version:", cost(COMMAND, "--version"))
    print("python -c pass:", cost(sys.executable, "-c", "pass"))
    print("import poropunch:", cost(sys.executable, "-c", "import poropunch"))
    print("import numpy:", cost(sys.executable, "-c", "import numpy"))
    print("poropunch.simulate loaded:", cost(sys.executable, "-c", "import poropunch; poropunch.simulate"))


def test_the_command_line_gives_the_same_curve():
    time_s, displacement_mm = poropunch.protocol("P2", points=60)
    run = poropunch.simulate(time_s, displacement_mm, COARSE)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "motion.csv"
        pandas.DataFrame({"time_s": time_s, "displacement_mm": displacement_mm}).to_csv(file, index=False)
        # Tables of the command line have nine digits, its JSON has all.
        words = ["simulate", str(file), "--mesh", "coarse", "--out", str(Path(folder) / "curve"), "--json"]
        said = subprocess.run([COMMAND, *words], check=True, capture_output=True, text=True).stdout
        printed = __import__("json").loads(said)
    outputs = {series["name"]: 1e3 * numpy.array(series["values"]) for series in printed["outputs"]}
    for name, values in (("force", run.force_mn), ("force_solid", run.force_solid_mn), ("force_fluid", run.force_fluid_mn)):
        gap = numpy.abs(values - outputs[name]).max() / run.force_mn.max()
        assert gap <= 1e-12, (name, gap)
    assert numpy.array_equal(run.time_s, printed["time_s"])
    # Straight from sample to sample is the same motion here, but another path of the solver: within its tolerance.
    exact = poropunch.simulate(time_s, displacement_mm, COARSE, exact_motion=True)
    assert numpy.abs(exact.force_mn - run.force_mn).max() < 1e-2 * run.force_mn.max()
    # The named protocol of the command line is this motion.
    named = command_line("P2", "--points", "60", "--mesh", "coarse")
    assert numpy.abs(named["force_mN"] - run.force_mn).max() < 1e-6 * run.force_mn.max()


def test_gradient_against_central_differences():
    time_s, displacement_mm = poropunch.protocol("P2", points=20)
    names = ["material.equilibrium.mu", "material.branch[1].alpha", "material.branch[2].eta", "material.branch[1].mu"]
    # The derivatives are those of the steps that were made; runs with other parameters make others, closer together alike.
    close = {**COARSE, "solver.tolerance": 1e-5}
    run = poropunch.simulate(time_s, displacement_mm, close, sensitivities=names)
    assert run.jacobian_mn().shape == (len(time_s), 4)
    known = poropunch.parameters()
    for name, column in zip(names, run.jacobian_mn().T):
        step = 0.003 * abs(known[name].start)
        up, down = (
            poropunch.simulate(time_s, displacement_mm, {**close, name: known[name].start + d}).force_mn for d in (step, -step)
        )
        gap = numpy.abs((up - down) / (2 * step) - column).max() / numpy.abs(column).max()
        print(f"derivative by {name} against central differences: {gap:.1e} of its largest value")
        assert gap < 5e-3, (name, gap)


def test_parameters_by_number_and_text():
    time_s, displacement_mm = poropunch.protocol("P1", points=20)
    by_text = {"mesh.preset": "coarse", "material.permeability": "1e-8 mm^2", "geometry.sample_height": "12mm"}
    by_number = {"mesh.preset": 1, "material.permeability": 1e-8 * 1e-6, "geometry.sample_height": numpy.float64(12e-3)}
    one, other = (poropunch.simulate(time_s, displacement_mm, given).force_mn for given in (by_text, by_number))
    assert numpy.allclose(one, other, rtol=1e-12, atol=0)
    run = poropunch.simulate(time_s, displacement_mm, COARSE, record=["stored_energy"])
    assert run.outputs["stored_energy"].max() > 0


def test_errors():
    time_s, displacement_mm = poropunch.protocol("P1", points=20)

    def run(given=None, time_s=time_s, displacement_mm=displacement_mm, **others):
        return lambda: poropunch.simulate(time_s, displacement_mm, {**COARSE, **(given or {})}, **others)

    refuses(ValueError, "did you mean material.permeability", run({"material.permeabilty": 1e-15}))
    refuses(ValueError, "material.permeability", run({"material.permeability": "1e-9 mm"}))
    refuses(ValueError, "geometry.punch_radius", run({"geometry.punch_radius": "1"}))
    refuses(ValueError, "outside its bounds", run({"material.n0s": 2.0}))
    refuses(ValueError, "material.n0s", run({"material.n0s": float("nan")}))
    refuses(ValueError, "material.branch[4]", run({"material.branch[4].mu": 1e3, "material.branch[4].alpha": -2.0}))
    refuses(TypeError, "material.n0s", run({"material.n0s": [1]}))
    refuses(ValueError, "force_of_nature", run(record=["force_of_nature"]))
    refuses(ValueError, "geometry.punch_radius", run(sensitivities=["geometry.punch_radius"]))
    refuses(ValueError, "displacement_mm", run(displacement_mm=displacement_mm[1:]))
    refuses(ValueError, "sort the samples", run(time_s=time_s[::-1]))
    refuses(ValueError, "finite", run(displacement_mm=numpy.full_like(time_s, numpy.nan)))
    refuses(ValueError, "one dimension", run(time_s=time_s[:, None]))
    refuses(RuntimeError, "displacement", run(displacement_mm=20 + displacement_mm))


def test_threads_run_at_a_time_and_ctrl_c_stops_a_run():
    time_s, displacement_mm = poropunch.protocol("P2", points=20)
    alone = poropunch.simulate(time_s, displacement_mm, COARSE).force_mn
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        runs = [pool.submit(poropunch.simulate, time_s, displacement_mm, COARSE) for _ in range(8)]
        # This thread goes on meanwhile: the interpreter is not held.
        ticks = 0
        while not all(run.done() for run in runs):
            time.sleep(1e-3)
            ticks += 1
    assert ticks > 20, ticks
    assert all(numpy.array_equal(run.result().force_mn, alone) for run in runs)
    threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
    start = time.perf_counter()
    try:
        long = poropunch.protocol("P2", cycles=50, points=20000)
        poropunch.simulate(*long, mesh="fine")
    except KeyboardInterrupt:
        assert time.perf_counter() - start < 10
    else:
        raise AssertionError("not stopped")


def test_identify_with_numbers_in_si():
    rig = {"geometry.punch_radius": 2e-3, "geometry.sample_radius": "10 mm", "geometry.sample_height": 10e-3}
    found = poropunch.identify(P2, mesh="coarse", set=rig, bounds={"material.branch[2].eta": (100.0, 1e5)})
    assert found.converged and 210 < found.derived.value["G_inf"] < 280, found.derived
    assert "eta_2" in found.parameters.index, found.parameters


def test_the_fmu():
    import zipfile

    with zipfile.ZipFile(poropunch.fmu_path()) as fmu:
        assert "modelDescription.xml" in fmu.namelist()
    # Built for this machine alone it is nothing to give away.
    if "manylinux2014" in importlib.metadata.distribution("poropunch").read_text("WHEEL"):
        subprocess.run([COMMAND, "package", "--check", poropunch.fmu_path()], check=True, capture_output=True)


run_all(globals())
