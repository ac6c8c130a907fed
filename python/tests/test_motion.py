"""Scenes, runs and mechanisms."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import scipy.io
import tisserand

REPOSITORY = pathlib.Path(os.environ.get("TISSERAND_REPOSITORY", pathlib.Path(__file__).resolve().parents[2]))
SAMPLES = REPOSITORY / "samples"
CRANK = SAMPLES / "slider-crank/scene.json"


def pendulum(**keys):
    scene = tisserand.Scene(2, gravity=[0, -9.81], **keys)
    scene.rigid("bob", mass=1, inertia=1e-6, points={"pivot": [-0.5, 0]}, position=[0.5, 0])
    scene.revolute("pivot", "ground", "bob/pivot")
    scene.load("motor", "torque", at="bob/pivot", components=[{"input": {"initial": 0}}])
    scene.output("angle", joint_coordinate={"joint": "pivot"}).output("rate", joint_rate={"joint": "pivot"})
    return scene.integrate(step=1e-3, end=0.5)


def test_a_run_is_bit_for_bit_that_of_the_program(tmp_path):
    command = [sys.executable, "-c", "from tisserand._programs import simulate; raise SystemExit(simulate())"]
    subprocess.run([*command, str(CRANK), "-o", str(tmp_path / "program.h5"), "-q"], check=True)
    of_program, ours = tisserand.Results(tmp_path / "program.h5"), tisserand.simulate(CRANK)
    assert ours.is_complete and np.array_equal(ours.time, of_program.time)
    for channel in of_program.channels:
        # How long it took is nobody's business.
        if "seconds" not in channel.path:
            assert np.array_equal(ours[channel.path], of_program[channel.path]), channel.path


def test_results_are_arrays_tables_and_pictures(tmp_path):
    results = tisserand.simulate(CRANK, tmp_path / "crank.h5")
    assert "midpoint_deflection" in results and "nothing" not in results
    history = results["slider_position"]
    assert history.shape == (len(results.time), 2)
    dataset = results.to_xarray()
    assert np.array_equal(dataset["slider_position"].values, history) and dataset["time"].attrs["units"] == "s"
    frame = results.to_pandas()
    assert np.array_equal(frame["midpoint_deflection"], results["midpoint_deflection"])
    picture = tmp_path / "crank.png"
    results.plot("crank_angle").figure.savefig(picture)
    assert picture.stat().st_size > 5000
    with pytest.raises(tisserand.Error, match="slider_position"):
        results["slider_positio"]


def test_a_scene_is_the_same_as_dictionary_file_and_builder(tmp_path):
    scene = pendulum()
    scene.write(tmp_path / "pendulum.json")
    runs = [tisserand.simulate(form) for form in (scene, scene.to_dict(), tmp_path / "pendulum.json")]
    for run in runs[1:]:
        assert np.array_equal(run["angle"], runs[0]["angle"])
    # It swings as m l² φ'' = -m g l cos φ from the horizontal: by energy, φ' = √(2 g sin|φ| / l).
    angle, rate = runs[0]["angle"], runs[0]["rate"]
    assert np.allclose(abs(rate[50:]), np.sqrt(2 * 9.81 * np.sin(-angle[50:]) / 0.5), rtol=2e-5)


def test_a_program_steers_saves_and_goes_back():
    motion = tisserand.Mechanism(pendulum())
    saved, futures = motion.save(), []
    for gain in (40.0, 4.0, 40.0):
        motion.restore(saved)
        for _ in range(200):
            motion.set_input("motor", -gain * motion.output("angle")[0] - 0.1 * gain * motion.output("rate")[0])
            motion.step(1e-3)
        futures.append(motion.output("angle")[0])
    assert futures[0] == futures[2] != futures[1]
    assert motion.time == pytest.approx(0.2)
    assert np.array_equal(motion.outputs("angle", "rate"), [motion.output("angle")[0], motion.output("rate")[0]])


def test_a_function_in_the_loop_is_called_at_its_own_rate():
    motion, calls = tisserand.Mechanism(pendulum()), []

    def control(time, motion):
        calls.append(time)
        return {"motor": -40 * motion.output("angle")[0] - 5 * motion.output("rate")[0]}

    history = motion.run(0.2, 1e-3, control=control, every=4, record=["angle", "rate"])
    assert len(history) == 201 and len(calls) == 50 and np.allclose(np.diff(calls), 4e-3)
    assert history["angle"].shape == (201,) and history["angle"][-1] == motion.output("angle")[0]
    with pytest.raises(tisserand.InputError, match="wasn't recorded"):
        history["energy"]

    # What is held comes late: twice the time between calls, twice the difference from a loop that is closed at every step of a finer run.
    ends = []
    for every in (1, 2, 4, 8):
        again = tisserand.Mechanism(pendulum())
        ends.append(again.run(0.1, 2.5e-4, control=control, every=every, record=["angle"])["angle"][-1])
    first, second, third = np.diff(ends)
    assert 1.8 < second / first < 2.2 and 1.8 < third / second < 2.2


def test_a_function_that_raises_ends_the_loop_and_leaves_its_history():
    motion = tisserand.Mechanism(pendulum())

    def control(time, motion):
        if time > 0.05:
            raise ZeroDivisionError
        return None

    with pytest.raises(ZeroDivisionError):
        motion.run(1.0, 1e-3, control=control, record=["angle"])
    assert 50 <= len(motion.history) <= 53 and len(motion.history["angle"]) == len(motion.history)


def test_threads_run_side_by_side_and_agree():
    ends = [0.0] * 4

    def run(place):
        motion = tisserand.Mechanism(pendulum())
        motion.step(1e-3, 500)
        ends[place] = motion.output("angle")[0]

    threads = [threading.Thread(target=run, args=(place,)) for place in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(ends)) == 1 and ends[0] < -1


def test_one_mechanism_in_several_threads_makes_whole_steps():
    motion = tisserand.Mechanism(pendulum())
    threads = [threading.Thread(target=lambda: [motion.step(1e-3) for _ in range(50)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = tisserand.Mechanism(pendulum())
    alone.step(1e-3, 200)
    assert motion.output("angle")[0] == alone.output("angle")[0]


def test_a_run_ends_with_what_a_function_raises_and_keeps_what_was_reached(tmp_path):
    class Enough(Exception):
        pass

    # Told by the clock: where making ready takes longer than that, the first step is told already.
    def stop(time, end):
        if time > 100e-5:
            raise Enough

    path = tmp_path / "stopped.h5"
    with pytest.raises(Enough):
        tisserand.simulate(pendulum().integrate(step=1e-5, end=100.0), path, progress=stop)
    reached = tisserand.Results(path)
    assert not reached.is_complete and reached.stopped and len(reached.time) > 10


@pytest.mark.parametrize("what", ["run", "steps"])
def test_ctrl_c_ends_a_motion_from_any_thread(what, keyboard, tmp_path):
    path = tmp_path / "stopped.h5"
    motion = tisserand.Mechanism(pendulum())

    def press():
        # From the first step on: making ready takes a second on a busy machine.
        while what == "run" and not any(tmp_path.iterdir()):
            time.sleep(1e-3)
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press).start()
    with pytest.raises(KeyboardInterrupt):
        if what == "run":
            tisserand.simulate(pendulum().integrate(step=1e-6, end=1000.0), path)
        else:
            motion.step(1e-6, 10**9)
    if what == "run":
        reached = tisserand.Results(path)
        assert not reached.is_complete and len(reached.time) > 10
    else:
        # It stands after a whole step and goes on.
        reached = motion.time
        motion.step(1e-3)
        assert reached > 0 and abs(motion.time - reached - 1e-3) < 1e-12


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda scene: scene.revolute("pivot", "ground", "bob/pivot"), "is there already"),
        (lambda scene: scene.revolute("second", "ground", "bob/pin"), "pin"),
        (lambda scene: scene.output("there", positio={"at": "bob"}), "positio"),
        (lambda scene: scene.integrate(step=-1, end=1), "step"),
        (lambda scene: scene.set(gravity=[0, float("nan")]), "a number that isn.t finite"),
        (lambda scene: scene.set(gravity=[0, 1, 2]), "gravity"),
        (lambda scene: scene.body("rod", "nowhere.dcb.h5"), "nowhere"),
        (lambda scene: scene.load("push", "force", at="bob/pivot", components=[{"formula": "sin(2*x)"}, 0]), "x"),
    ],
)
def test_what_cant_be_used_is_told_with_its_place(change, told):
    scene = pendulum()
    with pytest.raises(tisserand.InputError, match=told):
        tisserand.Mechanism(change(scene))


def test_calls_with_wrong_names_and_steps_are_exceptions():
    motion = tisserand.Mechanism(pendulum())
    for call in (lambda: motion.output("angel"), lambda: motion.set_input("moter", 1.0), lambda: motion.step(-1.0), lambda: motion.step(float("nan"))):
        with pytest.raises(tisserand.Error):
            call()
    with pytest.raises(tisserand.Error):
        motion.restore(tisserand.Mechanism(tisserand.Scene(2).rigid("free", mass=1, inertia=1).integrate(step=1, end=1)).save())
    motion.step(1e-3)
    assert motion.time == pytest.approx(1e-3)


def test_a_pendulum_is_that_of_other_codes():
    """The public rotor on a ball joint, spinning and falling: the history of Exudyn, and that of MBDyn, recorded with what they ran."""
    record = json.loads((REPOSITORY / "tests/data/exchange/out/rotor_pendulum.json").read_text())
    given = record["parameters"]
    stem = REPOSITORY / "samples/data/rotor/rotor"
    description = json.loads(stem.with_suffix(".json").read_text())
    component = description["component"]
    interfaces = [
        {key: value for key, value in interface.items() if key != "point_set"}
        | ({"nodes": description["point_sets"][interface["point_set"]]} if "point_set" in interface else {})
        for interface in component["interfaces"]
    ]
    matrices = (scipy.io.mmread(stem.with_suffix(ending)).tocsr() for ending in (".mtx", ".mass.mtx"))
    units = tuple(component["units"][key] for key in ("length", "mass", "time"))
    rotor = tisserand.reduce(*matrices, description["points"], interfaces, modes=12, dofs=component["dofs"], units=units, name="rotor")
    spin, pin, at = (np.array(value) for value in (given["angular_velocity"], given["pin"], -rotor.centre_of_mass))
    histories = []
    for step in (1e-4, 5e-5):
        scene = tisserand.Scene(3, gravity=given["gravity"])
        scene.body("rotor", rotor, position=at, angular_velocity=spin, velocity=np.cross(spin, at - pin))
        scene.set(ground={"points": {"pin": given["pin"]}}).spherical("pin", "ground/pin", "rotor/bearing-left")
        scene.output("far", position={"at": "rotor/bearing-right"}).integrate(step=step, end=given["end"], rho_infinity=0.8)
        motion = tisserand.Mechanism(scene)
        history = [motion.output("far").copy()]
        for _ in range(round(given["end"] / given["sampled_every"])):
            motion.step(step, round(given["sampled_every"] / step))
            history.append(motion.output("far"))
        histories.append(np.array(history))
    coarse, fine = histories
    ours = fine + (fine - coarse) / 3
    assert abs(ours - record["exudyn"]).max() < 1e-9
    assert abs(ours - record["mbdyn"]).max() < 2e-7


@pytest.mark.parametrize("kind", ["servo", "controller", "input"])
def test_a_servo_is_a_damped_oscillator(kind):
    """J q'' + d q' + k q = k goal, as an actuator, as a formula, and as a function in the loop, which is late by its hold."""
    inertia, proportional, derivative, goal, end = 0.02, 3.0, 0.1, 0.4, 0.6
    scene = tisserand.Scene(2)
    scene.rigid("wheel", mass=1, inertia=inertia, points={"axle": [0, 0]}).revolute("axle", "ground", "wheel/axle")
    scene.output("angle", joint_coordinate={"joint": "axle"}).output("rate", joint_rate={"joint": "axle"})
    if kind == "servo":
        scene.actuator("motor", "servo", "axle", target={"constant": goal}, proportional=proportional, derivative=derivative)
    elif kind == "controller":
        scene.controller("law", f"{proportional}*({goal} - angle) - {derivative}*rate")
        scene.actuator("motor", "torque", "axle", controller="law")
    else:
        scene.actuator("motor", "torque", "axle", input={"initial": 0})
    scene.output("effort", actuator_effort={"actuator": "motor"}).integrate(step=1e-4, end=end)
    if kind == "input":
        motion = tisserand.Mechanism(scene)

        def law(time, motion):
            return {"motor": proportional * (goal - motion.output("angle")[0]) - derivative * motion.output("rate")[0]}

        found, tolerance = motion.run(end, 1e-4, control=law, record=["angle"])["angle"][-1], 1e-3
    else:
        found, tolerance = tisserand.simulate(scene)["angle"][-1], 1e-6
    decay, square = derivative / (2 * inertia), proportional / inertia
    omega = np.sqrt(square - decay**2)
    expected = goal * (1 - np.exp(-decay * end) * (np.cos(omega * end) + decay / omega * np.sin(omega * end)))
    assert abs(np.ravel(found)[0] - expected) < tolerance


def test_actuators_that_cant_be_are_told():
    scene = pendulum().actuator("motor", "torque", "axis", constant=1)
    with pytest.raises(tisserand.InputError, match="axis.*pivot|pivot"):
        tisserand.Mechanism(scene)
    with pytest.raises(tisserand.InputError, match="coulomb"):
        tisserand.Mechanism(pendulum().actuator("brake", "friction", "pivot", coulomb=-1))
