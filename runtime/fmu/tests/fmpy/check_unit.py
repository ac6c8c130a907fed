"""FMPy validates an FMU, simulates it and compares with what was recorded elsewhere.

python check_unit.py UNIT.fmu REFERENCE.json

REFERENCE.json has the outputs of a whole run (`run`), and what a sampled controller around the mechanism in Rust gave
(`controlled`, with its gains). Nothing here knows how either of them was computed.
"""

import json
import os
import shutil
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

archive, reference = sys.argv[1], json.load(open(sys.argv[2]))
names = sorted(reference["run"]["outputs"])
folder = fmpy.extract(archive)
description = fmpy.read_model_description(folder)
references = {variable.name: variable.valueReference for variable in description.modelVariables}

# Terminals are those of the standard's schema, and name variables that are there.
terminals = os.path.join(folder, "terminalsAndIcons", "terminalsAndIcons.xml")
schema = etree.XMLSchema(etree.parse(os.path.join(os.path.dirname(fmpy.__file__), "schema", "fmi3", "fmi3TerminalsAndIcons.xsd")))
document = etree.parse(terminals)
schema.assertValid(document)
grouped = {terminal.get("name"): [member.get("variableName") for member in terminal] for terminal in document.iter("Terminal")}
assert grouped and all(name in references for members in grouped.values() for name in members), grouped
assert all(name.startswith((f"{terminal}.", f"{terminal}/")) for terminal, members in grouped.items() for name in members), grouped


class Unit:
    """An instance with names in the place of value references."""

    def __init__(self, unzipped=folder, token=description.instantiationToken):
        self.messages = []
        self.fmu = FMU3Slave(
            guid=token,
            unzipDirectory=unzipped,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        tell = lambda environment, status, category, message: self.messages.append(message.decode())
        self.fmu.instantiate(logMessage=tell, loggingOn=True)

    def start(self):
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def get(self, *wanted):
        return np.array(self.fmu.getFloat64([references[name] for name in wanted]))

    def set(self, name, value):
        self.fmu.setFloat64([references[name]], [value])

    def go(self, length, steps):
        for index in steps:
            self.fmu.doStep(index * length, (index + 1) * length - index * length)
        return self


def furthest(found, expected):
    expected = np.asarray(expected)
    return float(np.max(np.abs(np.asarray(found) - expected)) / max(np.max(np.abs(expected)), 1e-300))


def check(what, off, limit):
    print(f"{what}: {off:.1e}")
    assert off <= limit, f"{what}: {off:.1e} > {limit:.1e}"


def is_valid():
    problems = validate_fmu(archive)
    assert problems == [], problems
    units = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        assert variable.unit is None or units[variable.unit] is not None, variable.name


def moves_as_a_whole_run():
    run = reference["run"]
    found = fmpy.simulate_fmu(archive, output_interval=run["interval"], stop_time=run["time"][-1])
    assert len(found) == len(run["time"])
    for name in names:
        check(f"against a whole run, {name}", furthest(found[name], run["outputs"][name]), 1e-12)


def other_steps_are_near():
    run = reference["run"]
    interval = 2.6 * reference["step"]
    found = fmpy.simulate_fmu(archive, output_interval=interval, stop_time=run["time"][-1])
    name = reference["smooth"]
    expected = np.interp(found["time"], run["time"], run["outputs"][name])
    off = furthest(found[name], expected)
    check(f"steps that aren't whole multiples, {name}", off, 1e-3)
    assert off > 0


def saved_states_have_one_future():
    length = reference["step"]
    unit = Unit().start().go(length, range(20))
    state = unit.fmu.getFMUState()
    now = unit.get(*names)
    future = unit.go(length, range(20, 60)).get(*names)
    unit.fmu.setFMUState(state)
    assert (unit.get(*names) == now).all()
    again = unit.go(length, range(20, 60)).get(*names)
    check("from a saved state", furthest(again, future), 0.0)
    saved = unit.fmu.serializeFMUState(state)
    unit.fmu.freeFMUState(state)
    unit.fmu.freeInstance()
    other = Unit()
    state = other.fmu.deserializeFMUState(saved)
    other.fmu.setFMUState(state)
    assert (other.get(*names) == now).all()
    again = other.go(length, range(20, 60)).get(*names)
    check("from a state in bytes", furthest(again, future), 0.0)
    other.fmu.freeFMUState(state)
    other.fmu.freeInstance()


def resets_and_instances():
    length = reference["step"]
    alone = Unit().start().go(length, range(30))
    expected = alone.get(*names)
    alone.fmu.reset()
    assert (alone.start().go(length, range(30)).get(*names) == expected).all()
    several = [Unit().start() for _ in range(4)]
    with ThreadPoolExecutor(4) as pool:
        moved = list(pool.map(lambda unit: unit.go(length, range(30)).get(*names), several))
    assert all((found == expected).all() for found in moved)
    for unit in [alone, *several]:
        unit.fmu.terminate()
        unit.fmu.freeInstance()


def controlled():
    given = reference.get("controlled")
    if given is None:
        return
    unit = Unit().start()
    found = []
    for index in range(len(given["tip"])):
        angle, rate = unit.get("angle", "rate")
        unit.set("motor", -given["gains"][0] * (angle + given["angle"]) - given["gains"][1] * rate)
        unit.go(given["interval"], [index])
        found.append(unit.get("tip.x", "tip.y", "tip.z"))
    check("controlled, against the mechanism in Rust", furthest(found, given["tip"]), 1e-12)
    unit.fmu.freeInstance()


def refused(what, *words, **arguments):
    unit = Unit.__new__(Unit)
    try:
        unit.__init__(**arguments)
    except Exception:
        told = " ".join(unit.messages)
        assert all(word in told for word in words), told
        return
    raise AssertionError(f"{what}: instantiated")


def broken_archives_are_refused():
    refused("token", "instantiation token", token="another")
    copy = tempfile.mkdtemp()
    shutil.copytree(folder, copy, dirs_exist_ok=True)
    resources = os.path.join(copy, "resources")
    name = next(name for name in sorted(os.listdir(resources)) if name.endswith(".h5"))
    path = os.path.join(resources, name)
    content = bytearray(open(path, "rb").read())
    for place in range(len(content) // 2, len(content) // 2 + 64):
        content[place] ^= 0x55
    open(path, "wb").write(content)
    refused("damaged", name, unzipped=copy)
    os.remove(path)
    refused("missing superelement", name, "there is no file", unzipped=copy)
    os.remove(os.path.join(resources, "scene.json"))
    refused("missing scene", "scene.json", unzipped=copy)
    shutil.rmtree(copy)


def a_folder_that_cannot_be_written_is_enough():
    copy = tempfile.mkdtemp()
    shutil.copytree(folder, copy, dirs_exist_ok=True)
    places = [os.path.join(root, name) for root, folders, files in os.walk(copy) for name in folders + files]
    before = sorted(places)
    for place in [*places, copy]:
        os.chmod(place, 0o555)
    unit = Unit(unzipped=copy).start().go(reference["step"], range(10))
    unit.fmu.terminate()
    unit.fmu.freeInstance()
    after = sorted(os.path.join(root, name) for root, folders, files in os.walk(copy) for name in folders + files)
    assert before == after
    for place in [*places, copy]:
        os.chmod(place, 0o755)
    shutil.rmtree(copy)


is_valid()
moves_as_a_whole_run()
other_steps_are_near()
saved_states_have_one_future()
resets_and_instances()
controlled()
broken_archives_are_refused()
a_folder_that_cannot_be_written_is_enough()
shutil.rmtree(folder)
print("all is well")
