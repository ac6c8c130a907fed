"""How much of a second thread each stage of a reduction uses, and what sixteen would do by Amdahl's law. Used by `render_performance.py`."""
from statistics import median

import peer_table

COMPONENTS = ("conrod-150k", "block-150k", "conrod-400k")
MODES = 30
MANY = 16


def amdahl(one, two, threads):
    """Time with some threads, from those with one and two: the part that doesn't get faster stays."""
    serial = min(max(2 * two / one - 1, 0.0), 1.0) if one > 0 else 0.0
    return one * (serial + (1 - serial) / threads)


def table(lines):
    """Lines of Markdown; the raw lines are those of `reduce_against_peers.py`."""
    found = peer_table.latest(lines)
    yield f"| part | stage | 1 thread, s | 2 threads, s | efficiency | {MANY} threads by Amdahl's law, s |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for component in COMPONENTS:
        case = peer_table.Case(found, component, MODES)
        runs = {threads: case.of("reduce", threads) for threads in (1, 2)}
        if not all(runs.values()):
            yield f"| {component} | not run with both | | | | |"
            continue
        middle = lambda threads, get: median(get(run) for run in runs[threads])
        total = [0.0, 0.0, 0.0]
        names = list(runs[2][0]["stages"])
        for name in names:
            times = [middle(threads, lambda run: run["stages"].get(name, 0.0)) for threads in (1, 2)]
            times.append(amdahl(*times, MANY))
            total = [sum(pair) for pair in zip(total, times)]
            if times[0] >= 0.1:
                yield row(component, name, times)
        yield row(component, "**all**", total)


def row(component, name, times):
    one, two, many = times
    return f"| {component} | {name} | {one:.2f} | {two:.2f} | {100 * one / (2 * two):.0f} % | {many:.2f} |"
