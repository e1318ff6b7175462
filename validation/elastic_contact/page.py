# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/elastic-contact.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional

import numpy as np

from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent

#: Pairs in three dimensions that are those of axial symmetry, with their aspect ratio.
TIPS = {"1:1:1 tip to tip": 1.0, "2:1:1 tip to tip": 2.0, "5:1:1 tip to tip": 5.0}


def loses_one_per_cent(rows: List[Dict[str, Any]], column: str) -> Optional[float]:
    """The overlap at which |error| passes 1 %, on straight lines of the logarithms; None if it never does."""
    overlap = np.array([row["overlap"] for row in rows])
    error = np.abs([row[column] for row in rows])
    for k in range(1, len(rows)):
        if error[k] >= 0.01 > error[k - 1]:
            slope = np.log(overlap[k] / overlap[k - 1]) / np.log(error[k] / error[k - 1])
            return float(overlap[k - 1] * (0.01 / error[k - 1]) ** slope)
    return None


def supported(rows: List[Dict[str, Any]], support: str) -> bool:
    return not np.isnan(rows[0][support])


def lost_at(rows: List[Dict[str, Any]], column: str) -> str:
    """The overlap at which 1 % is lost, or that it lies beside those that were computed."""
    limit = loses_one_per_cent(rows, column)
    if limit is not None:
        return short(limit)
    return f"below {rows[0]['overlap']:g}" if abs(rows[0][column]) >= 0.01 else f"beyond {rows[-1]['overlap']:g}"


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
    whole = groups(read_csv(HERE / "whole_bodies.csv"), "pair")

    figure, ((left, middle), (right, last)) = plt.subplots(2, 2, figsize=(12, 9.8))
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
    right.set(xscale="log", yscale="log", xlabel="overlap / radius of curvature", title="whole bodies tip to tip")
    for colour, (name, rows) in zip(COLOURS, ((name, rows) for name, rows in whole.items() if name not in TIPS)):
        for support, style in (("free", "-"), ("held", "--")):
            if supported(rows, support):
                last.errorbar(
                    [row["overlap"] for row in rows], [abs(row[support]) for row in rows], [row[f"{support}_bar"] for row in rows],
                    label=f"{name}, {support}", color=colour, marker="o", markersize=3, linewidth=1, linestyle=style, capsize=2,
                    markerfacecolor=colour if support == "free" else "white",
                )
    last.set(xscale="log", yscale="log", xlabel="overlap / smaller radius of curvature", title="whole bodies in other poses, three dimensions")
    last.set_ylim(5e-5, 2)
    last.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3)
    right.set_ylabel("|error of the force|")
    last.set_ylabel("|error of the force|")
    for axes in (middle, right, last):
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
    by_pair = {name: {row["overlap"]: row for row in rows} for name, rows in whole.items()}
    bent, flat = by_pair["5:1:1 side by side"], by_pair["2:1:1 side by side"]
    tips = [
        (row[support], row[f"{support}_bar"], other[support], other[f"{support}_bar"])
        for name, aspect in TIPS.items()
        for row, other in zip(whole[name], bodies[aspect])
        for support in ("free", "held")
    ]
    apart = max(abs(one - other) for one, _, other, _ in tips)
    bars = max(abs(one - other) / (bar + other_bar) for one, bar, other, other_bar in tips)
    conclusion = (
        f"On Hertz' own problem the law's force agrees with boundary elements to {worst:.0e} from B/A = 1 to 100 (error bar {bar:.0e}). "
        f"The true shape of the ellipsoids costs 1 % at overlaps of {short(min(known))} of the smallest semi-axis and more. That bodies are no "
        f"half-spaces costs more, and grows as the root of the overlap: two free spheres repel each other by {abs(100 * at['free']):.1f} % more than the "
        f"law says at an overlap of 0.001 of the radius; 1 % is lost at {short(lost['free'])} of it, and at {short(lost['held'])} where each sphere "
        f"is held by an equal force on its other side. Side by side, crossed and oblique 2:1:1 loses as spheres do or less. At 5:1:1, touched on their sides, free grains are bent: the law's force is "
        f"{percent(bent[1e-3]['free'], 0).lstrip('+')} too large at 0.001 side by side."
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
        "## Whole bodies tip to tip\n\n"
        "Finite elements (scikit-fem, quadratic triangles in axial symmetry, small strain, exact gap): a spheroid pressed with its tip against its mirror image. "
        "The compliance of the finite body stands in place of that of the half-space. *Free*: inertia balances the contact force, and the body is where its centre of "
        "mass is, as in a collision slow against sound. *Held*: an equal force acts on the other tip, as in a chain. 16 elements along the contact radius; the "
        "error bar is the change from 8. The overlap is in units of the tip's radius of curvature.\n\n"
        + table(
            ["aspect ratio", "support", *[f"{row['overlap']:g}" for row in sphere], "1 % lost at"],
            [
                [f"{aspect:g}", support]
                + [f"{percent(row[support])} ± {100 * row[support + '_bar']:.2f}" for row in rows]
                + [lost_at(rows, support)]
                for aspect, rows in bodies.items()
                for support in ("free", "held")
            ],
        )
        + "\nThe sign says what the half-space leaves out. A blunt body is stiffer than the half-space, because there is no material beyond its centre that could yield. "
        f"A slender one is compressed as a bar as well: tip to tip at 5:1:1 the law is too stiff, by 1 % at {short(slender)} of the tip's radius. At 2:1:1 the two balance.",
        "## Whole bodies in other poses\n\n"
        "Finite elements in three dimensions: the quadratic hexahedra of [collisions](collisions.md), half or a quarter of each body, at rest, small strain, exact gap, no "
        "friction. *Free* and *held* are as above. Oblique grains are parallel, their axes at 45 degrees to the normal; where the normal misses the centres, inertia balances the torque too, and no "
        "single force on the other side would hold them. Discs are 1:1:0.5. Each number is the difference to an overlap of 1e-10 on the same grid, where bodies are half-spaces, so that the "
        "grid's own error in the contact is gone. 12 elements across 1.2 times the contact ellipse, and the error bar is the change from 8; where bodies are oblique 8, and the change from 6. The mesh of oblique bodies is askew and converges slowly, to the soft side: the truth may be a bar beyond. Bars below 0.05 % are of two grids that "
        "happen to agree. The overlap is in units of the smaller radius of "
        "curvature of a body where it is touched: the smallest semi-axis side by side and crossed.\n\n"
        + table(
            ["pair", "support", *[f"{row['overlap']:g}" for row in next(iter(whole.values()))], "1 % lost at"],
            [
                [name, support]
                + [f"{percent(row[support])} ± {100 * row[support + '_bar']:.2f}" for row in rows]
                + [lost_at(rows, support)]
                for name, rows in whole.items()
                for support in ("free", "held")
                if supported(rows, support)
            ],
        )
        + f"\nTip to tip they are the bodies of the section before: the two kinds of elements differ by {percent(apart).lstrip('+')} at most, {bars:.2f} of the sum of their error bars. A test "
        "holds how far a force moves the far side of a body, which is where bending and inertia enter, against tetrahedra of another program.\n\n"
        "A long grain that is touched on its side and free is bent by its own inertia, and the two are softer than half-spaces, however shallow the contact: at 5:1:1 side by side the law's force is "
        f"{percent(bent[1e-3]['free'], 0).lstrip('+')} too large at an overlap of 0.001. Between two neighbours, *held*, it cannot bend, and is as stiff as a blunt body. *Free* is the limit of a contact that lasts much longer "
        "than the period of bending; in a fast collision bending takes energy instead ([collisions](collisions.md)). At 2:1:1 there is little to bend: side by side the two are "
        f"as stiff as spheres ({percent(flat[1e-3]['free'], 1)} at 0.001), and oblique the two effects balance. At 3:1:1 oblique bending outweighs: {percent(by_pair['3:1:1 oblique'][1e-3]['free'], 1)} at 0.001. "
        "Discs that touch with their faces lose more than any other pair that does not bend "
        f"({percent(by_pair['1:1:0.5 face to face'][1e-3]['free'], 1)} at 0.001), and with their rims little.",
        "## What is left out\n\nOblique grains of 5:1:1: on meshes as askew as theirs bending does not converge. Bodies of three different semi-axes, unequal bodies, and a tip on a side. Friction. Plasticity and large strains are not in the law at all.",
    ]
    write(HERE, "Elastic contact against boundary and finite elements", conclusion, parts, ["paraboloids.csv", "exact_shapes.csv", "finite_bodies.csv", "whole_bodies.csv"])


if __name__ == "__main__":
    main()
