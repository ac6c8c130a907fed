"""What goes beyond the usual call: further matrices, scenes, forks, arguments that can't be meant."""

import json
import multiprocessing
import shutil
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sparse
import tisserand
from test_reduce import DATA, REPOSITORY, bracket, reduced, solid  # noqa: F401

SAMPLE = REPOSITORY / "samples/controlled-crank/scene.json"


def program(name, *arguments):
    command = [sys.executable, "-c", f"from tisserand._programs import {name}; raise SystemExit({name}())"]
    done = subprocess.run([*command, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def copied_component(folder):
    for name in ("bracket.mtx", "bracket.mass.mtx", "bracket.json"):
        shutil.copy(DATA / name, folder / name)
    return folder / "bracket.mtx"


def same_numbers(one, other):
    assert one.rows == other.rows
    for name in ("eigenvalues", "interface_shapes", "residual_flexibility", "residual_mass"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name


def test_further_matrices_are_those_of_files(bracket, tmp_path):
    size = bracket["K"].shape[0]
    rng = np.random.default_rng(3)
    scratch = sparse.random_array((size, size), density=0.02, rng=rng).tocsr()
    geometric = scratch + scratch.T
    boundary = sparse.random_array((2, size), density=0.1, rng=rng).tocoo()
    load = rng.standard_normal(size)
    row = f"{bracket['interfaces'][0]['name']}.ux"
    stiffness = copied_component(tmp_path)
    scipy.io.mmwrite(tmp_path / "bracket.boundary.mtx", boundary, precision=17)
    scipy.io.mmwrite(tmp_path / f"bracket.stiffening.{row}.mtx", geometric, precision=17, symmetry="symmetric")
    scipy.io.mmwrite(tmp_path / "bracket.load.wind.mtx", sparse.coo_array(load[:, None]), precision=17)
    program("reduce", stiffness, "--modes", 8, "-q")
    of_files = tisserand.Superelement.read(tmp_path / "bracket.dcb.h5")
    for form in (boundary, boundary.tocsr(), boundary.tocsc(), boundary.toarray()):
        made = tisserand.reduce(**bracket, modes=8, boundary=form, stiffening={row: geometric}, loads={"wind": load})
        same_numbers(made, of_files)
    assert [name for name in of_files.rows if name.startswith("boundary")]
    plain = tisserand.reduce(**bracket, modes=8)
    assert len(made.rows) == len(plain.rows) + 2
    with pytest.raises(tisserand.InputError, match="neither a product of spins"):
        tisserand.reduce(**bracket, modes=8, stiffening={"hubb.ux": geometric})


def test_component_masses_of_a_solid_change_nothing(bracket, reduced):
    mass = bracket["M"].tocoo()
    axes = dict(enumerate("xyz"))
    # Of a solid the masses of all axes are one scalar matrix.
    scalar = mass.row % 3 == 0
    row, column, values = mass.row[scalar] // 3, mass.col[scalar] // 3, mass.data[scalar]
    pairs = {f"{axes[a]}{axes[b]}": sparse.coo_array((values, (3 * row + a, 3 * column + b)), mass.shape) for a, b in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]}
    made = tisserand.reduce(**bracket, modes=10, component_masses=pairs)
    same_numbers(made, reduced)
    assert np.allclose(made.inertia, reduced.inertia, rtol=1e-12, atol=1e-12 * abs(reduced.inertia).max())
    del pairs["yz"]
    with pytest.raises(tisserand.InputError, match="component_masses: are xx, yy, zz, xy, zx, expected"):
        tisserand.reduce(**bracket, component_masses=pairs)


def test_a_reduction_for_a_scene_is_the_programs(bracket, tmp_path):
    stiffness = copied_component(tmp_path)
    held, free = (interface["name"] for interface in bracket["interfaces"][:2])
    scene = {
        "dimension": 3,
        "units": dict(zip(("length", "mass", "time"), bracket["units"], strict=True)),
        "bodies": {"arm": {"superelement": "bracket.dcb.h5"}},
        "joints": {"foot": {"fixed": {"a": "ground", "b": f"arm/{held}"}}},
        "loads": {"push": {"force": {"at": f"arm/{free}", "components": [0, 0, 1.0]}}},
        "outputs": {"tip": {"displacement": {"at": f"arm/{free}"}}},
        "integrator": {"generalized_alpha": {"step": 1e-5, "end": 1e-3}},
    }
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    program("reduce", stiffness, "--scene", tmp_path / "scene.json", "-q")
    of_files = tisserand.Superelement.read(tmp_path / "bracket.dcb.h5")
    (tmp_path / "bracket.dcb.h5").unlink()
    named = bracket | {"name": "bracket"}
    for given in (tmp_path / "scene.json", tisserand.Scene.from_dict(scene, tmp_path)):
        same_numbers(tisserand.reduce(**named, scene=given), of_files)
    wider = tisserand.reduce(**named, scene=scene, bodies=["arm"], keep_all=True)
    assert not np.array_equal(wider.residual_mass, of_files.residual_mass)
    with pytest.raises(tisserand.InputError, match="no body is made of"):
        tisserand.reduce(**bracket | {"name": "another"}, scene=scene)
    with pytest.raises(tisserand.InputError, match="tolerance: is 2"):
        tisserand.reduce(**named, scene=scene, tolerance=2)


def test_a_run_carries_what_the_program_carries(tmp_path):
    results = tmp_path / "program.h5"
    program("simulate", SAMPLE, "--end", 0.01, "-o", results, "-q")
    of_program = tisserand.Results(results)
    scene = tisserand.Scene.read(SAMPLE)
    data = scene.to_dict()
    for method in data["integrator"].values():
        method["end"] = 0.01
    short = tisserand.Scene.from_dict(data, scene.folder)
    told = []
    ours = tisserand.simulate(short, note=lambda _, text: told.append(text))
    whole = tisserand.simulate(short, model="everything")
    for name in of_program:
        if not name.startswith("integrator"):
            assert np.array_equal(ours[name], of_program[name]), name
    assert any("simplified for this scene" in text for text in told), told
    name = next(channel.name for channel in ours.channels if channel.path.startswith("outputs/"))
    assert not np.array_equal(whole[name], ours[name])
    assert np.allclose(whole[name], ours[name], atol=1e-3 * abs(whole[name]).max())


def test_a_scene_written_elsewhere_finds_its_files(tmp_path):
    (tmp_path / "deep").mkdir()
    target = tmp_path / "deep/scene.json"
    tisserand.Scene.read(SAMPLE).write(target)
    assert tisserand.Mechanism(target).time == 0.0


def pendulum():
    scene = tisserand.Scene(2, gravity=[0, -9.81])
    scene.rigid("bob", mass=1, inertia=1e-6, points={"pivot": [-0.5, 0]}, position=[0.5, 0]).revolute("pivot", "ground", "bob/pivot")
    scene.actuator("motor", "torque", "pivot", input={"initial": 0})
    return scene.output("angle", joint_coordinate={"joint": "pivot"}).output("rate", joint_rate={"joint": "pivot"}).integrate(step=1e-3, end=1)


def test_an_input_acts_in_full_from_the_time_it_is_set():
    scene = tisserand.Scene(2).rigid("wheel", mass=1, inertia=1.0, points={"axle": [0, 0]}).revolute("axle", "ground", "wheel/axle")
    scene.actuator("motor", "torque", "axle", input={"initial": 0}).output("rate", joint_rate={"joint": "axle"}).integrate(step=1e-2, end=1)
    motion = tisserand.Mechanism(scene)
    motion.step(1e-2)
    motion.set_input("motor", 1.0)
    motion.step(1e-2, 99)
    assert abs(motion.output("rate")[0] - 0.99) < 1e-12


def forked(count):
    """Eigenvalues, and outputs of a linear system, in a process without the threads of its parent."""
    part = solid((6, 2, 2))
    made = tisserand.reduce(**part, modes=count)
    system = tisserand.linearize(pendulum())
    return made.eigenvalues.tobytes(), system.poles.tobytes()


@pytest.mark.skipif(sys.platform != "linux", reason="forks")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_forked_processes_reduce_too():
    here = forked(5)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(forked, [5, 5]).get(timeout=60) == [here, here]


def test_a_mechanism_in_use_stops_no_other_thread():
    motion = tisserand.Mechanism(pendulum())
    steps = threading.Thread(target=lambda: motion.step(1e-5, 60_000))
    pauses, last = [], [time.monotonic()]

    def tick():
        while steps.is_alive():
            now = time.monotonic()
            pauses.append(now - last[0])
            last[0] = now
            time.sleep(1e-3)

    steps.start()
    ticking = threading.Thread(target=tick)
    ticking.start()
    while steps.is_alive():
        assert motion.time >= 0.0
    ticking.join()
    # A call waits for up to 50 ms of steps; others don't.
    assert np.median(pauses) < 0.02, pauses


def broken(matrix, **arrays):
    made = matrix.copy()
    for name, change in arrays.items():
        array = getattr(made, name).copy()
        change(array)
        setattr(made, name, array)
    return made


def test_index_arrays_that_lie_are_refused_or_put_in_order(bracket, reduced):
    stiffness = bracket["K"]

    def set_at(at, value):
        return lambda array: array.__setitem__(at, value)

    for change, told in [
        ({"indptr": set_at(5, 10**6)}, "contradict each other"),
        ({"indptr": set_at(-1, 3)}, "contradict each other"),
        ({"indices": set_at(2, 10**6)}, r"has the index 1000000, expected 0 to 239"),
        ({"indices": set_at(2, -1)}, "negative or beyond 32 bits"),
    ]:
        with pytest.raises(tisserand.InputError, match=told):
            tisserand.reduce(**bracket | {"K": broken(stiffness, **change)}, modes=4)
        with pytest.raises(tisserand.InputError, match=told):
            tisserand.reduce(**bracket, modes=4, boundary=broken(stiffness, **change))
    # It says that it is sorted.
    lying = stiffness.copy()
    lying.indices[:2], lying.data[:2] = lying.indices[1::-1].copy(), lying.data[1::-1].copy()
    lying.has_sorted_indices = lying.has_canonical_format = True
    assert np.array_equal(tisserand.reduce(**bracket | {"K": lying}, modes=10).eigenvalues, reduced.eigenvalues)
    narrow = stiffness.copy()
    narrow.indices = narrow.indices.astype(np.uint16)
    assert np.array_equal(tisserand.reduce(**bracket | {"K": narrow}, modes=10).eigenvalues, reduced.eigenvalues)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"units": "SI"}, r"units: are 'SI', expected length, mass and time"),
        ({"units": ("mm", "t")}, "expected length, mass and time"),
        ({"interfaces": None}, "expected nodes by name"),
        ({"interfaces": [[1, 2, 3]]}, r"have \[1, 2, 3\] without a name"),
        ({"interfaces": {"hub": 3}}, r"interfaces\['hub'\]: is 3, expected nodes counted from 0"),
        ({"interfaces": {"hub": np.arange(80) < 4}}, "is a mask.*np.flatnonzero"),
        ({"interfaces": {"hub": [0.0, 1.0, 2.0]}}, "float64"),
        ({"interfaces": {"hub": [-1, 2, 3]}}, "has -1, expected nodes counted from 0"),
        ({"points": [[0, 0, 0], [1, 0]]}, "rows differ in length"),
        ({"modes": 6.0}, r"modes: is 6.0, expected a whole number from 0 on"),
        ({"modes": True}, "modes: is True"),
        ({"modes": 10**30}, "modes: is 1000"),
        ({"max_frequency": float("inf")}, "max_frequency: is inf, expected a positive number of Hz"),
        ({"enrich": "krylov"}, r"is the text 'krylov', expected a list"),
        ({"enrich": ["krilov"]}, "expected one of spin, loads, krylov"),
        ({"threads": -1}, "threads: is -1, expected a whole number from 1 on"),
        ({"memory": -5}, "memory: is -5"),
        ({"progress": 3}, "progress: is 3, expected a function"),
        ({"K": sparse.coo_array(np.ones(5))}, "K: has 1 axes, expected a matrix with two"),
    ],
)
def test_arguments_that_cant_be_meant_are_told(bracket, change, told):
    with pytest.raises(tisserand.InputError, match=told):
        tisserand.reduce(**bracket | {"modes": 4} | change)


def test_interfaces_are_any_nodes(bracket):
    nodes = bracket["interfaces"][0]["nodes"]
    forms = [nodes, tuple(nodes), set(nodes), np.array(nodes), np.array(nodes, dtype=np.uint16)]
    made = [tisserand.reduce(**bracket | {"interfaces": {"hub": form}}, modes=4) for form in forms]
    assert len({one.residual_flexibility.tobytes() for one in made}) == 1


def test_superelements_and_mechanisms_refuse_what_cant_be_meant(reduced, tmp_path):
    motion = tisserand.Mechanism(pendulum())
    assert motion.input_names == ["motor"] and motion.output_names[:2] == ["angle", "rate"] and len(motion.history) == 0
    assert motion.outputs().shape == (0,) and motion.outputs("angle", "rate").shape == (2,)
    for call, told in [
        (lambda: reduced.errors(-5.0), "max_frequency: is -5.0"),
        (lambda: reduced.errors(compatibility="weak"), "expected one of strong, static"),
        (lambda: reduced.errors(points=0), "points: is 0"),
        (lambda: reduced.errors(points=10**12), "points: is 1000000000000, expected 1 to 1000000"),
        (lambda: reduced.select(modes=-1), "modes: is -1"),
        (lambda: reduced.compare("rod.dcb.h5"), "expected a superelement; Superelement.read"),
        (lambda: motion.step(1e-3, -1), "count: is -1, expected 0 or more"),
        (lambda: motion.run(-1, 1e-3), "duration: is -1, expected a positive number"),
        (lambda: motion.run(0.1, 1e-3, every=1.5), "every: is 1.5"),
        (lambda: motion.run(0.1, 1e-3, record="angle"), "record: is the text 'angle'"),
        (lambda: motion.run(0.1, 1e-3, control=lambda time, motion: 0.5), "control: returned 0.5, expected inputs by name"),
        (lambda: motion.linearize(inputs="motor"), "inputs: is the text 'motor'"),
        (lambda: tisserand.linearize(pendulum(), order=-1), "order: is -1"),
        (lambda: tisserand.simulate(pendulum(), model="half"), "expected one of needed, everything"),
        (lambda: tisserand.simulate(pendulum(), progress="yes"), "progress: is 'yes', expected a function"),
        (lambda: tisserand.Scene.from_dict("scene.json"), "Scene.read reads a file"),
        (lambda: tisserand.Scene(2, units=("m", "kg")), "units: are"),
        (lambda: tisserand.Scene(2).output("e", "energy", position={}), "wants one of the two"),
        (lambda: tisserand.Scene(2).output("e"), "wants one of the two"),
    ]:
        with pytest.raises(tisserand.InputError, match=told):
            call()
    results = tisserand.simulate(pendulum())
    assert np.array_equal(results["bob/frame"], results["motion/bob/frame"])
    assert len(results) == len(results.keys()) == len(results.channels) and "angle" in results.keys()
