"""The built-in P2 to 2 s, coarse mesh, steps of 1/16 s, in importers that share nothing with FMPy: others.py NAME FMU

NAME is fmpy, libcosimpy or ecospy (which needs Debian's libtbb12). Prints the force after each step [N].
libcosimpy and ecospy do not know enumerations: they set the integer twin `mesh.preset_number`.
"""

import os
import sys
import tempfile

STEPS = 32
SIZE = 1 / 16


def fmpy(fmu):
    from fmpy import simulate_fmu

    result = simulate_fmu(fmu, stop_time=STEPS * SIZE, output_interval=SIZE, start_values={"mesh.preset": 1}, output=["force"])
    return list(result["force"][1:])


def libcosimpy(fmu):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(int(SIZE * 1e9))
    punch = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="punch"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    names = {v.name.decode() if isinstance(v.name, bytes) else v.name: v.reference for v in execution.slave_variables(punch)}
    execution.integer_initial_value(punch, names["mesh.preset_number"], 1)
    force = []
    for _ in range(STEPS):
        assert execution.step()
        force += observer.last_real_values(punch, [names["force"]])
    return force


def ecospy(fmu):
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("punch", fmu)
        structure.add_parameter_set("coarse", {"punch::mesh.preset_number": 1})
        with EcosSimulation(structure=structure, step_size=SIZE) as simulation:
            simulation.init(parameter_set="coarse")
            force = []
            for _ in range(STEPS):
                simulation.step()
                force.append(simulation.get_real("punch::force"))
            simulation.terminate()
    return force


if __name__ == "__main__":
    name, fmu = sys.argv[1], os.path.abspath(sys.argv[2])
    # What the libraries log must not be read as forces.
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        forces = globals()[name](fmu)
        print("\n".join(f"force {float(force)!r}" for force in forces))
