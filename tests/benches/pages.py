"""Pages in headless Chromium, which draws with the processor: size, pictures a second, processor time of a picture, findings on accessibility.

    .ci/browser                      # makes the pages in target/pages
    python3 tests/benches/pages.py [--write]

Sizes of the view and what a picture takes are those of `formats/view/web/test/check_page.mjs`. `--write` puts the raw lines in place of docs/data/pages.jsonl. For a quiet machine.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

import python_loop

ROOT = python_loop.ROOT
DATA = os.path.join(ROOT, "docs", "data", "pages.jsonl")
PAGES = {
    "connecting-rod.html": "part: connecting rod, 28 176 degrees of freedom, 20 modes",
    "large.html": "part: connecting rod, 98 000 degrees of freedom, 30 modes",
    "rotor.html": "part: rotor of beams, 12 modes",
    "slider-crank.report.html": "run: slider-crank, planar",
    "scissor-lift.report.html": "run: scissor lift, 16 flexible bodies",
    "engine.report.html": "run: engine, two solid connecting rods",
    "gyroscope.report.html": "run: gyroscopic plate",
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    browser = os.environ.get("CHROMIUM") or shutil.which("chromium")
    version = subprocess.run([browser, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    lines = []
    for name, what in PAGES.items():
        path = os.path.join(ROOT, "target", "pages", name)
        command = ["node", "formats/view/web/test/check_page.mjs", path]
        done = subprocess.run(command, cwd=ROOT, env=os.environ | {"CHROMIUM": browser}, capture_output=True, text=True)
        if not done.stdout:
            sys.exit(done.stderr)
        found = json.loads(done.stdout)
        found.pop("path")
        lines.append(dict(page=name, what=what, **found, browser=version, **python_loop.conditions("pages.py")))
        print(json.dumps(lines[-1]), file=sys.stderr)
    if options.write:
        with open(DATA, "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)


if __name__ == "__main__":
    main()
