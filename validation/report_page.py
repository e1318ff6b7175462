# SPDX-License-Identifier: MIT OR Apache-2.0
"""A chapter of docs/report: Markdown with its numbers, a picture, and where the numbers come from."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Iterable, List, Sequence

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

REPORT = Path(__file__).resolve().parent.parent / "docs" / "report"
# Okabe and Ito's colours, which colour-blind readers tell apart.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#707070", "#000000", "#b8860b"]

plt.rcParams.update(
    {
        "svg.hashsalt": "ellgran",
        "svg.fonttype": "none",
        "font.family": "sans-serif",
        "font.size": 9,
        "axes.grid": True,
        "grid.color": "#e4e4e4",
        "legend.frameon": False,
        "legend.fontsize": 7.5,
        "figure.constrained_layout.use": True,
    }
)


def save(figure: "plt.Figure", folder: Path, title: str) -> None:
    """The picture of a comparison; the title is what to conclude from it."""
    figure.suptitle(title, fontsize=11)
    figure.savefig(REPORT / f"{_name(folder)}.svg", metadata={"Date": None})


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines: List[Sequence[str]] = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def write(folder: Path, title: str, conclusion: str, parts: Iterable[str], numbers: Sequence[str]) -> None:
    """docs/report/NAME.md."""
    name = _name(folder)
    origin = json.loads((folder / "origin.json").read_text())
    versions = ", ".join(
        f"{key} {value}" for key, value in origin.items() if key not in ("command", "seconds", "seconds_of_parts", "processor", "system", "note")
    )
    files = ", ".join(f"[{file}](../../validation/{folder.name}/{file})" for file in [*numbers, "origin.json"])
    text = f"# {title}\n\n![{name}.svg]({name}.svg)\n\n**Conclusion.** {conclusion}\n\n"
    text += "\n\n".join(part.strip() for part in parts)
    text += f"\n\n## Where the numbers come from\n\n`{origin['command']}`, {origin['seconds']} s on one core that others shared "
    text += f"({origin['processor']}; {versions}). The numbers: {files}.\n"
    if "note" in origin:
        text = text.rstrip() + f" They were {origin['note']}.\n"
    (REPORT / f"{name}.md").write_text(text)
    print(f"wrote {name}.md and {name}.svg")


def _name(folder: Path) -> str:
    return folder.name.replace("_", "-")
