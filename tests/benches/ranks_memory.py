"""Memory of each process and time of a reduction with the factor in memory, on disk, and on 1, 2 and 4 ranks of this machine.

    python3 tests/benches/ranks_memory.py [--components conrod-50k,conrod-150k] [--rounds 1] [--data FOLDER] [--write [FILE]]
    python3 tests/benches/ranks_memory.py --render

Components are those of `peers/components.py`, generated into the data folder where missing. `reduce` runs with two threads, each rank with one BLAS
thread; no error estimate is made. Resident memory of `reduce` is the largest that the system saw; of that, pages of files (a factor on disk is one) can be dropped by the system, so
the largest anonymous part is sampled beside it, every 20 ms. Peaks of ranks are what they report themselves at the end (`--timings`). Times are sums of the
stages. `--write` appends one JSON line a run to docs/data/ranks_memory.jsonl, or FILE; `--render` writes the table of the last runs into docs/ranks.md.

Needs `cargo build --release -p dcb-programs --features ranks`, Open MPI; for components gmsh, numpy, scipy, fast_matrix_market.
"""
import argparse
import datetime
import json
import os
import platform
import shlex
import subprocess
import sys
import tempfile
import time
from statistics import median

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
LINES = os.path.join(ROOT, "docs", "data", "ranks_memory.jsonl")
PAGE = os.path.join(ROOT, "docs", "ranks.md")
BEGIN, END = "<!-- generated from data/ranks_memory.jsonl -->", "<!-- end of the generated part -->"
PLACES = ("memory", "disk", "1", "2", "4")
MPIRUN = "mpirun --oversubscribe --bind-to none"
TARGETS = {"2": 0.6, "4": 0.35}


def output(*command):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.strip()
    except OSError:
        return ""


def commit():
    sources = ["reducer", "formats", "tests/benches/ranks_memory.py"]
    changed = output("git", "-C", ROOT, "status", "--porcelain", "--", *sources)
    return output("git", "-C", ROOT, "log", "-1", "--format=%h", "--", *sources) + ("+" if changed else "")


def machine():
    with open("/proc/cpuinfo") as lines:
        model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor())
    return dict(processor=model, cores=os.cpu_count(), memory_bytes=os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))


def versions():
    packages = ("libmumps-dev", "openmpi-bin", "libopenblas0-pthread")
    found = {package: output("dpkg-query", "-W", "-f", "${Version}", package) for package in packages}
    found["blas"] = os.path.realpath("/etc/alternatives/libblas.so.3-x86_64-linux-gnu")
    found["kernel"] = platform.release()
    return found


def anonymous(process):
    """Anonymous resident memory of a process now, bytes."""
    try:
        with open(f"/proc/{process}/status") as lines:
            return next((1024 * int(line.split()[1]) for line in lines if line.startswith("RssAnon")), 0)
    except OSError:
        return 0


def run(program, part, place, modes):
    with tempfile.TemporaryDirectory() as folder:
        timings = os.path.join(folder, "times.json")
        command = [program, os.path.join(part, "part.mtx"), "-o", os.path.join(folder, "part.dcb.h5"), "--modes", str(modes), "--timings", timings, "--without-estimate", "--quiet"]
        command += ["--factor", place] if place in ("memory", "disk") else ["--ranks", place, "--mpirun", MPIRUN]
        allowed = dict(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1") if os.geteuid() == 0 else {}
        load, start, largest = os.getloadavg()[0], time.monotonic(), 0
        process = subprocess.Popen(command, env=dict(os.environ, RAYON_NUM_THREADS="2", **allowed), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while process.poll() is None:
            largest = max(largest, anonymous(process.pid))
            time.sleep(0.02)
        line = dict(command=shlex.join(command).replace(folder, "FOLDER").replace(ROOT + "/", ""), status=process.returncode, wall_seconds=time.monotonic() - start)
        line.update(load_before=load, load_after=os.getloadavg()[0])
        if process.returncode != 0:
            return dict(line, failure=process.stderr.read()[-500:])
        with open(timings) as file:
            told = json.load(file)
    return dict(
        line,
        stage_seconds={stage["stage"]: stage["seconds"] for stage in told["stages"]},
        reduce_peak_bytes=round(max(stage["peak_megabytes"] for stage in told["stages"]) * 2**20),
        reduce_anonymous_bytes=largest,
        rank_peak_bytes=told["work"].get("rank_peak_bytes", []),
        factor_bytes=8 * told["work"]["factor_entries"],
        dofs=told["work"]["dofs"],
    )


def measure(options):
    about = dict(bench="ranks_memory", date=datetime.date.today().isoformat(), commit=commit(), machine=machine(), versions=versions())
    for component in options.components.split(","):
        part = os.path.join(options.data, component)
        if not os.path.exists(os.path.join(part, "meta.json")):
            generate = [sys.executable, os.path.join(HERE, "peers", "components.py"), component]
            subprocess.check_call(generate, env=dict(os.environ, PERF_DATA=options.data), stdout=subprocess.DEVNULL)
        for round_number in range(options.rounds):
            for place in PLACES:
                line = dict(about, component=component, modes=options.modes, place=place, round=round_number, **run(options.reduce, part, place, options.modes))
                text = json.dumps(line)
                print(text, flush=True)
                if options.write:
                    with open(options.write, "a") as file:
                        file.write(text + "\n")


def last_runs(path):
    """Component -> place -> its runs of the last commit."""
    with open(path) as file:
        lines = [json.loads(line) for line in file]
    found = {}
    for line in lines:
        runs = found.setdefault(line["component"], {}).setdefault(line["place"], [])
        if runs and runs[-1]["commit"] != line["commit"]:
            runs.clear()
        runs.append(line)
    return found


def table(runs):
    def largest_rank(place):
        good = [run for run in runs.get(place, []) if run["status"] == 0]
        return max((max(run["rank_peak_bytes"]) for run in good if run["rank_peak_bytes"]), default=None)

    one = largest_rank("1")
    for place in PLACES:
        good = [run for run in runs.get(place, []) if run["status"] == 0]
        where = {"memory": "in memory here", "disk": "on disk here"}.get(place, f"{place} rank{'s' * (place != '1')}")
        if not good:
            yield f"| {where} | {'failed' if place in runs else 'not run'} | | | | | |"
            continue
        mega = lambda key: f"{max(run[key] for run in good) / 1e6:.0f}"  # noqa: E731
        seconds = median([sum(run["stage_seconds"].values()) for run in good])
        ranks = ", ".join(f"{size / 1e6:.0f}" for size in good[-1]["rank_peak_bytes"]) or "–"
        share, target = "–", "–"
        if largest_rank(place) and one:
            ratio = largest_rank(place) / one
            share = f"{ratio:.3f}"
            if place in TARGETS:
                target = f"≤ {TARGETS[place]}: {'met' if ratio <= TARGETS[place] else 'missed'}"
        yield f"| {where} | {mega('reduce_peak_bytes')} | {mega('reduce_anonymous_bytes')} | {ranks} | {share} | {target} | {seconds:.1f} |"


def render(path):
    text = []
    for component, runs in last_runs(path).items():
        example = next(iter(runs.values()))[-1]
        good = [run for of in runs.values() for run in of if run["status"] == 0]
        loads = [run["load_before"] for run in good]
        text.append(f"{component}: {good[0]['dofs']} dofs, {example['modes']} modes, factor {good[0]['factor_bytes'] / 1e6:.0f} MB, commit {example['commit']}, {example['date']}; load before the runs {min(loads):.1f} to {max(loads):.1f}")
        text.append("")
        text.append("| factor | `reduce`, MB | anonymous, MB | ranks, MB | largest rank / one rank | target | stages, s |")
        text.append("| --- | --- | --- | --- | --- | --- | --- |")
        text += [*table(runs), ""]
    machine_line, versions_line = example["machine"], example["versions"]
    text.append(f"{machine_line['processor']}, {machine_line['cores']} cores, {machine_line['memory_bytes'] / 1e9:.0f} GB; MUMPS {versions_line['libmumps-dev']}, Open MPI {versions_line['openmpi-bin']}, OpenBLAS {versions_line['libopenblas0-pthread']}.")
    with open(PAGE) as file:
        before, rest = file.read().split(BEGIN)
    after = rest.split(END)[1]
    with open(PAGE, "w") as file:
        file.write(before + BEGIN + "\n" + "\n".join(text) + "\n" + END + after)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--components", default="conrod-50k,conrod-150k")
    parser.add_argument("--modes", type=int, default=30)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--data", default=os.environ.get("PERF_DATA", os.path.join(tempfile.gettempdir(), "perf-data")))
    parser.add_argument("--reduce", default=os.path.join(ROOT, "target", "release", "reduce"))
    parser.add_argument("--write", nargs="?", const=LINES, metavar="FILE")
    parser.add_argument("--render", action="store_true")
    options = parser.parse_args()
    if options.render:
        render(options.write or LINES)
    else:
        measure(options)


main()
