"""A robot of three flexible links under a control law in Python, called each step: steps a second, memory and answers of `tisserand` and Exudyn.

    pip install exudyn numpy scipy h5py ./python
    cargo build --release -p dcb-programs -p dcb-samples
    python3 tests/benches/python_loop.py [--rounds 3] [--write]

Links are the generated connecting rod with 16 coordinates; Exudyn gets the same matrices and basis (see `exudyn_chain.py`), the same method, step
and damping. Each joint has a motor, and at each control step the law reads three angles and three rates and sets three torques, which are held. Both loops run
on one thread; timed is the loop alone. The answers are compared with a run of ours with a sixteenth of the step at the same control step; the same run of Exudyn tells how far that
one is to be trusted. `--write` puts the raw lines in place of docs/data/python_loop.jsonl.
"""
import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time

import chain_scene

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DATA = os.path.join(ROOT, "docs", "data", "python_loop.jsonl")
CASE = dict(name="robot", bodies=3, coordinates=16, interface="8 nodes", stiffness_factor=1e-2, rho_infinity=0.8)
CONTROL_STEP, CONTROL_STEPS = 2e-4, 2500
# Rates of a joint have the deflection of its bearings in them: larger gains on rates that are held for a step are unstable with any step.
PROPORTIONAL, DERIVATIVE = (20.0, 8.0, 2.0), (0.1, 0.04, 0.01)
FINER = 16  # steps of the references in one


def goal(joint, moment):
    """Angle wanted: half a radian further with each joint, on a smooth way of 0.3 s."""
    x = min(moment / 0.3, 1.0)
    return 0.5 * (joint + 1) * x * x * (3 - 2 * x)


def torque(joint, moment, angle, rate):
    return PROPORTIONAL[joint] * (goal(joint, moment) - angle) - DERIVATIVE[joint] * rate


def memory():
    """Most memory so far, and that of now, MB."""
    lines = dict(line.split(":", 1) for line in open("/proc/self/status") if ":" in line)
    return [int(lines[key].split()[0]) / 1024 for key in ("VmHWM", "VmRSS")]


def loop_of_tisserand(job):
    import numpy as np
    import tisserand

    scene = chain_scene.scene(CASE, job["superelement"], job["centres"], job["step"], CONTROL_STEPS * job["finer"])
    joints = range(CASE["bodies"])
    scene["actuators"] = {f"motor{joint}": {"torque": {"joint": f"hinge{joint + 1}", "input": {"initial": 0}}} for joint in joints}
    for joint in joints:
        scene["outputs"][f"angle{joint}"] = {"joint_coordinate": {"joint": f"hinge{joint + 1}"}}
        scene["outputs"][f"rate{joint}"] = {"joint_rate": {"joint": f"hinge{joint + 1}"}}
    motion = tisserand.Mechanism(tisserand.Scene.from_dict(scene))
    tip = []
    before = memory()
    started = time.perf_counter()
    for index in range(CONTROL_STEPS):
        moment = index * CONTROL_STEP
        for joint in joints:
            motion.set_input(f"motor{joint}", torque(joint, moment, motion.output(f"angle{joint}")[0], motion.output(f"rate{joint}")[0]))
        motion.step(job["step"], job["finer"])
        tip.append(motion.output("tip"))
    seconds = time.perf_counter() - started
    return dict(seconds=seconds, memory=[before, memory()], tip=np.array(tip).tolist(), version=tisserand.__version__)


def loop_of_exudyn(job):
    import exudyn_chain as chain
    import exudyn as exu
    from exudyn.utilities import TorsionalSpringDamper

    described = dict(part=job["part"], superelement=job["superelement"], gravity=chain_scene.GRAVITY, step=job["step"],
                     steps=CONTROL_STEPS * job["finer"], rho_infinity=CASE["rho_infinity"], newton=job["newton"], record_every=job["finer"])
    body, damping, ends, _ = chain.reduced_body(described)
    container, system, tip, markers = chain.assemble(described, body, damping, ends, CASE["bodies"])
    motors = [
        system.AddObject(TorsionalSpringDamper(markerNumbers=[markers[2 * joint], markers[2 * joint + 1]], stiffness=0, damping=0, torque=0))
        for joint in range(CASE["bodies"])
    ]
    system.Assemble()
    calls = [0]

    def control(mbs, _):
        index, calls[0] = calls[0], calls[0] + 1
        if index % job["finer"] == 0:
            moment = index // job["finer"] * CONTROL_STEP
            for joint, motor in enumerate(motors):
                angle = mbs.GetObjectOutput(motor, exu.OutputVariableType.Rotation)
                rate = mbs.GetObjectOutput(motor, exu.OutputVariableType.AngularVelocityLocal)
                # A positive one turns the angle back.
                mbs.SetObjectParameter(motor, "torque", -torque(joint, moment, angle, rate))
        return True

    system.SetPreStepUserFunction(control)
    chosen = chain.settings(described)
    solver = exu.MainSolverImplicitSecondOrder()
    before = memory()
    started = time.perf_counter()
    if not solver.SolveSystem(system, chosen):
        sys.exit("Exudyn failed")
    seconds = time.perf_counter() - started
    assert calls[0] == described["steps"], calls
    history = system.GetSensorStoredData(tip)[1:]
    return dict(seconds=seconds, memory=[before, memory()], tip=history[:, 1:4].tolist(), version=exu.config.Version())


LOOPS = dict(tisserand=loop_of_tisserand, exudyn=loop_of_exudyn)
# Exudyn with its modified Newton, and with a smaller contractivity, which makes new Jacobians earlier (`exudyn_chain.NEWTON`).
TOOLS = dict(tisserand=("tisserand", None), exudyn=("exudyn", "modified"), exudyn_eager=("exudyn", "eager"))


def run(tool, part, superelement, centres, finer):
    """One loop in a process of its own, on one thread."""
    tool, newton = TOOLS[tool]
    job = dict(newton=newton, part=part, superelement=superelement, centres=centres, step=CONTROL_STEP / finer, finer=finer)
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", RAYON_NUM_THREADS="1")
    with tempfile.NamedTemporaryFile(suffix=".json") as result:
        subprocess.run([sys.executable, __file__, "--loop", tool, json.dumps(job), result.name], env=environment, check=True, stdout=subprocess.DEVNULL)
        return json.load(open(result.name))


def farthest(one, other):
    return max(abs(a - b) for here, there in zip(one, other, strict=True) for a, b in zip(here, there))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--binaries", default=os.path.join(ROOT, "target", "release"))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--loop", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.loop:
        tool, job, result = options.loop
        json.dump(LOOPS[tool](json.loads(job)), open(result, "w"))
        return
    with tempfile.TemporaryDirectory() as folder:
        prepared = chain_scene.write_component(options.binaries, folder, CASE)
        references = {tool: run(tool, *prepared, FINER) for tool in LOOPS}
        lines = []
        for round_number in range(options.rounds):
            for tool in TOOLS:
                load = os.getloadavg()[0]
                found = run(tool, *prepared, 1)
                lines.append(dict(
                    tool=tool, version=found["version"], round=round_number, load=round(load, 2), control_step=CONTROL_STEP, steps=CONTROL_STEPS,
                    steps_per_second=CONTROL_STEPS / found["seconds"], memory_before_and_after=found["memory"],
                    error=farthest(found["tip"], references["tisserand"]["tip"]),
                    references_apart=farthest(references["exudyn"]["tip"], references["tisserand"]["tip"]), **conditions()))
                print(json.dumps(lines[-1]), file=sys.stderr)
    for tool in TOOLS:
        best = max((line for line in lines if line["tool"] == tool), key=lambda line: line["steps_per_second"])
        print(f"{tool:10} {best['steps_per_second']:9.0f} steps/s, {best['error']:.1e} m off, {best['memory_before_and_after'][1][0]:.0f} MB at most")
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


def conditions(script="python_loop.py"):
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), platform.machine())
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    return dict(command=f"python3 tests/benches/{script} " + " ".join(sys.argv[1:]), commit=commit,
                machine=dict(cpu=model, cores=os.cpu_count(), python=platform.python_version()))


if __name__ == "__main__":
    main()
