"""Tables of `reduce_against_peers.py` from its raw lines: a row per tool and part, then the targets."""
import math
import os
import sys
from statistics import median

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))

import judgement  # noqa: E402

SOLVERS = ("cholmod-amd", "cholmod-metis", "cholmod-nesdis", "pardiso2", "mumps-metis")
LABELS = {
    "reduce": "`reduce`", "reduce-bounds": "`reduce` with error bounds", "cholmod-amd": "CHOLMOD AMD", "cholmod-metis": "CHOLMOD METIS", "cholmod-nesdis": "CHOLMOD NESDIS",
    "pardiso2": "PARDISO", "mumps-metis": "MUMPS METIS", "slepc-mumps": "SLEPc + MUMPS, modes alone", "slepc-mumps-mpi": "SLEPc + MUMPS, a process each, modes alone",
    "exudyn": "Exudyn, modes alone",
}
COMPONENTS = ("conrod-10k", "conrod-50k", "conrod-150k", "block-150k", "plate-150k", "conrod-400k", "conrod-1M")
SLEPC = ("slepc-mumps", "slepc-mumps-mpi")
SHAPES = {"conrod": "slender", "block": "compact", "plate": "thin"}
STAGES = ("read", "order", "factor", "modes", "attachments")
TOGETHER = ("factor_with_order", 2, "with order"), ("modes_with_factor", 3, "with factor")  # stages that can't be told apart
BLOCK = 8  # columns of a block in `reduce`


def latest(lines):
    """Per part and number of modes the lines of the last commit that was measured; limits and factors of those commits."""
    last = {(line["component"], line["modes"]): key(line) for line in lines if line["kind"] == "run"}
    kept = [line for line in lines if line["kind"] == "run" and key(line) == last[line["component"], line["modes"]]]
    return [line for line in lines if line["kind"] != "run" and key(line) in last.values()] + kept


def key(line):
    return line["commit"], line["machine"]["cpu"], line["machine"]["cores"]


class Case:
    """Runs of one part with one number of modes, and what the machine could do in the same run."""

    def __init__(self, lines, component, modes):
        everything = [line for line in lines if line["kind"] == "run" and (line["component"], line["modes"]) == (component, modes)]
        self.component, self.modes = component, modes
        self.all_runs = everything
        self.runs = [run for run in everything if judgement.counts(run)]
        commits = {key(run) for run in everything}
        self.limit_lines = [line for line in lines if line["kind"] == "limit" and key(line) in commits]
        factors = [line for line in lines if line["kind"] == "factor" and line["component"] == component]
        self.factor = factors[-1] if factors else None
        self.dofs = everything[0]["dofs"] if everything else None
        self.reference = judgement.reference_values([run["eigenvalues"] for run in self.runs])

    def of(self, tool, threads=None):
        return [run for run in self.runs if run["tool"] == tool and threads in (None, run["threads"])]

    def threads(self):
        return sorted({run["threads"] for run in self.all_runs})

    def limit(self, what, threads):
        """The best that was measured, GFLOP/s or GB/s."""
        found = [line["best"] for line in self.limit_lines if (line["limit"], line["threads"]) == (what, threads)]
        return max(found) if found else None

    def missed(self, runs):
        return max(judgement.modes_missed(run["eigenvalues"], self.reference, self.modes) for run in runs)

    def wall(self, tool, threads):
        runs = self.of(tool, threads)
        return median(run["wall"] for run in runs) if runs else None

    def fastest(self, tools):
        """(seconds, tool, threads) of the best tool, or None."""
        found = [(self.wall(tool, threads), tool, threads) for tool in tools for threads in self.threads() if self.of(tool, threads)]
        return min(found) if found else None

    def lead(self, tools, mine):
        """(how many times as long as `mine` of our runs, tool, threads) of the best tool: the median over the rounds that both ran in, because the machine's
        speed changes from round to round; None if no round has both. Ours is at the number of threads that is fastest."""
        _, _, fast = self.fastest(["reduce"]) or (None, None, None)
        ours = self.of("reduce", fast) if fast else []
        found = [(by_rounds(self.of(tool, threads), ours, mine), tool, threads) for tool in tools for threads in self.threads()]
        return min((lead for lead in found if lead[0]), default=None)

    def peak(self, tool, threads=None):
        runs = self.of(tool, threads)
        return max(run["peak_mb"] for run in runs) if runs else None


def by_rounds(theirs, ours, mine=lambda run: run["wall"]):
    """How many times as long as `mine` of our runs theirs take: the median over the rounds that have both; None if none has."""
    seconds = {run["round"]: mine(run) for run in ours}
    ratios = [run["wall"] / seconds[run["round"]] for run in theirs if run["round"] in seconds]
    return median(ratios) if ratios else None


def plural(threads):
    return f"{threads} thread{'s'[: threads > 1]}"


def stage(run, name):
    return run["stages"].get(name)


def rest(run):
    known = [run["stages"][name] for name in STAGES if name in run["stages"]]
    return run["wall"] - sum(known) if len(known) == len(STAGES) else None


def work(run, factor):
    """(passes over the factor, entries of the factor, flops of the factorization) of a run; None where unknown.

    A pass is one forward and one backward sweep for one block of columns. Entries and flops are METIS's as CHOLMOD counts them, or the tool's
    own if they are fewer. Where `reduce` doesn't tell its passes, they follow from its iterations: block steps of Lanczos, and
    iterations of the attachments in blocks of eight columns."""
    told = run.get("work") or {}
    passes = told.get("solve_passes")
    if passes is None and run.get("iterations"):
        steps, iterations = run["iterations"][:2]
        passes = steps + iterations * math.ceil(run["check"]["attachments"] / BLOCK)
    sources = [source for source in (factor, told) if source]
    entries = [source["factor_entries"] for source in sources if source.get("factor_entries")]
    flops = [source["factor_flops"] for source in sources if source.get("factor_flops")]
    return passes, min(entries, default=None), min(flops, default=None)


def traffic(run, factor):
    """GB that the solves of a run read of the factor."""
    passes, entries, _ = work(run, factor)
    return None if passes is None or entries is None else 2 * 8e-9 * passes * entries


def machine_limit(case, run):
    """Seconds: the factorization at dgemm's speed, and the traffic of the solves at the measured bandwidth."""
    compute, bandwidth = case.limit("dgemm", run["threads"]), case.limit("bandwidth", run["threads"])
    _, _, flops = work(run, case.factor)
    moved = traffic(run, case.factor)
    if None in (compute, bandwidth, flops, moved):
        return None
    return flops / compute / 1e9 + moved / bandwidth


def number(value, digits=3):
    """Three significant digits, without an exponent."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    return f"{value:.{max(0, digits - 1 - math.floor(math.log10(abs(value))))}f}"


def scientific(value):
    return "–" if value is None else f"{value:.0e}"


def percent(value):
    return "–" if value is None else f"{100 * value:.0f} %"


def spread(values):
    values = sorted(values)
    return number(median(values)) + (f" ({number(values[0])}–{number(values[-1])})" if len(values) > 1 else " (once)")


def middle(runs, function):
    found = [function(run) for run in runs]
    return None if not found or None in found else median(found)


def worst(runs, name):
    found = [run["check"].get(name) for run in runs]
    return None if None in found else max(found)


def row(case, tool, threads):
    runs = case.of(tool, threads)
    if not runs:
        rejected = [run for run in case.all_runs if (run["tool"], run["threads"]) == (tool, threads)]
        return f"| {threads} | {LABELS[tool]} | {why_not(rejected)} |" + " |" * 16
    stages = [number(middle(runs, lambda run, name=name: stage(run, name))) for name in STAGES] + [number(middle(runs, rest))]
    for together, place, note in TOGETHER:
        if together in runs[0]["stages"]:
            stages[place] = f"{number(middle(runs, lambda run: stage(run, together)))} ({note})"
    flops = case.factor["factor_flops"] if case.factor else None
    speed = middle(runs, lambda run: flops and stage(run, "factor") and flops / stage(run, "factor") / 1e9)
    compute, bandwidth = case.limit("dgemm", threads), case.limit("bandwidth", threads)

    def solve_speed(run):
        moved = traffic(run, case.factor)
        seconds = sum(stage(run, name) or math.nan for name in ("modes", "attachments"))
        return moved and moved / seconds

    moved = middle(runs, solve_speed) if tool not in judgement.MODES_ONLY else None
    cells = [
        str(threads), LABELS[tool], spread([run["wall"] for run in runs]), *stages,
        number(max(run["peak_mb"] for run in runs), 4), scientific(worst(runs, "mode_residual")),
        scientific(worst(runs, "attachment_residual")), str(case.missed(runs)), number(speed),
        percent(speed and compute and speed / compute), number(moved), percent(moved and bandwidth and moved / bandwidth),
        against_ours(case, runs, tool, threads), number(max(run["others"] for run in runs)),
    ]
    return f"| {' | '.join(cells)} |"


def why_not(rejected):
    if not rejected:
        return "not run"
    if reasons := [run["failed"] for run in rejected if "failed" in run]:
        text = " ".join(reasons[-1].split())[-80:].replace("|", "/").replace("<", "(").replace(">", ")")
        return f"failed: {text}"
    return "doesn't count: " + ", ".join(judgement.failures(rejected[-1]))


def comparable(run, tool):
    """What of our run does the work of another tool's: all of it, or order, factor and modes."""
    if tool in SLEPC:
        return sum(run["stages"].get(name, 0) for name in ("order", "factor", "modes"))
    return run["wall"]


def against_ours(case, runs, tool, threads):
    ours = case.of("reduce", threads)
    if tool == "reduce" or not ours:
        return "1" if tool == "reduce" else "–"
    return number(median(run["wall"] for run in runs) / median(comparable(run, tool) for run in ours))


def part_table(case):
    shape = SHAPES.get(case.component.partition("-")[0], "")
    facts = [f"**{case.component}** ({shape}): {case.dofs} dofs, {case.modes} modes"]
    if case.factor:
        facts.append(
            f"stiffness {case.factor['entries'] / 1e6:.2f} million entries, METIS's factor {case.factor['factor_entries'] / 1e6:.2f} million and "
            f"{number(case.factor['factor_flops'] / 1e9)} GFLOP"
        )
    for threads in case.threads():
        compute, bandwidth = case.limit("dgemm", threads), case.limit("bandwidth", threads)
        if compute and bandwidth:
            facts.append(f"{plural(threads)}: dgemm {number(compute)} GFLOP/s, triad {number(bandwidth)} GB/s")
    yield "; ".join(facts) + "."
    yield ""
    yield (
        "| threads | tool | wall s, median (min–max) | read | order | factor | modes | attachments | rest | peak MB | mode residual | attachment residual "
        "| modes missed | factor GFLOP/s | of dgemm | solves GB/s | of triad | time / ours | others |"
    )
    yield "| " + " | ".join(["---"] * 19) + " |"
    for threads in case.threads():
        for tool in LABELS:
            if tool not in ("reduce-bounds", "exudyn", "slepc-mumps-mpi") or any((run["tool"], run["threads"]) == (tool, threads) for run in case.all_runs):
                yield row(case, tool, threads)


def exponent(small, large, value):
    """Of the growth with the number of dofs."""
    if None in (value(small), value(large)):
        return None
    return math.log(value(large) / value(small)) / math.log(large.dofs / small.dofs)


def verdict(met):
    return "–" if met is None else "met" if met else "**missed**"


def target(what, wanted, measured, met, how=""):
    return f"| {what} | {wanted} | {'not run' if met is None else measured}{how if met is not None else ''} | {verdict(met)} |"


def rejected_solver(case):
    """(seconds, tool, what its check failed) of the fastest solver whose runs don't count, or None."""
    found = []
    for tool in SOLVERS:
        runs = [run for run in case.all_runs if run["tool"] == tool and "failed" not in run]
        if runs:
            found.append((median(run["wall"] for run in runs), tool, max(run["peak_mb"] for run in runs), judgement.failures(runs[-1])))
    return min(found, default=None)


def job_targets(case, wanted):
    """Time and memory against the best direct solver at any number of threads; where none passes its check, against the fastest that doesn't."""
    ours, peer = case.fastest(["reduce"]), case.lead(SOLVERS, lambda run: run["wall"])
    what = f"{case.component}, {case.modes} modes: job against the best solver"
    memory = f"{case.component}, {case.modes} modes: peak memory below the solvers'"
    rejected = rejected_solver(case) if peer is None else None
    if ours is None or (peer is None and rejected is None):
        yield target(what, f"≥ {wanted}", "", None)
        yield target(memory, "< 1", "", None)
        return
    if rejected:
        seconds, tool, least, failures = rejected
        theirs = f"{LABELS[tool]}, {number(seconds)} s (no solver's result counts: {', '.join(failures)})"
        ratio = seconds / ours[0]
    else:
        ratio, tool, threads = peer
        theirs = f"{LABELS[tool]}, {plural(threads)}, {number(case.wall(tool, threads))} s"
        least, tool = min((case.peak(tool), tool) for tool in SOLVERS if case.of(tool))
    how = f": {theirs}; ours, {plural(ours[2])}, {number(ours[0])} s"
    yield target(what, f"≥ {wanted}", number(ratio), ratio >= wanted, how)
    share = case.peak("reduce") / least
    how = f": ours {case.peak('reduce'):.0f} MB, {LABELS[tool]} {least:.0f} MB"
    yield target(memory, "< 1", number(share), share < 1, how)


def modes_alone_target(case, tools, wanted, what):
    """Against tools that compute modes alone: our order, factor and modes (SLEPc), or our whole job (Exudyn)."""
    mine = lambda run: comparable(run, tools[0])
    lead = case.lead(tools, mine)
    if lead is None:
        return target(what, f"≥ {wanted}", "", None)
    ratio, tool, threads = lead
    _, _, fast = case.fastest(["reduce"])
    seconds = median(mine(run) for run in case.of("reduce", fast))
    how = f": {number(case.wall(tool, threads))} s, {plural(threads)}; ours {number(seconds)} s, {plural(fast)}"
    return target(what, f"≥ {wanted}", number(ratio), ratio >= wanted, how)


def targets(cases):
    """cases: by (component, modes); missing ones are not run."""

    def case(component, modes=30):
        return cases.get((component, modes)) or Case([], component, modes)

    yield "| target | wanted | measured | |"
    yield "| --- | --- | --- | --- |"
    for component in ("conrod-50k", "conrod-150k", "conrod-400k", "block-150k", "plate-150k"):
        yield from job_targets(case(component), 3)
    for component in ("conrod-150k", "conrod-400k"):
        what = f"{component}, 30 modes: eigenpairs alone (order, factor, modes) against SLEPc + MUMPS"
        yield modes_alone_target(case(component), SLEPC, 2, what)
    for component in ("conrod-150k", "conrod-400k"):
        yield from job_targets(case(component, 100), 4)
    for component in ("conrod-10k", "conrod-50k"):
        what = f"{component}, 30 modes: whole job against Exudyn's mode computation alone"
        yield modes_alone_target(case(component), ["exudyn"], 8, what)
    tiny = case("conrod-10k").fastest(["reduce"])
    yield target("conrod-10k, 30 modes: whole job", "≤ 0.2 s", f"{number(tiny[0] if tiny else None)} s", None if tiny is None else tiny[0] <= 0.2)
    small, large = case("conrod-50k"), case("conrod-400k")
    for threads in sorted(set(small.threads()) & set(large.threads())) or [None]:
        for what, value in (
            ("time", lambda one: one.wall("reduce", threads)), ("memory", lambda one: one.peak("reduce", threads)),
        ):
            power = exponent(small, large, value)
            label = f"growth of {what} from 50k to 400k dofs" + (f", {plural(threads)}" if threads else "")
            yield target(label + ": exponent", "≤ 1.35", f"{power or 0:.2f}", None if power is None else power <= 1.35)
    for threads in large.threads() or [None]:
        runs = large.of("reduce", threads)
        bound = middle(runs, lambda run: machine_limit(large, run))
        share = bound and large.wall("reduce", threads) / bound
        label = "conrod-400k, 30 modes: job against the machine's limit" + (f", {plural(threads)}" if threads else "")
        yield target(label, "≤ 3.5", number(share), None if share is None else share <= 3.5, f": limit {number(bound)} s")
    million = case("conrod-1M")
    runs, tried = million.of("reduce"), [run for run in million.all_runs if run["tool"] == "reduce"]
    measured = f"{million.fastest(['reduce'])[0]:.0f} s, {million.peak('reduce'):.0f} MB" if runs else f"{why_not(tried)}"
    yield target("conrod-1M, 30 modes: finishes, checked", "yes", measured, bool(runs) if tried else None)


def places(case):
    order = COMPONENTS.index(case[0]) if case[0] in COMPONENTS else len(COMPONENTS)
    return order, case


def provenance(runs):
    """Machines, versions and commits of the runs."""
    for machine in sorted({(run["machine"]["cpu"], run["machine"]["cores"], run["machine"]["memory_gb"]) for run in runs}):
        yield f"Machine: {machine[0]}, {machine[1]} cores, {machine[2]} GB."
    versions = sorted({f"{name} {version}" for run in runs for name, version in (run.get("versions") or {}).items() if name != "reduce"})
    cores = sorted({run["openblas_core"] for run in runs if run.get("openblas_core")})
    yield (
        f"Python {', '.join(sorted({run['machine']['python'] for run in runs}))}; {', '.join(versions)}"
        + (f"; OPENBLAS_CORETYPE {', '.join(cores)}" if cores else "")
        + f"; `reduce` of commit {', '.join(sorted({run['commit'] for run in runs}))}"
        + (", or so it was said: the program was given." if any(run.get("program_given") for run in runs) else ".")
    )


def cases(lines):
    """By component and number of modes, in the order of the tables."""
    names = {(line["component"], line["modes"]) for line in lines if line["kind"] == "run"}
    return {name: Case(lines, *name) for name in sorted(names, key=places)}


def tables(lines):
    lines = latest(lines)
    runs = [line for line in lines if line["kind"] == "run"]
    by_name = cases(lines)
    yield from targets(by_name)
    for case in by_name.values():
        yield ""
        yield from part_table(case)
    if runs:
        yield ""
        yield from provenance(runs)
