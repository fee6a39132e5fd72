"""The suite: every topic in a process of its own, one table.

    python benchmarks/run.py [--quick] [--topic NAME ...]

Writes benchmarks/results/suite.json and suite.md (suite_quick.* with --quick). With --topic the
rows of that topic replace those recorded before.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

from suite_rows import TOPICS

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("demospec", "numpy", "scipy", "pyarrow", "torch", "ortools", "scikit-image", "ompl")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repeats, smaller sets")
    parser.add_argument("--topic", action="append", choices=list(TOPICS), help="only this one")
    parser.add_argument("--child", choices=list(TOPICS), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        rows = [{**asdict(row), "met": row.met} for row in TOPICS[options.child](options.quick)]
        print("\nROWS " + json.dumps(rows))
        return 0
    name = "suite_quick" if options.quick else "suite"
    file = RESULTS / f"{name}.json"
    topics: dict[str, Any] = {}
    if options.topic and file.exists():
        topics = json.loads(file.read_text(encoding="utf-8"))["topics"]
    for topic in options.topic or TOPICS:
        topics[topic] = measured(topic, options.quick)
    topics = {topic: topics[topic] for topic in TOPICS if topic in topics}
    arguments = " --quick" if options.quick else ""
    document = {"command": f"python benchmarks/run.py{arguments}", "seed": 0,
                "machine": machine(), "topics": topics}  # fmt: skip
    file.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text = table(document)
    (RESULTS / f"{name}.md").write_text(text, encoding="utf-8")
    print(text)
    return 1 if any("failed" in t for t in topics.values()) else 0


def measured(topic: str, quick: bool) -> dict[str, Any]:
    """Rows of one topic, made by a child on one thread; why, where it failed."""
    command = [sys.executable, __file__, "--child", topic, *(["--quick"] if quick else [])]
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    began = time.monotonic()
    print(f"{topic} …", file=sys.stderr, flush=True)
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **one})
    took = round(time.monotonic() - began, 1)
    lines = [line for line in done.stdout.splitlines() if line.startswith("ROWS ")]
    if done.returncode or not lines:
        why = done.stderr.strip().splitlines()[-1:] or [f"exit {done.returncode}"]
        print(done.stderr, file=sys.stderr)
        return {"failed": why[0], "wall_s": took, "rows": []}
    return {"rows": json.loads(lines[-1].removeprefix("ROWS ")), "wall_s": took}


def machine() -> dict[str, Any]:
    def version(package: str) -> str:
        try:
            return metadata.version(package)
        except metadata.PackageNotFoundError:
            return "not installed"

    processor = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                processor = line.split(":", 1)[1].strip()
    return {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": {package: version(package) for package in PACKAGES},
        "load": [round(x, 1) for x in os.getloadavg()],
    }


def table(document: dict[str, Any]) -> str:
    about = document["machine"]
    versions = ", ".join(f"{name} {v}" for name, v in about["versions"].items())
    lines = [
        f"`{document['command']}` on {about['processor']}, {about['cores']} cores, Python "
        f"{about['python']}; {versions}. Load when it ended: {about['load'][0]}.",
        "",
        "| work | measured | goal | met | bound it should approach | peer, same process | ratio |",
        "|---|---:|---:|---|---|---|---:|",
    ]
    for topic, found in document["topics"].items():
        if "failed" in found:
            lines.append(f"| {topic} | failed: {found['failed']} | | no | | | |")
        for row in found["rows"]:
            goal = "" if row["goal"] is None else f"{'≥' if row['more'] else '≤'} {row['goal']:,g}"
            met = {None: "", True: "yes", False: "**no**"}[row["met"]]
            ratio = "" if row["ratio"] is None else f"{row['ratio']:,.3g}"
            value = f"{row['value']:,.0f}" if row["value"] >= 1000 else f"{row['value']:.3g}"
            lines.append(
                f"| {row['work']} | {value} {row['unit']} | {goal} | {met} | {row['bound']} "
                f"| {row['peer']} | {ratio} |"
            )
    lines += ["", "The ratio is the peer's time over ours for solvers and planners, ours over the "
              "peer's for copies, readers and an empty process.", ""]  # fmt: skip
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
