"""The client of UM-Bridge against a server. Arguments: the server's URL, the command line."""

import json
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy
import umbridge

url, runner = sys.argv[1:]
assert umbridge.supported_models(url) == ["force_mN"]
model = umbridge.HTTPModel(url, "force_mN")
assert model.supports_evaluate() and model.supports_gradient() and model.supports_apply_jacobian()
assert model.get_input_sizes() == [2]
(size,) = model.get_output_sizes()

theta = [-250.0, 5000.0]
(force,) = model([theta])
with tempfile.TemporaryDirectory() as folder:
    words = ["simulate", "P2", "--points", "40", "--mesh", "coarse", "--out", f"{folder}/curve", "--json"]
    words += ["--set", "material.equilibrium.mu=-250Pa", "--set", "material.branch[2].eta=5000Pa.s"]
    printed = subprocess.run([runner, *words], check=True, capture_output=True).stdout
expected = 1e3 * numpy.array(json.loads(printed)["outputs"][0]["values"])
assert len(force) == size == len(expected)
assert numpy.abs(force - expected).max() <= 1e-12 * expected.max()

# sens^T (J vec) is (sens^T J) vec, and J vec is the difference along vec.
vec, sens = [2.0, -30.0], list(numpy.linspace(-1, 1, size))
along = numpy.array(model.apply_jacobian(0, 0, [theta], vec))
gradient = numpy.array(model.gradient(0, 0, [theta], sens))
assert abs(along @ sens - gradient @ vec) <= 1e-9 * abs(gradient @ vec)
close = {"solver.tolerance": 1e-5}
along = numpy.array(model.apply_jacobian(0, 0, [theta], vec, close))
up, down = (numpy.array(model([[theta[0] + s * vec[0], theta[1] + s * vec[1]]], close)[0]) for s in (1, -1))
assert numpy.abs((up - down) / 2 - along).max() < 5e-3 * numpy.abs(along).max()

# The client's settings count; clients at a time get what one gets.
assert max(model([theta], {"geometry.punch_radius": "1 mm"})[0]) < 0.7 * max(force)
with ThreadPoolExecutor(4) as pool:
    assert all(found == [force] for found in pool.map(model, [[theta]] * 4))
for wrong, part in (([1.0], "material.branch[2].eta"), ([-250.0, -1.0], "bounds")):
    try:
        model([wrong])
    except Exception as error:
        assert part in str(error), error
    else:
        raise AssertionError(part)
