"""What a reduction costs by the size of the part: measured rows, and one by extrapolation that says so. Used by `render_performance.py`."""
import math
from statistics import median

import peer_table

SHAPE = "conrod"
MODES = 30
BEYOND = 1e7  # dofs
FACTORS = ("factor", "certificate")  # stages whose time is that of a factorization's operations
SWEEPS = ("modes", "attachments")  # and of passes over the factor


class Row:
    """Medians of the runs of one part with two threads."""

    def __init__(self, case):
        runs = case.of("reduce", 2)
        middle = lambda get: median(get(run) for run in runs)
        self.dofs = case.dofs
        self.entries = case.factor["entries"]
        self.flops = middle(lambda run: run["work"]["factor_flops"])
        self.bytes = middle(lambda run: run["work"]["stored_bytes"])
        self.peak = middle(lambda run: run["peak_mb"]) / 1e3
        self.wall = middle(lambda run: run["wall"])
        self.stages = {name: middle(lambda run: run["stages"].get(name, 0.0)) for name in runs[0]["stages"]}
        self.measured = True

    def time(self, names):
        return sum(self.stages.get(name, 0.0) for name in names)


def exponent(small, large, what):
    return math.log(what(large) / what(small)) / math.log(large.dofs / small.dofs)


class Extrapolated(Row):
    """From the two largest rows: operations, bytes and entries grow with powers of the dofs, and every stage takes as long for each of them as in the larger row."""

    def __init__(self, small, large, dofs):
        grown = lambda what: (dofs / large.dofs) ** exponent(small, large, what)
        self.powers = {name: exponent(small, large, what) for name, what in QUANTITIES.items()}
        flops, stored, entries = (grown(what) for what in QUANTITIES.values())
        self.dofs = dofs
        self.flops, self.bytes, self.entries = large.flops * flops, large.bytes * stored, large.entries * entries
        self.stages = {}
        for name, seconds in large.stages.items():
            self.stages[name] = seconds * (flops if name in FACTORS else stored if name in SWEEPS else entries)
        self.wall = sum(self.stages.values())
        rest = large.peak - large.bytes / 1e9
        self.peak = self.bytes / 1e9 + rest * entries
        self.measured = False


QUANTITIES = {
    "operations": lambda row: row.flops,
    "bytes of the factor": lambda row: row.bytes,
    "entries of the stiffness": lambda row: row.entries,
}


def span(seconds):
    for unit, length in (("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"


def table(lines):
    """Lines of Markdown; the raw lines are those of `reduce_against_peers.py`."""
    found = peer_table.latest(lines)
    names = {run["component"] for run in found if run["kind"] == "run" and run["modes"] == MODES and run["component"].startswith(SHAPE)}
    cases = [peer_table.Case(found, name, MODES) for name in names]
    rows = sorted((Row(case) for case in cases if case.of("reduce", 2) and case.factor), key=lambda row: row.dofs)
    if len(rows) < 2:
        yield "not run"
        return
    far = Extrapolated(rows[-2], rows[-1], BEYOND)
    yield "| dofs | | wall | factor and count | modes and attachments | the rest | factorization, TFLOP | factor, GB | largest memory, GB |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for row in [*rows, far]:
        of_them = row.time(FACTORS), row.time(SWEEPS)
        yield (
            f"| {row.dofs:.3g} | {'measured' if row.measured else '**extrapolated**'} | {span(row.wall)} | {span(of_them[0])} | {span(of_them[1])} "
            f"| {span(row.wall - sum(of_them))} | {row.flops / 1e12:.3g} | {row.bytes / 1e9:.3g} | {row.peak:.3g} |"
        )
    yield ""
    powers = ", ".join(f"{name} {power:.2f}" for name, power in far.powers.items())
    yield (
        f"The last row was not run. It takes the powers of the dofs between the two largest measured rows ({powers}) and the time of each operation, byte and entry of the "
        "largest one; the memory beside the factor grows with the stiffness."
    )
    machines = {(line["machine"]["cpu"], line["machine"]["cores"], line["machine"]["memory_gb"]) for line in found if line["kind"] == "run" and line["component"] in names}
    yield "Machine: " + "; ".join(f"{cpu}, {cores} cores, {memory} GB" for cpu, cores, memory in sorted(machines)) + "."
