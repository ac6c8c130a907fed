"""Every format in and out against something independent: `docs/data/exchange.jsonl`, which docs/import.md and docs/export.md show.

    pip install "numpy<2" scipy h5py meshio pyvista pyNastran pyyeti exudyn pygltflib
    cargo build --release -p dcb-programs
    python3 tests/benches/exchange.py > docs/data/exchange.jsonl

Reads each sample of `tests/data/exchange` with `reduce import` and compares what it writes with the same part in Matrix Market, as SciPy reads both, or
with frequencies that SciPy found from the same files. Writes each export of two parts and lets its clients read it (`peers/export_*.py`). A client that
isn't installed is 'not run'.
"""

import datetime
import importlib.metadata
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import scipy.io
import scipy.sparse

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
DATA = REPOSITORY / "tests/data/exchange"
PEERS = REPOSITORY / "tests/benches/peers"
REDUCE = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target")) / "release/reduce"
REFERENCE = json.load(open(DATA / "reference.json"))

# Format, files, options, who wrote the sample. On the mesh of the component file nothing is rounded.
BRACKET = [
    ("Matrix Market", "bracket.mtx bracket.mass.mtx", "", "own script"),
    ("Abaqus MATRIX INPUT", "abaqus/bracket_STIF1.mtx", "", "own script, after real files"),
    ("Abaqus COORDINATE", "abaqus/bracket_STIF1_coordinate.mtx", "", "own script, after real files"),
    ("Ansys Harwell-Boeing (HBMAT)", "ansys/bracket_stiff.matrix", "", "own script, after AMfe's reader"),
    ("CalculiX .sti, .mas, .dof", "calculix/bracket.sti", "", "CalculiX 2.20"),
    ("Nastran OUTPUT4, ASCII, bigmat", "nastran/bracket_bigmat_ascii.op4", "", "pyyeti 1.4.7"),
    ("Nastran OUTPUT4, binary, bigmat, big-endian", "nastran/bracket_bigmat_be.op4", "", "pyyeti 1.4.7"),
    ("Nastran OUTPUT4, binary, dense", "nastran/bracket_dense_le.op4", "", "pyyeti 1.4.7"),
    ("Nastran OUTPUT4, binary, nonbigmat", "nastran/bracket_nonbigmat_le.op4", "", "pyyeti 1.4.7"),
    ("Nastran DMIG, large fields", "nastran/bracket_double.pch", "", "pyNastran 1.4.1"),
    ("SciPy npz, csr", "scipy/bracket_K_csr.npz", "", "SciPy 1.17.1"),
    ("SciPy npz, csc, stored", "scipy/bracket_K_csc_stored.npz scipy/bracket_M_csr.npz", "", "SciPy 1.17.1"),
    ("SciPy npz, coo", "scipy/bracket_K_coo.npz scipy/bracket_M_csr.npz", "", "SciPy 1.17.1"),
    ("SciPy npz, bsr", "scipy/bracket_K_bsr.npz scipy/bracket_M_array.npz", "", "SciPy 1.17.1"),
    ("NumPy npz, dense", "scipy/bracket_dense.npz", "", "NumPy 2.4"),
    ("npz with dof_ref (ansys-mapdl-reader)", "scipy/bracket_dof_ref.npz", "", "NumPy 2.4"),
    ("MATLAB 5", "matlab/bracket_v5.mat", "", "SciPy 1.17.1"),
    ("MATLAB 5, compressed", "matlab/bracket_v5_compressed.mat", "", "SciPy 1.17.1"),
    ("MATLAB 7.3", "matlab/bracket_v73.mat", "", "h5py 3.16, after MATLAB's files"),
    ("PETSc", "petsc/bracket_K.petsc petsc/bracket_M.petsc", "", "own script; PETSc 3.18 writes the same bytes"),
]
# Name, files, mesh, options, modes, reference.
REAL = [
    ("Ansys APDL Math, Matrix Market with map", "ansys/rotor_stiffness.txt ansys/rotor_mass.txt", "ansys/rotor_nodes.txt", "--dofs ansys/rotor_map.txt", "ansys/rotor", "Ansys"),
    ("the same without its map, --repair-order", "ansys/rotor_stiffness.txt ansys/rotor_mass.txt", "ansys/rotor_nodes.txt", "--repair-order", "ansys/rotor", "Ansys"),
    ("Abaqus MATRIX INPUT, internal node", "abaqus/fembeam/model_STIF1.mtx", "abaqus/fembeam/model.inp", "", "abaqus/fembeam", "Abaqus"),
    ("Nastran external superelement", "nastran/pyyeti/outboard.op4#KXX", "nastran/pyyeti/outboard.pch", "", "nastran/outboard", "Nastran"),
    ("CalculiX, rigid body", "calculix/bracket_rigid.sti", "calculix/bracket_rigid.inp", "", "calculix/bracket_rigid", "CalculiX 2.20"),
    ("CalculiX, incompatible modes", "calculix/plate_incompatible.sti", "calculix/plate_incompatible.inp", "", "calculix/plate_incompatible", "CalculiX 2.20"),
]
MESHES = [
    ("Abaqus, CalculiX .inp", "calculix/bracket.inp", "CalculiX deck"),
    ("Nastran bulk data", "mesh/bracket.bdf", "own; pyNastran 1.4.1 reads it"),
    ("Gmsh 4.1, ASCII", "mesh/bracket_ascii.msh", "Gmsh 4.15.2"),
    ("Gmsh 4.1, binary", "mesh/bracket_binary.msh", "Gmsh 4.15.2"),
    ("UNV", "mesh/bracket.unv", "own; Gmsh writes the same cells"),
    ("VTU", "mesh/bracket_zlib.vtu", "meshio 5.3.5"),
    ("component JSON", "bracket.json", "own script"),
]


def reduce(*arguments):
    run = subprocess.run([REDUCE, *arguments], cwd=DATA, capture_output=True, text=True)
    if run.returncode:
        raise SystemExit(f"reduce {' '.join(map(str, arguments))}\n{run.stderr}")
    return run.stdout


def symmetric(path):
    """The full matrix of a Matrix Market file."""
    return scipy.sparse.csr_matrix(scipy.io.mmread(path))


def far(found, expected):
    return float(abs(found - expected).max() / abs(expected).max())


def resistance(text):
    return float(re.search(r"K R +([0-9.e+-]+)", text).group(1))


def imported(files, mesh, options, folder):
    """The component's files, and what the import reports."""
    out = folder / "part.mtx"
    told = reduce("import", *files.split(), "--mesh", mesh, *options.split(), "--units", "mm,t,s", "--force", "-o", out)
    return symmetric(out), symmetric(folder / "part.mass.mtx"), json.load(open(folder / "part.json")), told


def matrices(folder):
    expected = symmetric(DATA / "bracket.mtx"), symmetric(DATA / "bracket.mass.mtx")
    for name, files, options, wrote in BRACKET:
        by_label = "pch" in files
        mesh = "mesh/bracket.bdf" if by_label else "bracket.json"
        k, m, _, told = imported(files, mesh, options, folder)
        if by_label:
            order = by_rising_label(folder / "part.json")
            k, m = k[order][:, order], m[order][:, order]
        errors = far(k, expected[0]), far(m, expected[1])
        yield {
            "kind": "matrix", "format": name, "files": files, "written_by": wrote, "against": "bracket.mtx, read by SciPy", "stiffness_error": errors[0], "mass_error": errors[1],
            "k_r": resistance(told),
        }


def by_rising_label(path):
    """Rows of a component whose nodes stand in the order of a mesh, in the order of bracket.mtx, whose nodes are found by their places."""
    found, expected = (np.array(json.load(open(path))["points"]) for path in (path, DATA / "bracket.json"))
    nodes = [int(np.linalg.norm(found - point, axis=1).argmin()) for point in expected]
    return [3 * node + axis for node in nodes for axis in range(3)]


def real(folder):
    for name, files, mesh, options, key, wrote in REAL:
        _, _, _, told = imported(files, mesh, options, folder)
        expected = REFERENCE[key]["frequencies_hz"]
        wanted = min(len(expected), 5)
        reduce(folder / "part.mtx", "--modes", str(wanted), "--force")
        with h5py.File(folder / "part.dcb.h5") as file:
            found = np.sqrt(file["modes/eigenvalues"][:]) / (2 * np.pi)
        count = min(len(found), len(expected))
        error = max(abs(found[i] / expected[i] - 1) for i in range(count))
        yield {
            "kind": "real", "format": name, "files": files, "written_by": wrote, "against": REFERENCE[key].get("what", "SciPy's frequencies of the same files"),
            "frequencies": count, "frequency_error": float(error), "k_r": resistance(told),
        }


def meshes(folder):
    expected = np.array(json.load(open(DATA / "bracket.json"))["points"])
    for name, mesh, wrote in MESHES:
        matrices, order = ("matlab/bracket_v5.mat", "--node-order label") if mesh != "bracket.json" else ("matlab/bracket_v5.mat", "")
        _, _, part, told = imported(matrices, mesh, order, folder)
        points = np.array(part["points"])
        nearest = [np.linalg.norm(points - point, axis=1).min() for point in expected]
        size = np.linalg.norm(np.ptp(expected, axis=0))
        yield {
            "kind": "mesh", "format": name, "files": mesh, "written_by": wrote, "against": "bracket.json", "nodes": len(points), "point_error": float(max(nearest) / size),
            "sets": [one["name"] for one in part["component"].get("interfaces", [])], "k_r": resistance(told),
        }


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def printed(script, *arguments):
    """What a client's script prints, and whether its limits hold."""
    run = subprocess.run([sys.executable, "-W", "ignore", script, *map(str, arguments)], capture_output=True, text=True)
    places = re.compile(r"\S*/(?=[^/\s]+)")
    return places.sub("", run.stdout + run.stderr), run.returncode == 0


def client(target, packages, errors, script, *arguments):
    """What a program reads of an export; `errors` are named patterns of the numbers that its script prints."""
    missing = [package for package in packages if not version(package)]
    if missing:
        return not_run(target, ", ".join(packages), f"{', '.join(missing)} isn't installed")
    text, held = printed(PEERS / script, *arguments)
    found = {name: max(float(number) for number in re.findall(pattern, text)) for name, pattern in errors.items()}
    return {"kind": "client", "target": target, "client": ", ".join(f"{package} {version(package)}" for package in packages), "held": held, "errors": found, "said": text.strip().splitlines()}


def not_run(target, client, why):
    return {"kind": "client", "target": target, "client": client, "held": None, "why": why}


EXPORTS = [
    ("npz", None, "rotor.npz"), ("simscape", None, "rotor.mat"), ("nastran", None, "rotor.bdf"), ("nastran", "op4", "rotor_op4.bdf"), ("exudyn", None, "rotor.hdf5"),
    ("mbdyn", None, "rotor.fem"), ("sid", "vector", "rotor.SID_FEM"), ("sid", "matrix", "rotor_matrix.SID_FEM"), ("gltf", None, "rotor.glb"),
]


SCENE = {
    "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, 0, -9.81], "ground": {"points": {"pin": [0, 0, 0]}},
    "bodies": {"rotor": {"superelement": "rotor.dcb.h5"}}, "joints": {"ball": {"spherical": {"a": "ground/pin", "b": "rotor/bearing-left"}}},
    "fields": [{"body": "rotor", "directory": "fields", "every": 1e-3}], "integrator": {"generalized_alpha": {"step": 5e-5, "end": 5e-3}},
}


def exports(folder):
    shutil.copytree(REPOSITORY / "samples/data/rotor", folder / "rotor")
    rotor, part = folder / "rotor/rotor.mtx", folder / "rotor.dcb.h5"
    reduce(rotor, "--modes", "12", "-o", part)
    made = {}
    for target, dialect, name in EXPORTS:
        made[target, dialect] = folder / name
        reduce("export", part, "--to", target, *(["--dialect", dialect] if dialect else []), "-o", folder / name)
        read = (folder / name).with_suffix(".op4") if dialect == "op4" else folder / name
        text, held = printed(REPOSITORY / "tests/h5py/exports.py", part, target, read)
        if not held:
            raise SystemExit(text)
        # The volume under flat triangles isn't the part's.
        found = {name: value for name, value in json.loads(text).items() if isinstance(value, float) and name != "volume"}
        yield {"kind": "export", "target": target, "dialect": dialect, "read_by": "tests/h5py/exports.py", "error": max(map(abs, found.values())), "errors": found}
    fem = rotor, rotor.with_name("rotor.mass.mtx")
    number = r"([0-9.]+e[+-][0-9]+)"
    yield client("npz, simscape", ["numpy", "scipy"], {"K R": f"K R {number}"}, "export_scipy.py", made["simscape", None], made["npz", None], *fem, part)
    yield client("nastran", ["pyNastran", "pyyeti"], {"DMIG": f"DMIG .* off by {number}", "OUTPUT4": f"OUTPUT4 .* off by {number}"}, "export_nastran.py", made["npz", None], made["nastran", None], made["nastran", "op4"])
    history = DATA / "out/rotor_pendulum.json"
    errors = {"arrays": f"over K and M: {number}", "pendulum, m": f"recorded history: {number}"}
    yield client("exudyn", ["exudyn"], errors, "export_exudyn.py", part, made["exudyn", None], "--matrices", *fem, "--pendulum", history)
    yield client("gltf", ["pygltflib"], {"places": f"places off by {number}"}, "export_gltf.py", made["gltf", None], part)
    (folder / "scene.json").write_text(json.dumps(SCENE))
    subprocess.run([REDUCE.with_name("simulate"), folder / "scene.json", "--quiet"], check=True)
    yield client("fields of `simulate`", ["meshio", "pyvista"], {"each other": f"differ by {number}"}, "read_fields.py", folder / "fields", "rotor")
    yield not_run("mbdyn", "MBDyn", "no package manager here has it")
    for target, program in (("simscape", "MATLAB"), ("nastran", "Nastran"), ("sid", "Dymola, Simpack")):
        yield not_run(target, program, "no licence at hand")


def conditions():
    told = lambda *command: subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY).stdout.strip()
    packages = {name: version(name) for name in ("numpy", "scipy", "h5py", "meshio", "pyvista", "pyNastran", "pyyeti", "exudyn", "pygltflib")}
    return {"kind": "conditions", "command": "python3 tests/benches/exchange.py", "commit": told("git", "rev-parse", "--short", "HEAD"), "date": datetime.date.today().isoformat(), **packages}


def main():
    print(json.dumps(conditions()))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for lines in (matrices, real, meshes, exports):
            for line in lines(folder):
                print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
