"""Tables of the chain benchmark from its raw lines (`simulate_against_exudyn.py`)."""
import math
from statistics import median

PEERS = ("modified", "eager", "full")


def grouped(runs):
    """Runs by case, in the order of the lines."""
    cases = {}
    for run in runs:
        cases.setdefault(run["case"], []).append(run)
    return cases.values()


def of(runs, tool, newton="", finest=False):
    """A tool's runs with the step of the comparison, or with the finest one."""
    step = (min if finest else max)(run["step"] for run in runs)
    return [run for run in runs if run["tool"] == tool and run["newton"] == newton and run["step"] == step]


def microseconds(runs):
    return median(run["seconds"] / run["steps"] for run in runs) * 1e6


def cell(runs):
    """Time by the clock and, where known, of the processor, Newton iterations and Jacobian updates a step."""
    if not runs:
        return "–"
    steps = runs[0]["steps"]
    used = [run["cpu_seconds"] / steps * 1e6 for run in runs if "cpu_seconds" in run]
    digits = 1 if microseconds(runs) < 100 else 0
    times = f"{microseconds(runs):.{digits}f}" + (f" / {median(used):.{digits}f}" if used else "")
    return f"{times} ({runs[0]['newton_iterations'] / steps:.2f}, {runs[0]['jacobian_updates'] / steps:.3f})"


def difference(one, other):
    """Largest distance between two histories of the tip, relative to the distance it moved. None where a run is missing."""
    if not one or not other:
        return None
    here, there = one[0], other[0]
    if len(here["time"]) != len(there["time"]) or any(abs(a - b) > 1e-9 for a, b in zip(here["time"], there["time"])):
        raise ValueError(f"{here['case']}: the runs were recorded at different times")
    moved = max(math.dist(position, here["position"][0]) for position in here["position"])
    return max(math.dist(a, b) for a, b in zip(here["position"], there["position"])) / moved


def scientific(number):
    return "–" if number is None else f"{number:.0e}"


def ratio(runs):
    """Exudyn's faster setting against ours, round by round: median (least–largest)."""
    rounds = {run["round"]: run["seconds"] for run in of(runs, "simulate")}
    if not rounds:
        return "–"
    fastest = min(
        (of(runs, "exudyn", newton) for newton in PEERS if of(runs, "exudyn", newton)), key=microseconds
    )
    ratios = sorted(run["seconds"] / rounds[run["round"]] for run in fastest)
    return f"{median(ratios):.1f} ({ratios[0]:.1f}–{ratios[-1]:.1f})"


def speed(runs):
    """µs a step by the clock / of the processor (Newton iterations, Jacobian updates a step), and how far the answers differ."""
    yield "| bodies × coordinates | nodes per interface | Exudyn, modified Newton | … new Jacobian sooner | … full Newton | `simulate` | ratio | difference | load |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for same in grouped(run for run in runs if run["stiffness_factor"] == 1):
        peers = [of(same, "exudyn", newton) for newton in PEERS]
        ours = of(same, "simulate")
        nodes = " and ".join(str(count) for count in sorted(set(peers[0][0]["interface_nodes"])))
        loads = sorted(run["load"] for run in same)
        yield (
            f"| {same[0]['bodies']} × {same[0]['coordinates']} | {nodes} | {' | '.join(cell(peer) for peer in peers)} | {cell(ours)} "
            f"| {ratio(same)} | {scientific(difference(ours, peers[0]))} | {loads[0]:.1f}–{loads[-1]:.1f} |"
        )


def accuracy(runs):
    """Distance of each tool's answer from the answers with a finer step, with a soft part."""
    yield "| bodies × coordinates | answer | from Exudyn with the finer step | from `simulate` with the finer step |"
    yield "| --- | --- | --- | --- |"
    for same in grouped(run for run in runs if run["stiffness_factor"] != 1):
        references = of(same, "exudyn", "modified", finest=True), of(same, "simulate", finest=True)
        for label, tool, newton in (("Exudyn", "exudyn", "modified"), ("`simulate`", "simulate", "")):
            for finest in (False, True):
                answer = of(same, tool, newton, finest)
                if answer:
                    cells = ("itself" if answer == reference else scientific(difference(answer, reference)) for reference in references)
                    yield (
                        f"| {same[0]['bodies']} × {same[0]['coordinates']} | {label}, step {answer[0]['step']:.0e} s | {' | '.join(cells)} |"
                    )
