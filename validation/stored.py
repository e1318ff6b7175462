# SPDX-License-Identifier: MIT OR Apache-2.0
"""Stored results: a CSV file of numbers, and beside it a JSON file of the machine, the versions and the command that made them."""
from __future__ import annotations

import csv
import json
import platform
import time
from importlib import metadata
from pathlib import Path
from typing import Any, Dict, Iterable, List

import ellgran

_PACKAGES = ("numpy", "scipy", "tamaas", "scikit-fem", "matplotlib")


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.machine()


def write_csv(path: Path, rows: Iterable[Dict[str, Any]]) -> None:
    """Rows of equal keys; numbers with nine digits, which is more than any of them holds."""
    rows = list(rows)
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: f"{value:.9g}" if isinstance(value, float) else value for key, value in row.items()})


def read_csv(path: Path) -> List[Dict[str, Any]]:
    """The rows of `write_csv`, numbers as numbers."""

    def value(text: str) -> Any:
        try:
            return float(text)
        except ValueError:
            return text

    with open(path, newline="") as file:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def write_origin(folder: Path, started: float, **more: Any) -> None:
    """origin.json: how the numbers of a folder came about. `started` is `time.monotonic()` at the beginning; `more` adds entries, or
    takes their place."""
    origin = {
        "command": f"cargo xtask validate {folder.name.replace('_', '-')}",
        "seconds": round(time.monotonic() - started),
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "ellgran": ellgran.__version__,
    }
    origin.update({name: metadata.version(name) for name in _PACKAGES})
    origin.update(more)
    (folder / "origin.json").write_text(json.dumps(origin, indent=2) + "\n")
