# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/elastic-contact.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional

import numpy as np

from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent


def loses_one_per_cent(rows: List[Dict[str, Any]], column: str) -> Optional[float]:
    """The overlap at which |error| passes 1 %, on straight lines of the logarithms; None if it never does."""
    overlap = np.array([row["overlap"] for row in rows])
    error = np.abs([row[column] for row in rows])
    for k in range(1, len(rows)):
        if error[k] >= 0.01 > error[k - 1]:
            slope = np.log(overlap[k] / overlap[k - 1]) / np.log(error[k] / error[k - 1])
            return float(overlap[k - 1] * (0.01 / error[k - 1]) ** slope)
    return None


def groups(rows: List[Dict[str, Any]], key: str) -> Dict[Any, List[Dict[str, Any]]]:
    found: Dict[Any, List[Dict[str, Any]]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return found


def percent(value: float, digits: int = 2) -> str:
    return f"{100 * value:+.{digits}f} %".replace("-", "−")


def short(value: float) -> str:
    """Two digits, never as a power of ten."""
    return np.format_float_positional(value, precision=2, fractional=False, trim="-")


def main() -> None:
    paraboloids = read_csv(HERE / "paraboloids.csv")
    shapes = groups(read_csv(HERE / "exact_shapes.csv"), "pair")
    bodies = groups(read_csv(HERE / "finite_bodies.csv"), "aspect")

    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.3))
    ratio = [row["ratio"] for row in paraboloids]
    for colour, (name, label) in zip(
        COLOURS, [("force", "force"), ("major", "major semi-axis"), ("minor", "minor semi-axis"), ("peak", "largest pressure")]
    ):
        left.errorbar(
            ratio,
            [1e3 * row[name] for row in paraboloids],
            [1e3 * row[f"{name}_bar"] for row in paraboloids],
            label=label, color=colour, marker="o", markersize=4, capsize=3, linewidth=1,
        )
    left.set(xscale="log", xlabel="B/A", ylabel="law less boundary elements (1/1000)", title="paraboloids: Hertz' own problem")
    left.legend()
    for colour, (name, rows) in zip(COLOURS, shapes.items()):
        middle.plot(
            [row["overlap"] for row in rows], [abs(row["force"]) for row in rows], label=name, color=colour, marker="o", markersize=3, linewidth=1
        )
    middle.set(xscale="log", yscale="log", xlabel="overlap / smallest semi-axis", ylabel="|error of the force|", title="the ellipsoids' own gap")
    for colour, (aspect, rows) in zip(COLOURS, bodies.items()):
        for support, style in (("free", "-"), ("held", "--")):
            right.plot(
                [row["overlap"] for row in rows], [abs(row[support]) for row in rows], style, label=f"{aspect:g}:1:1 tip to tip, {support}",
                color=colour, marker="o", markersize=3, linewidth=1, markerfacecolor=colour if support == "free" else "white",
            )
    right.set(xscale="log", yscale="log", xlabel="overlap / radius of curvature", title="whole bodies")
    for axes in (middle, right):
        axes.axhline(0.01, color="#333333", linestyle=":", linewidth=1)
    middle.legend(loc="upper left")
    right.set_ylim(1e-5, 0.2)
    right.legend(loc="lower right", ncols=2)
    sphere = bodies[1.0]
    at = next(row for row in sphere if row["overlap"] == 1e-3)
    lost = {support: loses_one_per_cent(sphere, support) for support in ("free", "held")}
    save(figure, HERE, "Hertz' law is exact for paraboloids; that bodies are finite costs more than that they are no paraboloids")

    worst = max(abs(row["force"]) for row in paraboloids)
    bar = max(row["force_bar"] for row in paraboloids)
    limits = {name: loses_one_per_cent(rows, "force") for name, rows in shapes.items()}
    known = [limit for limit in limits.values() if limit is not None]
    slender = loses_one_per_cent(bodies[5.0], "free")
    conclusion = (
        f"On Hertz' own problem the law's force agrees with boundary elements to {worst:.0e} from B/A = 1 to 100 (error bar {bar:.0e}). "
        f"The true shape of the ellipsoids costs 1 % at overlaps of {short(min(known))} of the smallest semi-axis and more. That bodies are no "
        f"half-spaces costs more, and grows as the root of the overlap: two free spheres repel each other by {abs(100 * at['free']):.1f} % more than the "
        f"law says at an overlap of 0.001 of the radius; 1 % is lost at {short(lost['free'])} of it, and at {short(lost['held'])} where each sphere "
        "is held by an equal force on its other side."
    )
    parts = [
        "All errors are of the law less the full problem, of the force at equal overlap, of semi-axes and pressure at equal force. Boundary elements are given the force; the "
        "overlaps in the tables are the law's at that force. "
        "Poisson's ratio is 0.3 where it matters.",
        "## Paraboloids\n\n"
        "Boundary elements (tamaas: Polonsky and Keer's conjugate gradients, non-periodic Boussinesq operator) know neither ellipses nor Hertz. Equal prolate "
        "grains side by side, B/A the square of their aspect ratio. Grids of 32, 64 and 128 rectangles a side, extrapolated where they converge as a power of the grid "
        "(Aitken); the error bar is the change from 64 to 128. Semi-axes from the second moments of the pressure.\n\n"
        + table(
            ["B/A", "b/a", "force", "major semi-axis", "minor semi-axis", "largest pressure"],
            [
                [f"{row['ratio']:g}", f"{row['b_over_a']:.3f}"]
                + [f"{row[name]:.1e} ± {row[name + '_bar']:.0e}" for name in ("force", "major", "minor", "peak")]
                for row in paraboloids
            ],
        ),
        "## The ellipsoids' own gap\n\n"
        "Half-spaces still, but with the exact gap between two ellipsoids, or an ellipsoid and a plane, in place of its paraboloid. The number is the difference "
        "to the paraboloid on the same grid (64 a side); its error bar, the change from 32 a side, is below a tenth of it. The overlap is in units of "
        "the smallest semi-axis.\n\n"
        + table(
            ["pair", *[f"{row['overlap']:g}" for row in shapes["spheres"]], "1 % lost at"],
            [
                [name, *[percent(row["force"]) for row in rows], "beyond 0.4" if limits[name] is None else short(limits[name])]
                for name, rows in shapes.items()
            ],
        )
        + "\nThe error is proportional to the overlap: for two spheres a twentieth of overlap over radius, for a sphere on a plane a tenth, as Sneddon's exact solution has it "
        "(a test compares them). Long sides lose as spheres do, tips less, since their radius is small against the body.",
        "## Whole bodies\n\n"
        "Finite elements (scikit-fem, quadratic triangles in axial symmetry, small strain, exact gap): a spheroid pressed with its tip against its mirror image. "
        "The compliance of the finite body stands in place of that of the half-space. *Free*: inertia balances the contact force, and the body is where its centre of "
        "mass is, as in a collision slow against sound. *Held*: an equal force acts on the other tip, as in a chain. 16 elements along the contact radius; the "
        "error bar is the change from 8. The overlap is in units of the tip's radius of curvature.\n\n"
        + table(
            ["aspect ratio", "support", *[f"{row['overlap']:g}" for row in sphere], "1 % lost at"],
            [
                [f"{aspect:g}", support]
                + [f"{percent(row[support])} ± {100 * row[support + '_bar']:.2f}" for row in rows]
                + [short(limit) if (limit := loses_one_per_cent(rows, support)) is not None else "beyond 0.01"]
                for aspect, rows in bodies.items()
                for support in ("free", "held")
            ],
        )
        + "\nThe sign says what the half-space leaves out. A blunt body is stiffer than the half-space, because there is no material beyond its centre that could yield. "
        f"A slender one is compressed as a bar as well: tip to tip at 5:1:1 the law is too stiff, by 1 % at {short(slender)} of the tip's radius. At 2:1:1 the two balance.",
        "## What is left out\n\nWhole bodies side by side, crossed and oblique need finite elements in three dimensions, and are not computed here. Plasticity and large strains "
        "are not in the law at all.",
    ]
    write(HERE, "Elastic contact against boundary and finite elements", conclusion, parts, ["paraboloids.csv", "exact_shapes.csv", "finite_bodies.csv"])


if __name__ == "__main__":
    main()
