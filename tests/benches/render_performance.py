"""Renders the tables of docs/performance.md from the raw lines in docs/data.

    python3 tests/benches/render_performance.py [--peers FILE]

`--peers` renders the comparison with the best solvers alone, from other raw lines.
"""
import argparse
import json
import os
from statistics import median

import chain_table
import cost_by_size
import parallel_efficiency
import peer_table

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "data")


def lines(name):
    with open(os.path.join(DATA, name)) as file:
        return [json.loads(line) for line in file if line.strip()]


def best_solvers(path=None):
    path = path or os.path.join(DATA, "reduce_against_peers.jsonl")
    if not os.path.exists(path):
        yield "not run"
        return
    yield from peer_table.tables(lines(path))


def with_bounds():
    """What the bounds of the file's errors cost, and what is left of the lead over a solver that has none."""
    found = peer_table.latest(lines("reduce_against_peers.jsonl"))
    everything = [line for line in found if line["kind"] == "run"]
    have = {(run["component"], run["modes"]) for run in everything if run["tool"] == "reduce-bounds"}
    runs = [run for run in everything if (run["component"], run["modes"]) in have]
    yield "| part | modes | `reduce --without-estimate`, s | `reduce`, s | of it the estimate, s | peak MB, without / with | PARDISO, s | PARDISO / without | PARDISO / with | wanted: ≥ 2.5 |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    for component, modes in sorted({(run["component"], run["modes"]) for run in runs}, key=peer_table.places):
        case = peer_table.Case(found, component, modes)
        threads = max(case.threads())
        without, with_them, theirs = (case.wall(tool, threads) for tool in ("reduce", "reduce-bounds", "pardiso2"))
        estimates = [run["stages"]["estimate"] for run in case.of("reduce-bounds", threads)]
        peers = case.of("pardiso2", threads)
        lead, lead_with = (peer_table.by_rounds(peers, case.of(tool, threads)) for tool in ("reduce", "reduce-bounds"))
        yield (
            f"| {component} | {modes} | {peer_table.number(without)} | {peer_table.number(with_them)} | {peer_table.number(median(estimates) if estimates else None)} "
            f"| {case.peak('reduce', threads) or 0:.0f} / {case.peak('reduce-bounds', threads) or 0:.0f} | {peer_table.number(theirs)} | {peer_table.number(lead)} | {peer_table.number(lead_with)} "
            f"| {peer_table.verdict(lead_with >= 2.5 if lead_with else None)} |"
        )
    yield ""
    yield from peer_table.provenance(runs)


def beside_pardiso(name):
    """The job on another machine: ours and the solver that was the best."""
    found = peer_table.latest(lines(name))
    runs = [line for line in found if line["kind"] == "run" and line["tool"] in ("reduce", "reduce-bounds", "pardiso2") and line["threads"] == 2]
    yield "| part | modes | `reduce`, s, median (min–max) | with error bounds, s | PARDISO, s | PARDISO / ours | PARDISO / with bounds | peak MB, ours / PARDISO | order | factor | modes | attachments |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    cases = peer_table.cases(found)
    for (component, modes), case in cases.items():
        ours, theirs = case.of("reduce", 2), [run for run in case.all_runs if (run["tool"], run["threads"]) == ("pardiso2", 2)]
        with_bounds = case.wall("reduce-bounds", 2)
        other = median(run["wall"] for run in theirs) if theirs else None
        stages = " | ".join(peer_table.number(median(run["stages"][name] for run in ours)) for name in ("order", "factor", "modes", "attachments"))
        note = " (once)" if len(theirs) == 1 else ""
        if theirs and not case.of("pardiso2", 2):
            note += f" (modes refused: residual {max(run['check']['mode_residual'] for run in theirs):.0e})"
        leads = " | ".join(peer_table.number(peer_table.by_rounds(theirs, mine)) for mine in (ours, case.of("reduce-bounds", 2)))
        peak = max((run["peak_mb"] for run in theirs), default=None)
        yield (
            f"| {component} | {modes} | {peer_table.spread([run['wall'] for run in ours])} | {peer_table.number(with_bounds)} | {peer_table.number(other)}{note} | {leads} "
            f"| {case.peak('reduce', 2):.0f} / {f'{peak:.0f}' if peak else '–'} | {stages} |"
        )
    yield ""
    limits = cases["conrod-150k", 30]
    yield from (row for row in peer_table.targets(cases) if "not run" not in row)
    yield ""
    yield f"Two threads; dgemm {peer_table.number(limits.limit('dgemm', 2))} GFLOP/s, triad {peer_table.number(limits.limit('bandwidth', 2))} GB/s."
    yield from peer_table.provenance(runs)


def reduction():
    rows = lines("reduce_against_scipy.jsonl")
    runs = [row for row in rows if row["kind"] == "run"]
    yield "| threads | tool | wall s, median (min–max) | peak MB | mode residual | attachments | ratio to ours |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for summary in (row for row in rows if row["kind"] == "summary"):
        same = [r for r in runs if r["threads"] == summary["threads"] and r["refinement"] == summary["refinement"]]
        for tool, label in (("ours", "`reduce`"), ("scipy", "SciPy `eigsh` + SuperLU")):
            walls = sorted(r[tool]["wall"] for r in same)
            attachments = (
                f"Eq. 32: {max(r[tool]['flexibility_identity'] for r in same):.0e}"
                if tool == "ours"
                else f"residual {max(r[tool]['attachment_residual'] for r in same):.0e}"
            )
            ratio = "1" if tool == "ours" else f"{summary['speedup_median']} ({summary['speedup_min']}–{summary['speedup_max']})"
            yield (
                f"| {summary['threads']} | {label} | {walls[len(walls) // 2]:.1f} ({walls[0]:.1f}–{walls[-1]:.1f}) "
                f"| {max(r[tool]['peak_mb'] for r in same)} | {max(r[tool]['mode_residual'] for r in same):.0e} | {attachments} | {ratio} |"
            )
    yield ""
    agreement = max(r["frequency_difference"] for r in runs), max(r["flexibility_difference"] for r in runs)
    yield f"Largest difference between the two: frequencies {agreement[0]:.0e}, F_res {agreement[1]:.0e} of its largest entry."
    yield ""
    yield "| threads | stages of `reduce`, s (last round) | stages of SciPy, s (last round) |"
    yield "| --- | --- | --- |"
    last = {r["threads"]: r for r in runs}
    for threads, run in sorted(last.items()):
        stages = [", ".join(f"{k} {v:.2f}" for k, v in run[tool]["stages"].items()) for tool in ("ours", "scipy")]
        yield f"| {threads} | {stages[0]} | {stages[1]} |"
    yield ""
    where = rows[0]["machine"]
    yield f"Machine: {where['cpu']}, {where['cores']} cores; Python {where['python']}, numpy {where['numpy']}, SciPy {where['scipy']}; commit {where['commit']}."


def reading():
    yield "| file MB | rounds | load | ours to CSC with SHA-256, s | `fmm.mmread`, s | with `.tocsc()`, s | ours / mmread | ours / mmread + tocsc |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for row in lines("read_matrix.jsonl"):
        yield (
            f"| {row['file_mb']:.0f} | {row['rounds']} | {row['load_average']} | {row['ours_to_csc_with_sha256_s']:.3f} | {row['fmm_mmread_s']:.3f} "
            f"| {row['fmm_mmread_tocsc_s']:.3f} | {row['ratio_to_mmread']:.2f} | {row['ratio_to_mmread_tocsc']:.2f} |"
        )


def chains():
    name = "simulate_against_exudyn.jsonl"
    if not os.path.exists(os.path.join(DATA, name)):
        yield "not run"
        return
    runs = lines(name)
    yield "Generated connecting rods of 9918 dofs hang on each other by revolute joints, the first on the ground, and are released from a straight"
    yield "horizontal line. Both codes integrate the same reduced coordinates of the same matrices (a row with n coordinates has n - 12 modes and 12"
    yield "orthonormalized attachments; with 8 it is 2 and 6) with the same averaged interfaces and 3 % damping of every coordinate: generalized alpha,"
    yield "ρ∞ = 0.8, 1000 steps of 1e-4 s, one thread, no output files; the time loop alone is timed. `MarkerSuperElementRigid` visits every node of an"
    yield "interface in each iteration, so most rows average 8 nodes of a bore, where Exudyn is fastest; the others average whole bores."
    yield ""
    yield "µs per step by the clock / of the processor, medians (Newton iterations, Jacobian updates per step). Exudyn's modified Newton takes a new Jacobian above a contractivity"
    yield "of 0.5 (its default) or 0.03. Ratio: Exudyn's fastest setting / ours, within a round. Difference: of the free end, relative to the distance it moves."
    yield ""
    yield from chain_table.speed(runs)
    yield ""
    yield "Largest distance of the free end from a reference, relative to the distance it moves; a rod of a ten-thousandth of steel's stiffness."
    yield ""
    yield from chain_table.accuracy(runs)
    yield ""
    where = runs[0]["machine"]
    versions = ", ".join(sorted({f"{run['tool']} {run['version']}" for run in runs}))
    yield f"Machine: {where['cpu']}, {where['cores']} cores; Python {where['python']}; {versions}; commit {runs[0]['commit']}."


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", metavar="FILE")
    options = parser.parse_args()
    print("### Reduction against the best solvers\n")
    print("\n".join(best_solvers(options.peers)))
    if options.peers:
        raise SystemExit
    print("\n### On a machine with AVX-512\n")
    print("\n".join(beside_pardiso("reduce_on_avx512.jsonl")))
    print("\n### What a reduction costs by size\n")
    print("\n".join(cost_by_size.table(lines("reduce_against_peers.jsonl"))))
    print("\n### Threads\n")
    print("\n".join(parallel_efficiency.table(lines("reduce_against_peers.jsonl"))))
    print("\n### With bounds of the errors\n")
    print("\n".join(with_bounds()))
    print()
    print("### Reduction against SciPy\n")
    print("\n".join(reduction()))
    print("\n### Reading Matrix Market files\n")
    print("\n".join(reading()))
    print("\n### Chains of flexible bodies against Exudyn\n")
    print("\n".join(chains()))
