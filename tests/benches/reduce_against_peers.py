"""Reduction against the best direct solvers and eigensolvers on generated parts: interleaved, every result checked, one JSON line per run.

    python3 tests/benches/reduce_against_peers.py [--components conrod-50k,conrod-150k:100,...] [--tools reduce,cholmod-metis,...]
        [--modes 30] [--rounds 3] [--threads 1,2] [--data FOLDER] [--write [FILE]] [--resume]

A component is SHAPE-SIZE[:MODES] (see `peers/components.py`); missing ones are generated into the data folder. Per component, round and
number of threads, `reduce` and the peers run one after the other, each in a fresh process, after the machine has become quiet (or `--quiet-wait`
seconds: what other processes used meanwhile is in the line) and the memory that a run needs was touched once (else the first tool after a pause
pays for what the host of a virtual machine has taken back; `--memory-as-it-is` leaves that out). What the machine can do is measured first, and the part's files are read once.

- reduce: the job that the peers do (`--without-estimate`); reduce-bounds: with the bounds of the file's errors, which is what `reduce` does if nothing
  is said. Wall is that of the whole process. Stages are its own `--timings`.
- cholmod-amd, cholmod-metis, cholmod-nesdis, pardiso2, mumps-metis: `peers/reduction.py`, the same job from the same files to an HDF5 file. Wall is
  without starting Python and importing; `wall_with_start` is with it.
- slepc-mumps, slepc-mumps-mpi, exudyn: eigenpairs alone, without reading or writing; -mpi is one process instead of a thread.

Every result is checked by `peers/check_superelement.py` in a process of its own; runs without a passed check don't count. A tool whose run took
longer than `--once-above` seconds isn't run in later rounds. `--write` appends the lines to docs/data/reduce_against_peers.jsonl, or to FILE;
else they are printed. `--resume` leaves out what the file has for this commit (the last that touched the program or the benches). Tables are printed at the end.

Needs: pip install numpy scipy h5py gmsh fast_matrix_market pypardiso python-mumps exudyn; on Debian libsuitesparse-dev libopenblas-dev
libmumps-seq-dev python3-slepc4py-real gcc. A tool that can't run is recorded as failed.
"""
import argparse
import datetime
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PEERS = os.path.join(HERE, "peers")
LINES = os.path.join(ROOT, "docs", "data", "reduce_against_peers.jsonl")
BENCH = "reduce_against_peers"
SOLVERS = ("cholmod-amd", "cholmod-metis", "cholmod-nesdis", "pardiso2", "mumps-metis")
OURS = ("reduce", "reduce-bounds")
TOOLS = (*OURS, *SOLVERS, "slepc-mumps", "slepc-mumps-mpi", "exudyn")
COMPONENTS = (
    "conrod-10k,conrod-50k,conrod-150k,block-150k,plate-150k,conrod-400k,conrod-150k:100,conrod-400k:100,conrod-1M"
)
BYTES_PER_DOF = 20_000  # more than any tool takes, up to 400k dofs
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def tools_for(component, tools):
    """Exudyn is too slow for large parts; a million dofs leave memory for the two that need least time."""
    size = component.rpartition("-")[2]
    if size not in ("10k", "50k"):
        tools = [tool for tool in tools if tool != "exudyn"]
    if size.endswith("M"):
        tools = [tool for tool in tools if tool in (*OURS, "cholmod-metis", "pardiso2")]
    return tools


def busy_seconds():
    """Processor seconds used on the whole machine."""
    with open("/proc/stat") as file:
        ticks = [int(tick) for tick in file.readline().split()[1:9]]
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def wait_until_quiet(limit, share=0.15):
    """Waits until other processes leave the cores alone, at most `limit` seconds. Returns the seconds waited."""
    start = time.monotonic()
    while time.monotonic() - start < limit:
        before = busy_seconds()
        time.sleep(1)
        if (busy_seconds() - before) / os.cpu_count() < share:
            break
    return round(time.monotonic() - start, 1)


def fetch_memory(size):
    """Touches so many bytes in a process of its own and gives them back, so that the next process finds memory that the host of a virtual
    machine has not taken away. Returns the seconds that took."""
    program = (
        "import mmap, sys\n"
        "room = mmap.mmap(-1, int(sys.argv[1]), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)\n"
        "room.madvise(mmap.MADV_HUGEPAGE)\n"
        "for page in range(0, len(room), mmap.PAGESIZE): room[page] = 1"
    )
    start = time.monotonic()
    subprocess.run([sys.executable, "-c", program, str(size)], check=True)
    return round(time.monotonic() - start, 1)


def first_to_be_killed():
    """If memory runs out, this process goes and nobody else's."""
    with open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


def end(group):
    """Ends the process group that a run started. mpiexec needs the first signal to end its processes."""
    try:
        os.killpg(group, signal.SIGTERM)
        time.sleep(5)
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        pass


def environment(threads):
    found = dict(os.environ) | {name: str(threads) for name in THREAD_VARIABLES}
    if os.getuid() == 0:  # Open MPI asks for these in a container
        found |= dict(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    with open("/proc/cpuinfo") as file:
        if "avx512f" in file.read():  # OpenBLAS doesn't know every processor that has these instructions
            found.setdefault("OPENBLAS_CORETYPE", "SkylakeX")
    return found


class Bench:
    def __init__(self, options):
        self.options = options
        self.lines_file = options.write
        self.started = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        self.machine, self.commit = machine(), commit()
        self.lines = []
        if self.lines_file and os.path.exists(self.lines_file):
            with open(self.lines_file) as file:
                self.lines = [json.loads(line) for line in file if line.strip()]

    def add(self, **line):
        line = dict(bench=BENCH, **line, started=self.started, commit=self.commit, machine=self.machine)
        self.lines.append(line)
        text = json.dumps(line)
        if self.lines_file:
            with open(self.lines_file, "a") as file:
                file.write(text + "\n")
        else:
            print(text, flush=True)

    def execute(self, command, threads, folder, memory=0, quiet=True):
        """Runs a command, with so much memory fetched before. Returns its last line of output (or None), a failure (or None) and what it used."""
        waited = wait_until_quiet(self.options.quiet_wait) if quiet else 0
        fetching = fetch_memory(memory) if memory else 0
        out, errors = os.path.join(folder, "stdout"), os.path.join(folder, "stderr")
        with open(out, "wb") as stdout, open(errors, "wb") as stderr:
            before, start = busy_seconds(), time.perf_counter()
            try:
                process = subprocess.Popen(
                    command, stdout=stdout, stderr=stderr, env=environment(threads), start_new_session=True,
                    preexec_fn=first_to_be_killed,
                )
            except OSError as error:
                return None, str(error), {}
            timer = threading.Timer(self.options.timeout, end, [process.pid])
            timer.start()
            _, status, usage = os.wait4(process.pid, 0)
            wall = time.perf_counter() - start
            overdue = wall >= self.options.timeout
            timer.cancel()
            if overdue:
                timer.join()
            process.returncode = os.waitstatus_to_exitcode(status)
        processor = usage.ru_utime + usage.ru_stime
        used = dict(
            wall_with_start=round(wall, 4), cpu=round(processor, 3), peak_mb=round(usage.ru_maxrss / 1024, 1), waited=waited, fetching=fetching,
            others=round(max(0.0, busy_seconds() - before - processor) / wall, 2),
        )
        with open(out, errors="replace") as stdout, open(errors, errors="replace") as stderr:
            output, complaint = stdout.read().strip(), stderr.read().strip()
        if overdue:
            return None, f"over {self.options.timeout} s", used
        if process.returncode:
            return None, f"status {process.returncode}: {(complaint or output)[-300:]}", used
        return next((line for line in reversed(output.splitlines()) if line.startswith("{")), None), None, used

    def command(self, tool, part, modes, threads, folder):
        """The command, and the result's path."""
        if tool in OURS:
            job = ["--without-estimate"] if tool == "reduce" else []
            result = os.path.join(folder, "part.dcb.h5")
            return [
                self.options.reduce, os.path.join(part, "part.mtx"), "--modes", str(modes), "-o", result, "--force", "--quiet",
                "--threads", str(threads), "--timings", os.path.join(folder, "timings.json"), *job,
            ], result
        result = os.path.join(folder, "result.h5" if tool in SOLVERS else "result.npz")
        if tool in SOLVERS:
            return [sys.executable, os.path.join(PEERS, "reduction.py"), part, tool, str(modes), result], result
        if tool == "exudyn":
            return [sys.executable, os.path.join(PEERS, "exudyn_modes.py"), part, str(modes), result], result
        start = ["mpiexec", "-n", str(threads)] if tool == "slepc-mumps-mpi" else []
        return [*start, self.options.slepc_python, os.path.join(PEERS, "slepc_modes.py"), part, str(modes), result], result

    def run(self, component, modes, tool, threads, round_number):
        part = os.path.join(self.options.data, component)
        with open(os.path.join(part, "meta.json")) as file:
            dofs = json.load(file)["dofs"]
        line = dict(kind="run", component=component, dofs=dofs, modes=modes, tool=tool, threads=threads, round=round_number)
        with tempfile.TemporaryDirectory(dir=self.options.data, prefix="run-") as folder:
            command, result = self.command(tool, part, modes, threads, folder)
            memory = min(BYTES_PER_DOF * dofs, machine_memory() // 2) if self.options.fetch_memory else 0
            told, failure, used = self.execute(command, 1 if tool == "slepc-mumps-mpi" else threads, folder, memory)
            line |= used
            if failure is None and tool in OURS:
                with open(os.path.join(folder, "timings.json")) as file:
                    timings = json.load(file)
                line |= dict(
                    wall=used["wall_with_start"], stages={row["stage"]: round(row["seconds"], 4) for row in timings["stages"]},
                    stage_peaks_mb={row["stage"]: row["peak_megabytes"] for row in timings["stages"]},
                    work=timings.get("work"), program_given=self.options.given, versions=self.reduce_version(), file_mb=round(os.path.getsize(result) / 1e6, 1),
                )
            elif failure is None:
                told = json.loads(told)
                line |= dict(
                    wall=round(told["wall"], 4), stages={name: round(value, 4) for name, value in told["stages"].items()},
                    processor={name: round(value, 3) for name, value in told["processor"].items()}, work=told["statistics"],
                    versions=told["versions"],
                )
                if tool not in SOLVERS:  # taken before the vectors for the check were gathered
                    line["peak_mb"] = round(told["peak_mb"], 1)
            if failure is None:
                check = [sys.executable, os.path.join(PEERS, "check_superelement.py"), part, result]
                told, failure, _ = self.execute(check, os.cpu_count(), folder, quiet=False)
                if failure is None:
                    line |= json.loads(told)
                else:
                    line["failed"] = f"the check: {failure}"
            else:
                line["failed"] = failure
        line["openblas_core"] = environment(threads).get("OPENBLAS_CORETYPE", "")
        self.add(**line)
        wall, outcome = line.get("wall", line.get("wall_with_start", 0)), line.get("failed", "")[-160:]
        print(
            f"{component} {modes} modes, {tool}, {threads} threads, round {round_number}: {wall:.2f} s, {line.get('peak_mb', 0):.0f} MB, "
            f"others {line.get('others')} cores {outcome}", file=sys.stderr, flush=True,
        )
        return line

    def reduce_version(self):
        text = subprocess.run([self.options.reduce, "--version"], stdout=subprocess.PIPE, text=True).stdout
        return dict(reduce=text.split()[-1])

    def done(self, **wanted):
        """The line of this commit that has these values, if there is one and it didn't fail."""
        return next((
            line for line in self.lines
            if line["commit"] == self.commit and "failed" not in line and all(line.get(name) == value for name, value in wanted.items())
        ), None)

    def limits(self, threads):
        if self.options.resume and self.done(kind="limit"):
            return
        wait_until_quiet(self.options.quiet_wait)
        command = [sys.executable, os.path.join(PEERS, "limits.py"), "--threads", ",".join(map(str, threads))]
        before, start = busy_seconds(), time.perf_counter()
        told = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=environment(threads[0])).stdout
        cores = round((busy_seconds() - before) / (time.perf_counter() - start), 2)
        for text in told.splitlines():
            if text.startswith("{"):
                self.add(kind="limit", **json.loads(text), cores_busy=cores)

    def factor(self, component):
        """The size and flops of METIS's factor as CHOLMOD counts them, a measure that depends on no tool's padding."""
        if self.done(kind="factor", component=component):
            return
        part = os.path.join(self.options.data, component)
        with tempfile.TemporaryDirectory(dir=self.options.data, prefix="run-") as folder:
            command = [sys.executable, os.path.join(PEERS, "reduction.py"), part, "cholmod-metis", "--analysis"]
            told, failure, _ = self.execute(command, 1, folder, quiet=False)
        if failure is None:
            self.add(kind="factor", component=component, **json.loads(told))
        else:
            print(f"{component}: METIS's factor is unknown: {failure}", file=sys.stderr)

    def generate(self, component):
        if not os.path.exists(os.path.join(self.options.data, component, "meta.json")):
            command = [sys.executable, os.path.join(PEERS, "components.py"), component]
            subprocess.check_call(command, env=dict(os.environ, PERF_DATA=self.options.data), stdout=subprocess.DEVNULL)

    def read_once(self, component):
        """Brings the part's files into the system's cache: the first tool shouldn't be the one that waits for the disk."""
        folder = os.path.join(self.options.data, component)
        for name in os.listdir(folder):
            with open(os.path.join(folder, name), "rb") as file:
                while file.read(1 << 24):
                    pass

    def component(self, component, modes, tools, threads):
        self.generate(component)
        self.read_once(component)
        self.factor(component)
        slow = set()
        for round_number in range(self.options.rounds):
            for count in threads:
                turn = round_number % len(tools)
                for tool in tools[turn:] + tools[:turn]:
                    key = dict(component=component, modes=modes, tool=tool, threads=count, round=round_number)
                    if (tool, count) in slow or (tool == "slepc-mumps-mpi" and count == 1):
                        continue
                    line = self.done(kind="run", **key) if self.options.resume else None
                    line = line or self.run(component, modes, tool, count, round_number)
                    if line.get("wall", line.get("wall_with_start", 0)) > self.options.once_above:
                        slow.add((tool, count))


def machine_memory():
    """Bytes."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def machine():
    with open("/proc/cpuinfo") as file:
        model = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), platform.machine())
    with open("/proc/cpuinfo") as file:
        identity = [line.split(":")[1].strip() for line in file if line.startswith(("cpu family", "model\t"))][:2]
    memory = machine_memory() / 2**30
    return dict(cpu=f"{model} (family {identity[0]}, model {identity[1]})" if len(identity) == 2 else model, cores=os.cpu_count(),
                memory_gb=round(memory, 1), python=platform.python_version())


def commit():
    """The last commit that touched the program or the benches, with a plus sign if they have changed since."""
    sources = "reducer", "formats", "Cargo.toml", "Cargo.lock", "tests/benches"

    def git(*arguments):
        return subprocess.run(["git", "-C", ROOT, *arguments, "--", *sources], stdout=subprocess.PIPE, text=True).stdout.strip()

    return git("log", "-1", "--format=%h") + ("+" if git("status", "--porcelain") else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--components", default=COMPONENTS)
    parser.add_argument("--tools", default=",".join(TOOLS))
    parser.add_argument("--modes", type=int, default=30)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--data", default=os.environ.get("PERF_DATA", os.path.join(tempfile.gettempdir(), "perf-data")))
    parser.add_argument("--write", nargs="?", const=LINES, metavar="FILE")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--reduce", help="the program, taken to be of this commit; built if not given")
    parser.add_argument("--slepc-python", default="/usr/bin/python3")
    parser.add_argument("--quiet-wait", type=float, default=45, help="longest wait for a quiet machine before a run, s")
    parser.add_argument("--memory-as-it-is", dest="fetch_memory", action="store_false", help="don't touch the memory that a run needs before it")
    parser.add_argument("--timeout", type=float, default=1800, help="of a run, s")
    parser.add_argument("--once-above", type=float, default=60, help="a tool that takes longer isn't run in later rounds, s")
    options = parser.parse_args()
    tools = options.tools.split(",")
    if unknown := set(tools) - set(TOOLS):
        parser.error(f"unknown tools: {', '.join(sorted(unknown))}; there are {', '.join(TOOLS)}")
    options.data = os.path.abspath(options.data)
    os.makedirs(options.data, exist_ok=True)
    options.given = bool(options.reduce)
    if not options.given:
        subprocess.check_call(["cargo", "build", "--release", "--quiet", "--bin", "reduce"], cwd=ROOT)
        options.reduce = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "reduce")
    bench = Bench(options)
    threads = [int(count) for count in options.threads.split(",")]
    bench.limits(threads)
    for name in options.components.split(","):
        component, _, modes = name.partition(":")
        bench.component(component, int(modes or options.modes), tools_for(component, tools), threads)

    import peer_table

    print("\n".join(peer_table.tables([line for line in bench.lines if line["commit"] == bench.commit])))


if __name__ == "__main__":
    main()
