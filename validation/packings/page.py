# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/packings.md and its picture, from the stored results."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

from report_page import COLOURS, plt, save, table, write
from stored import read_csv

HERE = Path(__file__).resolve().parent
THREE_AXES = "1.25:1:0.8"
#: Where that shape stands beside the aspect ratios.
ASIDE = 7.0
#: As compare.py has it.
SLOWNESS = 10
KINDS = [("compressed", 0.0), ("settled", 0.0), ("compressed", 0.5), ("settled", 0.5)]

Row = Dict[str, Any]


def name(protocol: str, friction: float) -> str:
    return f"{protocol}, {'without friction' if friction == 0 else f'friction {friction:g}'}"


def place(shape: str) -> float:
    return ASIDE if shape == THREE_AXES else float(shape.split(":")[0])


def of(rows: List[Row], shape: str, kind: Tuple[str, float]) -> List[Row]:
    return [row for row in rows if row["shape"] == shape and (row["protocol"], row["friction"]) == kind]


def mean_and_scatter(rows: List[Row], quantity: str) -> Tuple[float, float]:
    """Mean, and the standard deviation of one realisation."""
    values = [row[quantity] for row in rows]
    return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")


def cell(rows: List[Row], quantity: str, digits: int, grains: int) -> str:
    """With the number of grains where it is another one."""
    if not rows:
        return "not made"
    mean, scatter = mean_and_scatter(rows, quantity)
    size = "" if rows[0]["grains"] == grains else f" ({int(rows[0]['grains'])})"
    return f"{mean:.{digits}f}" + (f" ± {scatter:.{digits}f}" if np.isfinite(scatter) else "") + size


def main() -> None:
    everything = read_csv(HERE / "packings.csv")
    grains = int(max(row["grains"] for row in everything))
    largest: Dict[Tuple[str, str, float], float] = {}
    for row in everything:
        key = (row["shape"], row["protocol"], row["friction"])
        largest[key] = max(row["grains"], largest.get(key, 0))
    rows = [row for row in everything if row["grains"] == largest[row["shape"], row["protocol"], row["friction"]]]
    below = [row for row in everything if row["grains"] < largest[row["shape"], row["protocol"], row["friction"]]]
    small = int(max((row["grains"] for row in below), default=0))
    smaller = [row for row in below if row["grains"] == small]
    published = read_csv(HERE / "published.csv")
    shapes = sorted({row["shape"] for row in rows}, key=place)
    spheroids = [shape for shape in shapes if shape != THREE_AXES]

    figure, axes = plt.subplots(1, 2, figsize=(12, 4.8))
    for plot, quantity in zip(axes, ("solid_fraction", "coordination")):
        for colour, kind in zip(COLOURS, KINDS):
            for group, line in ((spheroids, "-"), ([THREE_AXES], "")):
                there = [shape for shape in group if of(rows, shape, kind)]
                values = [mean_and_scatter(of(rows, shape, kind), quantity) for shape in there]
                plot.errorbar(
                    [place(shape) for shape in there],
                    [mean for mean, _ in values],
                    yerr=[0.0 if np.isnan(scatter) else scatter for _, scatter in values],
                    fmt=f"o{line}",
                    color=colour,
                    markersize=3.5,
                    linewidth=1,
                    capsize=2,
                    label=name(*kind) if group is spheroids else None,
                )
        for row in published:
            if row["quantity"] != quantity:
                continue
            low, high, at = row["low"], row["high"], place(row["shape"])
            plot.plot([0.96 * at, 0.96 * at], [low, high], color="#333333", linewidth=6, alpha=0.25, solid_capstyle="butt")
            if high - low < 0.02:
                plot.plot(0.96 * at, 0.5 * (low + high), marker="D", color="#333333", markersize=4, linestyle="")
            plot.annotate(f"[{int(row['reference'])}]", (0.96 * at, high), xytext=(-3, 4), textcoords="offset points", ha="right", fontsize=7.5)
        plot.set(xscale="log", xlabel="aspect ratio (1 : 1 : 1 is the sphere)")
        ticks = [place(shape) for shape in shapes]
        plot.set_xticks(ticks, [shape if shape == THREE_AXES else f"{place(shape):g}" for shape in shapes], fontsize=7.5, rotation=45)
        plot.minorticks_off()
    axes[0].set_ylabel("solid fraction")
    axes[0].set_ylim(0.4, 0.76)
    axes[0].legend(loc="lower center", ncols=2)
    axes[1].set_ylabel("contacts of a grain that bears load")
    axes[1].axhline(10, color="#333333", linestyle=":", linewidth=1)
    axes[1].axhline(12, color="#333333", linestyle=":", linewidth=1)
    axes[1].annotate("12, 10, 6: twice the degrees of freedom", (0.25, 12.05), fontsize=7.5)
    axes[1].axhline(6, color="#333333", linestyle=":", linewidth=1)
    save(figure, HERE, "Ellipsoids pack more densely than spheres, most of all near aspect ratios 0.6 and 1.5 to 1.8, and with three different axes")

    smooth = ("compressed", 0.0)
    sphere = {quantity: mean_and_scatter(of(rows, "1:1:1", smooth), quantity)[0] for quantity in ("solid_fraction", "coordination")}

    def densest(group: List[str], kind: Tuple[str, float]) -> Tuple[str, float]:
        means = [(mean_and_scatter(of(rows, shape, kind), "solid_fraction")[0], shape) for shape in group if of(rows, shape, kind)]
        best, shape = max(means)
        return f"{place(shape):g}", best

    oblate = densest([shape for shape in spheroids if place(shape) < 1], smooth)
    prolate = densest([shape for shape in spheroids if place(shape) > 1], smooth)
    three = of(rows, THREE_AXES, smooth)
    three_mean = {quantity: mean_and_scatter(three, quantity)[0] for quantity in ("solid_fraction", "coordination")}
    most = max(mean_and_scatter(of(rows, shape, smooth), "coordination")[0] for shape in spheroids)
    rough = [mean_and_scatter(of(rows, shape, ("compressed", 0.5)), "solid_fraction")[0] - mean_and_scatter(of(rows, shape, smooth), "solid_fraction")[0] for shape in shapes if of(rows, shape, ("compressed", 0.5))]
    apart = max(
        (abs(mean_and_scatter(of(rows, shape, ("settled", 0.0)), "solid_fraction")[0] - mean_and_scatter(of(rows, shape, smooth), "solid_fraction")[0]), shape)
        for shape in shapes
        if of(rows, shape, ("settled", 0.0)) and of(rows, shape, smooth)
    )
    aligned = mean_and_scatter(of(rows, apart[1], ("settled", 0.0)), "order")[0]
    slow = [row for row in everything if row["protocol"].endswith(", slowly")]

    def slowly(shape: str, protocol: str, quantity: str) -> Tuple[float, float]:
        """Of the same grains in the beginning: as in the other tables, and made slowly."""
        [ten] = of(slow, shape, (f"{protocol}, slowly", 0.0))
        [one] = [row for row in of(everything, shape, (protocol, 0.0)) if (row["grains"], row["seed"]) == (ten["grains"], ten["seed"])]
        return one[quantity], ten[quantity]

    def slow_table() -> str:
        head = ["axes, protocol", "solid fraction", "slowly", "contacts", "slowly", "grains left out", "slowly"]
        return table(
            head,
            [
                [f"{row['shape']}, {row['protocol'].split(',')[0]}"]
                + [
                    f"{value:.{digits}f}"
                    for quantity, digits in (("solid_fraction", 4), ("coordination", 2), ("rattlers", 3))
                    for value in slowly(row["shape"], row["protocol"].split(",")[0], quantity)
                ]
                for row in slow
            ],
        )

    # One realisation of the smaller size may be as far from the mean as its scatter; the shapes with two tell the scatter.
    def pooled(quantity: str, friction: float) -> float:
        groups = [of(smaller, shape, kind) for shape in shapes for kind in KINDS if kind[1] == friction]
        return float(np.sqrt(np.mean([mean_and_scatter(group, quantity)[1] ** 2 for group in groups if len(group) > 1])))

    def by_size(quantity: str, friction: float) -> Tuple[float, float]:
        """Mean and greatest difference of the larger packings from the smaller ones, over shapes and protocols."""
        changes = [
            mean_and_scatter(of(rows, shape, kind), quantity)[0] - mean_and_scatter(of(smaller, shape, kind), quantity)[0]
            for shape in shapes
            for kind in KINDS
            if kind[1] == friction and of(rows, shape, kind) and of(smaller, shape, kind)
        ]
        return float(np.mean(changes)), float(max(changes, key=abs))

    size_table = table(
        ["quantity", "friction", f"scatter of one realisation of {small}", f"{grains} − {small}, mean", "greatest"],
        [
            [label, f"{friction:g}", f"{pooled(quantity, friction):.{digits}f}", *[f"{value:+.{digits}f}" for value in by_size(quantity, friction)]]
            for quantity, label, digits in (("solid_fraction", "solid fraction", 4), ("coordination", "contacts", 2))
            for friction in (0.0, 0.5)
        ],
    )
    three_quickly, three_slowly = ({quantity: slowly(THREE_AXES, "compressed", quantity)[k] for quantity in ("solid_fraction", "coordination")} for k in (0, 1))
    conclusion = (
        f"Without friction, compressed from a random state, {grains} spheres pack to {sphere['solid_fraction']:.3f} with {sphere['coordination']:.2f} contacts a grain (0.64 and 6 are known). "
        f"Among the aspect ratios tried the densest are {oblate[0]} ({oblate[1]:.3f}) and {prolate[0]} ({prolate[1]:.3f}); known are maxima of about 0.71 near 0.6 and 1.5 to 1.8. "
        f"Axes of {THREE_AXES} pack to {three_mean['solid_fraction']:.3f} with {three_mean['coordination']:.2f} contacts, and {int(slow[0]['grains'])} of them made ten times as slowly to {three_slowly['solid_fraction']:.3f} with {three_slowly['coordination']:.2f}; "
        f"Man et al. measured 0.74 ± 0.005, which is denser by {0.74 - three_mean['solid_fraction']:.3f} and {0.74 - three_slowly['solid_fraction']:.3f}: the solid fraction depends on how a packing is made, and none of these is shaken. "
        f"Spheroids have at most {most:.2f} contacts, fewer than the ten that their five degrees of freedom would take, and three different axes fewer than twelve. "
        f"Friction of 0.5 lowers the solid fraction by {-max(rough):.3f} to {-min(rough):.3f}. "
        f"The two protocols agree for the sphere; without friction they differ most, by {apart[0]:.3f}, at {apart[1]}, which settles with its axes aligned (order {aligned:.2f})."
    )
    realisations = sorted({len(group) for shape in shapes for kind in KINDS for group in [of(rows, shape, kind)] if group and group[0]["grains"] == grains})
    not_so_large = sum(group[0]["grains"] < grains for shape in shapes for kind in KINDS for group in [of(rows, shape, kind)] if group)
    but = f" (of {not_so_large} shapes and protocols there are smaller ones alone, with their number of grains in brackets)" if not_so_large else ""
    how_many = f"{realisations[0]}" if len(realisations) == 1 else f"{realisations[0]} to {realisations[-1]}"

    def quantity_table(quantity: str, digits: int) -> str:
        head = ["axes", *[name(*kind) for kind in KINDS]]
        return table(head, [[shape, *[cell(of(rows, shape, kind), quantity, digits, grains) for kind in KINDS]] for shape in shapes])

    references = "".join(f"{int(row['reference'])}. {row['source']}.\n" for row in {row["reference"]: row for row in published}.values())
    minutes = sum(row["seconds"] for row in rows if row["grains"] == grains) / 60
    parts = [
        f"{grains} equal grains each, {how_many} {'realisation' if how_many == '1' else 'realisations'}{but}; [smaller ones](#size-and-scatter) tell the scatter. "
        f"They took {minutes:.0f} minutes of processor time, side by side on the cores there were. `cargo xtask validate packings -- --go-on` goes on where it was stopped, "
        "`-- --grains 1000 --realisations 3` makes others. Hertz contacts with a restitution of 0.5 and, where there is friction, `tangential tfd 0.5`.",
        "## The protocols\n\n"
        "- **compressed** (`compress.lmp`): grains that do not touch, at random places and in random poses of a periodic cube of solid fraction 0.2. The cube shrinks until the pressure "
        "is 1e-4 of Young's modulus, the grains come to rest, and the pressure is lowered to 1e-6, where the mean overlap of spheres is 1.6e-4 of the diameter and adds 0.0003 to the solid fraction.\n"
        "- **settled** (`settle.lmp`): such grains fall onto a flat floor, periodic along it; at rest, nine tenths of their weight are taken away. Measured in the middle half of the height. "
        "The pressure there is about 5e-6 of the modulus, and overlaps add about 0.001.",
        "## Solid fraction\n\n" + quantity_table("solid_fraction", 4) + "\nOverlaps count twice.",
        "## Coordination\n\nMean number of contacts of the grains that bear load: grains with fewer than 4 contacts (2 with friction) are removed, again and again.\n\n"
        + quantity_table("coordination", 2)
        + "\nContacts close last of all as a packing comes to rest: without friction these numbers are low rather than high (see [below](#made-slowly)).\n"
        + "\nGrains left out, as a share of all:\n\n"
        + quantity_table("rattlers", 3),
        "## Orientation\n\nThe largest eigenvalue of the mean of (3 u u - 1)/2, with u the axis of revolution (the longest of three): 0 without order, 1 where all are parallel; "
        f"{1 / np.sqrt(grains):.2f} is the size of chance.\n\n" + quantity_table("order", 3),
        f"## Made slowly\n\nThe same {int(slow[0]['grains'])} grains without friction, with {SLOWNESS} times the time: compressed as much more slowly and left to rest as much longer, or left to rest as much longer after settling.\n\n"
        + slow_table()
        + f"\nThree different axes, compressed, are {three_slowly['solid_fraction'] - three_quickly['solid_fraction']:.4f} denser made slowly, and have {three_slowly['coordination'] - three_quickly['coordination']:.1f} contacts more. "
        "Their packings take long to come to rest, since frictionless ellipsoids have motions whose energy rises with the fourth power of the displacement alone (Schreck et al., Phys. Rev. E 85, 061305 (2012), arXiv:1201.3965): "
        "at a low pressure these are soft, and the contacts that they would close are still open. "
        "It is one realisation of few grains: the gain in contacts is ten times their scatter, that in solid fraction not more than two or three times.",
        f"## Size and scatter\n\n{small} grains, one or two realisations, beside the {grains} above. The scatter is the standard deviation of one realisation, over the shapes and protocols that have two.\n\n"
        + size_table
        + "\nWhat shapes and protocols differ by is more than that.",
        "## What is known\n\nThe picture shows what could be read in a source; bars are ranges.\n\n" + references + "\n"
        "Without a number of their own in the picture: Zhou et al., Ind. Eng. Chem. Res. (2011), find the maxima of settled spheroids at aspect ratios of 0.6 and 1.80; "
        "Yuan et al., arXiv:1909.12191, find fewer contacts than twice the degrees of freedom. The 0.71 of the maxima is the value commonly given after "
        "Donev et al., Science 303, 990 (2004), whose figure could not be read here.",
    ]
    write(HERE, "Random packings of ellipsoids", conclusion, parts, ["packings.csv", "published.csv"])


if __name__ == "__main__":
    main()
