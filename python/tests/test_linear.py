"""Linear systems: against control, against steps of the mechanism, and as files."""

import os
import pathlib

import numpy as np
import pytest
import tisserand

REPOSITORY = pathlib.Path(os.environ.get("TISSERAND_REPOSITORY", pathlib.Path(__file__).resolve().parents[2]))
ROD = REPOSITORY / "samples/slider-crank/rod.dcb.h5"


def arm(torque=0.0):
    """A flexible rod on a hub that a torque turns against a spring; no gravity: it rests where it is drawn."""
    scene = tisserand.Scene(2)
    scene.rigid("hub", mass=0.1, inertia=1e-4, points={"axle": [0, 0]})
    scene.body("rod", ROD, damping={"rayleigh": [0, 1e-5]})
    scene.rigid("tip", mass=0.05, inertia=1e-5, points={"root": [0, 0]}, position=[0.3, 0])
    scene.revolute("axle", "ground", "hub/axle")
    scene.revolute("root", "hub/axle", "rod/a", orientation="body").revolute("end", "rod/b", "tip/root", orientation="body")
    scene.spring("hold", "torsion_spring", joint="root", stiffness=20, damping=0.01)
    scene.spring("return", "torsion_spring", joint="axle", stiffness=5, damping=0.02)
    scene.spring("stiff", "torsion_spring", joint="end", stiffness=5, damping=0.02)
    scene.load("motor", "torque", at="hub/axle", components=[{"input": {"initial": torque}}])
    scene.output("angle", joint_coordinate={"joint": "axle"}).output("tip", position={"at": "tip/root"})
    return scene.integrate(step=1e-4, end=0.1)


def test_a_step_response_of_control_is_that_of_the_mechanism():
    control = pytest.importorskip("control")
    system = tisserand.linearize(arm()).to_control()
    assert system.input_labels == ["motor"] and system.output_labels == ["angle", "tip_x", "tip_y"]
    amplitude = 1e-3
    motion = tisserand.Mechanism(arm(amplitude))
    history = motion.run(0.1, 1e-4, record=["angle", "tip"])
    response = control.step_response(system, history.time, squeeze=True)
    angle, across = response.outputs[0] * amplitude, response.outputs[2] * amplitude
    assert np.abs(history["angle"] - angle).max() < 2e-4 * np.abs(angle).max()
    assert np.abs(history["tip"][:, 1] - across).max() < 2e-3 * np.abs(across).max()


def test_the_frequency_response_of_the_truncated_system_keeps_its_bound():
    control = pytest.importorskip("control")
    full, small = tisserand.linearize(arm()), tisserand.linearize(arm(), order=4)
    assert len(small.A) == 4 and small.truncation.full_order == len(full.A)
    omega = np.logspace(-1, 5, 200)
    error = np.abs(control.frequency_response(full.to_control(), omega).frdata - control.frequency_response(small.to_control(), omega).frdata)
    rounding = 1e-9 * np.abs(control.frequency_response(full.to_control(), omega).frdata)
    assert (error <= small.truncation.bounds[:, :, None] + rounding).all()
    assert np.allclose(np.sort_complex(small.poles), np.sort_complex(np.linalg.eigvals(small.A)))


def test_a_root_locus_of_control_is_that_of_stiffer_springs():
    control = pytest.importorskip("control")
    system = tisserand.linearize(arm()).to_control()["angle", "motor"]
    gains = [0.5, 5.0, 50.0]
    loci = control.root_locus_map(system, gains=gains).loci
    for gain, found in zip(gains, loci, strict=True):
        closed = arm().to_dict()
        closed["springs"]["return"]["torsion_spring"]["stiffness"] += gain
        expected = tisserand.linearize(tisserand.Scene.from_dict(closed)).poles
        for pole in expected:
            assert np.abs(found - pole).min() < 1e-4 * abs(pole), (gain, pole)


def test_a_mechanism_is_linearized_where_it_is():
    motion = tisserand.Mechanism(arm())
    motion.set_input("motor", 0.1)
    motion.step(1e-4, 50)
    system = motion.linearize(outputs=["angle", "reactions/axle"])
    assert system.time == pytest.approx(5e-3) and not system.is_equilibrium
    assert system.u0[0] == 0.1 and system.y0[0] == motion.output("angle")[0]
    assert system.output_names[1:] == ["reactions/axle.fx", "reactions/axle.fy", "reactions/axle.mz"]
    for name in "ABCD":
        assert not getattr(system, name).flags.writeable
    with pytest.raises(tisserand.InputError, match="motor"):
        motion.linearize(inputs=["moter"])
    with pytest.raises(tisserand.InputError, match="at: "):
        tisserand.linearize(arm(), "later")


def test_files_hold_the_system(tmp_path):
    system = tisserand.linearize(arm(), "static", order=6)
    for ending in ("h5", "npz", "mat"):
        system.write(tmp_path / f"arm.{ending}")
        with pytest.raises(tisserand.InputError, match="exists"):
            system.write(tmp_path / f"arm.{ending}")
    with pytest.raises(tisserand.InputError, match="npz"):
        system.write(tmp_path / "arm.txt")

    arrays = np.load(tmp_path / "arm.npz")
    for name in ("A", "B", "C", "D", "u0", "y0", "poles"):
        assert np.array_equal(arrays[name], getattr(system, name)), name
    assert list(arrays["output_names"]) == system.output_names and list(arrays["state_units"]) == system.state_units
    assert np.array_equal(arrays["bounds"], system.truncation.bounds) and arrays["full_order"] == system.truncation.full_order

    matlab = pytest.importorskip("scipy.io").loadmat(tmp_path / "arm.mat")
    for name in ("A", "B", "C", "D"):
        assert np.array_equal(matlab[name], getattr(system, name)), name
    assert np.array_equal(matlab["poles"][:, 0], system.poles) and np.array_equal(matlab["y0"][:, 0], system.y0)
    assert [str(cell[0][0]) for cell in matlab["input_names"]] == system.input_names

    with pytest.importorskip("h5py").File(tmp_path / "arm.h5") as file:
        for name in ("A", "B", "C", "D"):
            assert np.array_equal(file[name], getattr(system, name)), name
        assert list(file["outputs/name"].asstr()) == system.output_names and np.array_equal(file["outputs/at"], system.y0)
        assert np.array_equal(file["poles/real"], system.poles.real)
        assert np.allclose(file["poles/frequency"], system.frequencies) and np.allclose(file["poles/damping_ratio"], system.damping_ratios)
        assert file.attrs["is_equilibrium"] == 1 and file["truncation"].attrs["bound"] == system.truncation.bound
