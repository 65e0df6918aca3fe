"""FMPy against the FMU: called by the Rust tests, and by hand (see ../README.md).

importer.py validate FMU              exit code 1 and the problems, if any
importer.py simulate FMU WAY STEP OUT P2 to 2 s, input given in one of five ways, result as CSV
importer.py resume FMU STATE OUT      two more steps from a state serialised by another process
importer.py fields FMU PVD            P2 to 2 s with fields, and again without: the same forces
importer.py strange FMU               a path with space, umlaut, # and %; nothing of the process changes
importer.py many FMU N                N calls of simulate_fmu; growth of the process in MB
importer.py loads FMU N               N loads and frees of the library; growth of the process in MB
"""

import ctypes
import gc
import locale
import os
import shutil
import signal
import sys
import tempfile
from xml.etree import ElementTree

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

# P2 (design, section 1): from 0.1 mm above the surface to 1 mm at 1.6 mm/s, then hold.
GAP, DEPTH, RATE, STOP = 0.1e-3, 1.0e-3, 1.6e-3, 2.0
RAMP = (GAP + DEPTH) / RATE
COARSE = {"mesh.preset": 1}
OUTPUT = ["punch_displacement", "force", "force_solid", "force_fluid", "stored_energy"]


def validate(fmu):
    read_model_description(fmu, validate=True, validate_variable_names=True, validate_model_structure=True)
    problems = validate_fmu(fmu)
    print("\n".join(problems))
    return 1 if problems else 0


def signals(with_rate):
    """Breakpoints of P2; the rate is discrete, so its jump stands twice."""
    points = [(0.0, -GAP, RATE), (RAMP, DEPTH, RATE), (RAMP, DEPTH, 0.0), (STOP, DEPTH, 0.0)]
    if with_rate:
        dtype = [("time", float), ("displacement", float), ("displacement_rate", float)]
        return np.array(points, dtype=dtype)
    return np.array([p[:2] for p in (points[0], points[1], points[3])], dtype=[("time", float), ("displacement", float)])


def slave(fmu, name="test"):
    folder = extract(fmu)
    description = read_model_description(folder)
    instance = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=name,
    )
    instance.instantiate()
    references = {v.name: v.valueReference for v in description.modelVariables}
    return instance, references, folder


def derivative(fmu, step):
    """Input derivatives by hand: FMPy's own `set_input_derivatives` passes wrong numbers."""
    instance, reference, folder = slave(fmu)
    instance.setInteger([reference["mesh.preset"], reference["protocol.source"]], [1, 1])
    instance.setReal([reference["displacement"]], [-GAP])
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    times = sorted({n * step for n in range(round(STOP / step) + 1)} | {RAMP})
    rows = []
    for now, then in zip(times, times[1:] + [None]):
        rows.append([now] + instance.getReal([reference[name] for name in OUTPUT]))
        if then is None:
            break
        rising = now < RAMP
        instance.setReal([reference["displacement"]], [-GAP + RATE * now if rising else DEPTH])
        instance.setRealInputDerivatives([reference["displacement"]], [1], [RATE if rising else 0.0])
        instance.doStep(now, then - now)
    instance.terminate()
    instance.freeInstance()
    shutil.rmtree(folder)
    return rows


def grid(fmu, step):
    """Masters that make equal steps and none at a jump of a discrete input: PyFMI, OMSimulator, fmuCheck, libcosim, ecos."""
    instance, reference, folder = slave(fmu)
    instance.setInteger([reference["mesh.preset"], reference["protocol.source"]], [1, 1])
    instance.setReal([reference["displacement"], reference["displacement_rate"]], [-GAP, RATE])
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    rows = []
    for n in range(round(STOP / step) + 1):
        now = n * step
        rows.append([now] + instance.getReal([reference[name] for name in OUTPUT]))
        rising = now < RAMP - 1e-9
        values = [-GAP + RATE * now if rising else DEPTH, RATE if rising else 0.0]
        instance.setReal([reference["displacement"], reference["displacement_rate"]], values)
        if n < round(STOP / step):
            instance.doStep(now, step)
    instance.terminate()
    instance.freeInstance()
    shutil.rmtree(folder)
    return rows


def simulate(fmu, way, step):
    if way == "grid":
        return grid(fmu, step)
    if way == "derivative":
        return derivative(fmu, step)
    start = dict(COARSE)
    given = None
    # The built-in protocol needs no setting: it is what runs by default.
    if way != "trapezoid":
        start["protocol.source"] = 1
        given = signals(with_rate=way == "rate")
    result = simulate_fmu(
        fmu, stop_time=STOP, output_interval=step, start_values=start, input=given, output=OUTPUT
    )
    # FMPy sorts its columns as the description does.
    return [[row["time"]] + [row[name] for name in OUTPUT] for row in result]


def write(path, rows):
    with open(path, "w") as file:
        for row in rows:
            file.write(",".join(repr(float(x)) for x in row) + "\n")


def resume(fmu, state):
    instance, reference, folder = slave(fmu)
    with open(state, "rb") as file:
        handle = instance.deSerializeFMUstate(file.read())
    instance.setFMUstate(handle)
    instance.freeFMUstate(handle)
    rows = []
    for now in (0.4, 0.5):
        instance.setReal([reference["displacement"]], [now * 1e-3])
        instance.doStep(now, 0.1)
        rows.append([now] + instance.getReal([reference["force"]]))
    instance.freeInstance()
    shutil.rmtree(folder)
    return rows


def fields(fmu, pvd):
    def force(start):
        start = {**COARSE, "protocol.source": 2, **start}
        return simulate_fmu(fmu, stop_time=STOP, output_interval=0.0125, start_values=start, output=["force"])

    assert (force({"fields.path": pvd})["force"] == force({})["force"]).all()
    print("\n".join(node.get("timestep") for node in ElementTree.parse(pvd).getroot().iter("DataSet")))


def strange(fmu):
    libm = ctypes.CDLL("libm.so.6")

    def process():
        handlers = [signal.getsignal(s) for s in range(1, 32)]
        # Not SigQ, which counts the signals that wait for any process of this user.
        blocked = [line for line in open("/proc/self/status") if line.startswith("Sig") and "SigQ" not in line]
        return os.getcwd(), locale.setlocale(locale.LC_ALL), libm.fegetround(), libm.fegetexcept(), handlers, blocked

    before = process()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a bü#c%20d.fmu")
        shutil.copy(fmu, path)
        unpacked = os.path.join(folder, "a bü#c%20d")
        extract(path, unzipdir=unpacked)
        for place in (path, unpacked):
            result = simulate_fmu(
                place, stop_time=0.2, output_interval=0.1, start_values={**COARSE, "protocol.source": 2}, output=["force"]
            )
            assert result["force"][-1] > 1e-5
    assert process() == before, "the FMU changed something of the process"


def resident_mb():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def growth(turn, n):
    """Growth in MB over the last n turns, after some to warm up."""
    for _ in range(max(20, n // 10)):
        turn()
    gc.collect()
    before = resident_mb()
    for _ in range(n):
        turn()
    gc.collect()
    return resident_mb() - before


def many(fmu, n):
    folder = extract(fmu)
    start = {**COARSE, "protocol.source": 2}
    return growth(
        lambda: simulate_fmu(folder, stop_time=0.1, output_interval=0.1, start_values=start, output=["force"]), n
    )


def loads(fmu, n):
    """As a host does that loads the library anew for each run: a model is built and a step made in each turn."""
    folder = extract(fmu)
    description = read_model_description(folder)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    identifier = description.coSimulation.modelIdentifier

    def turn():
        instance = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="load"
        )
        instance.instantiate()
        instance.setInteger([reference["mesh.preset"], reference["protocol.source"]], [1, 2])
        instance.setupExperiment(startTime=0.0)
        instance.enterInitializationMode()
        instance.exitInitializationMode()
        instance.doStep(0.0, 0.1)
        instance.freeInstance()

    result = growth(turn, n)
    with open("/proc/self/maps") as file:
        assert identifier + ".so" not in file.read(), "the library is still mapped after it was freed"
    return result


def main(command, fmu, *rest):
    if command == "validate":
        return validate(fmu)
    if command == "simulate":
        write(rest[2], simulate(fmu, rest[0], float(rest[1])))
    elif command == "resume":
        write(rest[1], resume(fmu, rest[0]))
    elif command == "fields":
        fields(fmu, rest[0])
    elif command == "strange":
        strange(fmu)
    elif command == "many":
        print(many(fmu, int(rest[0])))
    elif command == "loads":
        print(loads(fmu, int(rest[0])))
    else:
        return __doc__
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
