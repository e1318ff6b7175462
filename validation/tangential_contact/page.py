# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/tangential-contact.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

import numpy as np

from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent
FORMS = ("total", "incremental", "rescaled", "mindlin")


def chosen(rows: List[Dict[str, Any]], **wanted: Any) -> List[Dict[str, Any]]:
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def spread(rows: List[Dict[str, Any]], column: str, digits: int = 2) -> str:
    """Least to largest over the scenes, one number where they print alike."""
    least, largest = (f"{f(row[column] for row in rows) + 0.0:.{digits}f}" for f in (min, max))
    least, largest = (text[1:] if text.strip("-0.") == "" and text[0] == "-" else text for text in (least, largest))
    return (least if least == largest else f"{least} to {largest}").replace("-", "−")


def main() -> None:
    rows = read_csv(HERE / "cycles.csv")
    curves = read_csv(HERE / "curves.csv")
    names = list(dict.fromkeys(row["path"] for row in rows))
    scenes = sorted({(row["aspect"], row["poisson"], row["direction"]) for row in rows})

    shown = ("reversed at 0.8", "sliding, reversed at 1.5", "loaded shallow, unloaded deep", "normal force rising and falling")
    figure, panels = plt.subplots(1, 4, figsize=(15, 4.0))
    for axes, name in zip(panels, shown):
        of = chosen(curves, path=name)
        place = np.array([row["x"] for row in of])
        # The scene's direction is at 45 degrees: the force along it.
        place = place / np.abs(place).max()
        for colour, column in zip(["#333333", *COLOURS], ("full", *FORMS)):
            force = [-(row[f"{column}_x"] + row[f"{column}_y"]) / np.sqrt(2) for row in of]
            if column == "full":
                axes.plot(place, force, color=colour, linewidth=2.2, label="boundary elements")
            else:
                axes.plot(place, force, color=colour, linewidth=1, linestyle="--" if column == "mindlin" else "-", label=column if column == "mindlin" else f"tfd, {column}")
        axes.set(title=name, xlabel="displacement / largest", ylabel="force / (mu largest F_n)")
    panels[0].legend(loc="upper left")
    save(figure, HERE, "On first loading tfd is Cattaneo and Mindlin's curve; on the way back the full problem keeps a loop that tfd has not")

    tfd = chosen(rows, form="rescaled")
    mildly, strongly = chosen(tfd, path="reversed at 0.4"), chosen(tfd, path="reversed at 0.8")
    sliding = chosen(tfd, path="sliding, reversed at 1.5")
    pulsing = {form: chosen(rows, path="normal force rising and falling", form=form) for form in FORMS}
    created = {form: chosen(rows, path="loaded shallow, unloaded deep", form=form) for form in FORMS}
    slid = {form: chosen(rows, path="sliding, reversed at 1.5", form=form)[0] for form in FORMS}

    def lost(form: str) -> float:
        return 100 * (slid[form]["dissipated_by_law"] / slid[form]["dissipated"] - 1)

    def per_cent(of: List[Dict[str, Any]]) -> str:
        return f"{100 * max(row['force_error'] for row in of):.0f} %"

    conclusion = (
        "`tfd` has no hysteresis below sliding. In a cycle between plus and minus 0.4 of the sliding displacement its force is wrong by up to "
        f"{per_cent(mildly)} of mu F_n, between plus and minus 0.8 by {per_cent(strongly)}, and it dissipates nothing where the full problem loses "
        f"{spread(mildly, 'dissipated')} and {spread(strongly, 'dissipated')} of what a spring would hold. Where the contact slides and is reversed, the force on the way back is wrong by up to "
        f"{per_cent(sliding)}, and the cycle dissipates {abs(lost('rescaled')):.0f} % too little; `mindlin` dissipates {lost('mindlin'):.0f} % too much. With the normal force rising and falling "
        f"`rescaled` and `incremental` are wrong by {per_cent(pulsing['rescaled'])}, `total` by {per_cent(pulsing['total'])}. "
        f"Loaded shallow and unloaded deep, `total` and `incremental` create energy ({-max(row['dissipated_by_law'] for row in created['total']):.2f} and "
        f"{-max(row['dissipated_by_law'] for row in created['incremental']):.2f} of the same unit; the full problem loses {spread(created['total'], 'dissipated')}); `rescaled` does on none of these paths."
    )
    forces = table(
        ["path", *FORMS, "error bar"],
        [
            [name, *[spread(chosen(rows, path=name, form=form), "force_error") for form in FORMS], spread(chosen(rows, path=name, form="total"), "force_bar", 3)]
            for name in names
        ],
    )
    energies = table(
        ["path", "full problem", "error bar", *FORMS],
        [
            [
                name,
                spread(chosen(rows, path=name, form="total"), "dissipated"),
                f"{max(row['dissipated_bar'] for row in chosen(rows, path=name)):.2f}",
                *[spread(chosen(rows, path=name, form=form), "dissipated_by_law") for form in FORMS],
            ]
            for name in names
        ],
    )
    begun = read_csv(HERE / "first_loading.csv")
    oblique = [row for row in begun if row["aspect"] > 1 and row["direction"] == 45]
    aligned = [row for row in begun if row not in oblique]
    bar = max(row["force_bar"] for row in begun)
    parts = [
        "Equal grains side by side: "
        + "; ".join(f"aspect ratio {aspect:g}, nu {poisson:g}" + (f", {direction:g}° from the major semi-axis" if aspect > 1 else "") for aspect, poisson, direction in scenes)
        + ". A range is over these; of *loaded deep* and *loaded shallow* over the first, the third and the fifth.",
        "## The reference\n\n"
        "Boundary elements with the kernels of Cerruti for shear on rectangles: in each step the shear tractions q minimise q.(C q)/2 - q.(xi - s) under |q| <= mu p at each rectangle, which is "
        "Coulomb's law in backward Euler form, with s the slip so far. Neither an annulus of slip nor slip along the displacement is assumed. The bodies are equal, so that the pressure "
        "stays Hertz'. 26 rectangles a side and 16 steps a line of the path; the error bar is the change from 14 and 8. "
        "For the circle at nu 0 it agrees with Cattaneo's and Mindlin's closed form, on loading and in the cycle (a test compares them).",
        "## First loading\n\n"
        f"Up to 1.2 of the sliding displacement at steady normal force, `tfd` differs from the full problem by at most {max(row['force_error'] for row in aligned):.4f} of mu F_n on the circle and along both "
        f"principal directions of the ellipse, which is within the error bar of {bar:.3f}. In oblique directions, where the isotropic slip of the law is an assumption, it differs by up to "
        + " and ".join(f"{row['force_error']:.3f} at aspect ratio {row['aspect']:g}" for row in oblique)
        + ".",
        "## Force\n\n"
        "The largest error along the path, in units of mu times the largest normal force. Displacements are in units of that at which the contact slides as a whole. "
        "*Loaded deep, unloaded shallow*: to 0.6 at full overlap, overlap to 0.4 of it, back to 0, overlap up again, in the second round. *Loaded shallow, unloaded deep*: to 0.2 at 0.4 of the overlap, overlap up, back, overlap down. "
        "*Normal force rising and falling*: overlap 0.6 + 0.4 cos, displacement 0.6 sin. *Led in a circle*: of radius 0.6, at steady normal force.\n\n" + forces,
        "## Energy dissipated in the closed cycle\n\n"
        "In units of half of mu times the largest normal force times the largest displacement, which a spring would hold. Negative: created.\n\n" + energies,
        "## What follows\n\n"
        "- What loads once is right. What `rescaled`, `total` and `incremental` lack is the loop of the way back; `displacement hysteretic` has it.\n"
        "- Vibrated and cyclically sheared packings below sliding lose energy by micro-slip in the full problem, and not in these three. Viscosity is all that damps them there.\n"
        "- `displacement hysteretic`, a bed of eight springs with a Coulomb limit each (Popov and Hess 2015, after Jaeger 1995), closes the gap. At aspect ratio 2 its force is off by 1.6 % of mu F_n at most in cycles below sliding, by 3 % where it slides in between, and by 2 % with a changing normal force. What the cycles dissipate is right to 4 %, that of the smallest and of the one loaded shallow to 10 %. Led in a circle it dissipates 0.85 to 0.92 of the full problem. It creates none. `springs.py` prints that, with the law written a second time.\n"
        "- Both `total` and `incremental` can be driven to give energy, `rescaled` could not: it stays the default of `tfd`.",
        "## What is left out\n\nTwisting about the normal, unequal materials (whose shear changes the pressure), rolling.",
    ]
    write(HERE, "Tangential contact against partial slip by boundary elements", conclusion, parts, ["cycles.csv", "curves.csv", "first_loading.csv"])


if __name__ == "__main__":
    main()
