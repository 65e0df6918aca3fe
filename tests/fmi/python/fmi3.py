"""FMPy against the FMI 3.0 FMU: called by the Rust tests, and by hand (see ../README.md).

fmi3.py validate FMU                problems of both XML files, against the schemas that FMPy ships
fmi3.py equal FMU2 FMU3             P2 to 2 s, built-in and by inputs, with both versions: largest difference
fmi3.py arrays FMU2 FMU3            parameters and sensitivities by arrays and by scalars: largest difference
fmi3.py history FMU3                P2 as a displacement history against the built-in protocol
fmi3.py events FMU3                 times of the events of a short test with two cycles, and the peak force
fmi3.py intermediate FMU3           displacement alone, asked for at the end of each step: error of the force; reads within
fmi3.py states FMU3                 state functions: going back, as bytes, corrupt bytes
"""

import os
import shutil
import sys

import fmpy
import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

GAP, DEPTH, RATE, STOP = 0.1e-3, 1.0e-3, 1.6e-3, 2.0
RAMP = (GAP + DEPTH) / RATE
OUTPUT = ["punch_displacement", "force", "force_solid", "force_fluid", "stored_energy"]


def validate(fmu):
    problems = validate_fmu(fmu)
    folder = extract(fmu)
    schema = os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi3", "fmi3TerminalsAndIcons.xsd")
    schema = etree.XMLSchema(etree.parse(schema))
    document = etree.parse(os.path.join(folder, "terminalsAndIcons", "terminalsAndIcons.xml"))
    if not schema.validate(document):
        problems.append(str(schema.error_log))
    names = {v.name for v in read_model_description(folder).modelVariables}
    members = {node.get("variableName") for node in document.iter("TerminalMemberVariable")}
    problems += [f"a terminal's member {name} is no variable" for name in members - names]
    shutil.rmtree(folder)
    print("\n".join(problems))


def run(fmu, start=None, step=0.0625, stop=STOP, output=None, **options):
    start = {"mesh.preset": 1, **(start or {})}
    return simulate_fmu(
        fmu, stop_time=stop, output_interval=step, start_values=start, output=output or OUTPUT, **options
    )


def difference(a, b, names=OUTPUT):
    assert len(a) == len(b) and len(a) > 10
    return max(np.abs(a[name] - b[name]).max() / np.abs(a[name]).max() for name in names)


def inputs():
    points = [(0.0, -GAP, RATE), (RAMP, DEPTH, RATE), (RAMP, DEPTH, 0.0), (STOP, DEPTH, 0.0)]
    return np.array(points, dtype=[("time", float), ("displacement", float), ("displacement_rate", float)])


def equal(fmu2, fmu3):
    built_in = difference(run(fmu2), run(fmu3))
    given = {"start": {"protocol.source": 1}, "input": inputs(), "step": 0.05}
    print(max(built_in, difference(run(fmu2, **given), run(fmu3, **given))))


def arrays(fmu2, fmu3):
    scalars = ["sensitivity.force.material.branch[2].eta", "sensitivity.force_fluid.material.branch[4].eta"]
    start = {"solver.sensitivities": True, "material.branch[2].mu": -200.0}
    a = run(fmu2, start, output=["force", *scalars])
    start = {"solver.sensitivities": True, "material.branch.mu": [-418.0, -200.0, 0.0, 0.0]}
    arrays = ["sensitivity.force.material.branch.eta", "sensitivity.force_fluid.material.branch.eta"]
    b = run(fmu3, start, output=["force", "sensitivity.matrix", *arrays])
    matrix = b["sensitivity.matrix"]
    assert matrix.shape[1:] == (3, 18)
    assert np.abs(a[scalars[0]]).max() > 0.0
    pairs = [
        (a["force"], b["force"]),
        (a[scalars[0]], b[arrays[0]][:, 1]),
        (a[scalars[1]], b[arrays[1]][:, 3]),
        (a[scalars[0]], matrix[:, 0, 11]),
        (a[scalars[1]], matrix[:, 2, 17]),
    ]
    print(max(np.abs(x - y).max() for x, y in pairs))


def history(fmu3):
    description = read_model_description(fmu3)
    # FMPy takes the sizes of arrays from the start values of the description.
    for variable in description.modelVariables:
        if variable.name.startswith("protocol.history."):
            variable.shape = (3,)
    start = {
        "protocol.points": 3,
        "protocol.history.time": [0.0, RAMP, 90.0],
        "protocol.history.displacement": [-GAP, DEPTH, DEPTH],
    }
    print(difference(run(fmu3), run(fmu3, start, model_description=description)))


def events(fmu3):
    start = {
        "protocol.hold": 0.3,
        "protocol.rest_after_retraction": 0.2,
        "protocol.rest_after_return": 0.1,
        "protocol.cycles": 2,
    }
    options = {"use_event_mode": True, "early_return_allowed": True, "output": ["force"]}
    result = run(fmu3, start, step=0.5, stop=12.0, **options)
    # FMPy records an event before and after.
    times, counts = np.unique(result["time"], return_counts=True)
    print(" ".join(repr(float(time)) for time in times[counts == 2]))
    print(repr(float(result["force"].max())))


def slave(fmu, **options):
    folder = extract(fmu)
    description = read_model_description(folder)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    instance = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="test",
    )
    # Errors are checked, not printed.
    instance.instantiate(logMessage=lambda *_: None, **options)
    instance.setInt64([reference["mesh.preset"], reference["protocol.source"]], [1, 1])
    instance.setFloat64([reference["displacement"]], [-GAP])
    return instance, reference, folder


def start(instance):
    instance.enterInitializationMode(startTime=0.0)
    instance.exitInitializationMode()


def intermediate(fmu3):
    exact = run(fmu3, step=0.05, output=["force"])["force"]
    asked, read = [], []

    def update(_, time, set_requested, get_allowed, __, ___, ____, _____):
        if set_requested:
            asked.append(time)
            instance.setFloat64([reference["displacement"]], [min(-GAP + RATE * time, DEPTH)])
        elif get_allowed:
            read.append((time, instance.getFloat64([reference["force"]])[0]))

    reference = {v.name: v.valueReference for v in read_model_description(fmu3).modelVariables}
    wanted = [reference["displacement"], reference["force"]]
    instance, reference, folder = slave(
        fmu3, intermediateUpdate=update, requiredIntermediateVariables=wanted
    )
    start(instance)
    forces = [0.0]
    for n in range(round(STOP / 0.05)):
        now, then = n * 0.05, (n + 1) * 0.05
        # The corner lies on no communication point: a master that knows it steps there.
        for a, b in [(now, RAMP), (RAMP, then)] if now < RAMP < then else [(now, then)]:
            instance.doStep(a, b - a)
        forces.append(instance.getFloat64([reference["force"]])[0])
    instance.terminate()
    instance.freeInstance()
    shutil.rmtree(folder)
    times = [time for time, _ in read]
    assert times == sorted(times) and len(read) > len(forces), "no reads within steps"
    assert len(asked) == len(forces), (len(asked), len(forces))
    print(np.abs(np.array(forces) - exact).max() / exact.max())


def states(fmu3):
    instance, reference, folder = slave(fmu3)
    start(instance)

    def load(instance, first, n):
        forces = []
        for k in range(first, first + n):
            instance.setFloat64([reference["displacement"]], [1e-3 * 0.05 * (k + 1) - GAP])
            instance.doStep(k * 0.05, 0.05)
            forces.append(instance.getFloat64([reference["force"]])[0])
        return forces

    load(instance, 0, 5)
    state = instance.getFMUState()
    data = instance.serializeFMUState(state)
    expected = load(instance, 5, 20)
    instance.setFMUState(state)
    assert load(instance, 5, 20) == expected, "going back"
    other, _, other_folder = slave(fmu3)
    read = other.deserializeFMUState(data)
    other.setFMUState(read)
    assert load(other, 5, 20) == expected, "from bytes"
    for place in range(0, len(data), 997):
        corrupt = bytearray(data)
        corrupt[place] ^= 1
        try:
            other.deserializeFMUState(bytes(corrupt))
            raise SystemExit(f"byte {place} does not matter")
        except Exception as error:
            assert "fmi3DeserializeFMUState" in str(error), error
    other.freeFMUState(read)
    instance.freeFMUState(state)
    for one, place in ((instance, folder), (other, other_folder)):
        one.freeInstance()
        shutil.rmtree(place)


COMMANDS = [validate, equal, arrays, history, events, intermediate, states]

if __name__ == "__main__":
    commands = {command.__name__: command for command in COMMANDS}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
