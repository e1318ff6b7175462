# SPDX-License-Identifier: MIT OR Apache-2.0
"""docs/report/stress.md and the stored tables of a run of `cargo xtask stress`: `page.py DIRECTORY`, the one the run is kept in."""

import csv
import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parent.parent / "docs" / "report" / "stress.md"


def table(head, rows):
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)


def read_csv(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def write_csv(path, rows, names):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def grouped(number):
    return f"{int(number):,}".replace(",", " ")


def short(value):
    """Three digits."""
    value = float(value)
    return f"{value:.3g}" if 1e-3 <= abs(value) < 1e4 or value == 0 else f"{value:.0e}"


WRONG = {
    "Refused": "refused",
    "NotFinite": "not finite",
    "NotTheLeast": "not the global minimum",
    "Differs": "paths differ",
}
COUNTS = ["pairs", "touching", *WRONG, "equal_minima", "at_rounding", "not_isolated", "by_brute_force", "slowest_microseconds"]


def counts(state):
    rows = []
    for family, c in state["families"].items():
        row = {"family": family, "blocks": c["blocks"], "slowest_microseconds": c["slowest_nanoseconds"] / 1000}
        row.update({key: c["wrong"].get(key, 0) for key in WRONG})
        row.update({key: c[key] for key in ("pairs", "touching", "equal_minima", "at_rounding", "not_isolated", "by_brute_force")})
        rows.append(row)
    return rows


def pairs_part(state, rows):
    total = {key: sum(row[key] for row in rows) for key in COUNTS[:-1]}
    total["slowest_microseconds"] = max(row["slowest_microseconds"] for row in rows)

    def line(name, row):
        return [
            name,
            grouped(row["pairs"]),
            grouped(row["touching"]),
            *[grouped(row[key]) for key in WRONG],
            grouped(row["equal_minima"]),
            grouped(row["at_rounding"]),
            grouped(row["not_isolated"]),
            f"{row['slowest_microseconds']:.0f}",
        ]

    head = ["family", "pairs", "contacts", *WRONG.values(), "equal minima", "at rounding", "flat minimum", "slowest search, µs"]
    text = "## Pairs\n\n" + table(head, [line(row["family"], row) for row in rows] + [line("**all**", total)])
    return text + (
        "\n- **contacts**: pairs that touch, counted in each of two steps: the first with nothing remembered, the second from the normal of the first.\n"
        "- **refused**: a pair within all ranges ended in an error. **not finite**: a force, torque or number of the history is none.\n"
        "- **not the global minimum**: the penetration along the normal that a path found exceeds what another path found, or the least of hundreds of descents "
        f"(one contact in 256: {grouped(total['by_brute_force'])} of them), by more than a millionth and rounding.\n"
        "- **paths differ**: force, torque, or history of an instruction set differ from the scalar path's by more than 64 times what one unit in the last place of the "
        "pair's own numbers changes in the scalar path, and by more than 1e-12 and 1e-13 times the aspect ratio, by which the lanes may leave the curvature off, of the largest number of the "
        "kind. Pairs of which two paths took equal minima are not compared in the second step.\n"
        "- **equal minima** are no error: two paths found normals of the same penetration that are more than 1e-6 apart, and each is right; their forces are not compared. So are differences **at rounding**: more than 1e-12, and "
        "explained by the last places of the input.\n"
        "- **flat minimum**: no isolated minimum to rounding, a ring or a valley of equal ones, as coincident discs have. Newton's method has nothing to converge to there; "
        "what it ends with is held against the other paths like any other answer.\n"
        "- **slowest search**: from nothing, of one pair in 8, on a processor that others used as well.\n"
    )


def instruction_sets(state, pairs):
    """Those that all pairs went through, then the others with how many did: a run goes on on machines that have more, or fewer."""
    by_set = state["pairs_by_instruction_set"]
    order = sorted(by_set, key=lambda name: (-by_set[name], ["scalar", "baseline", "avx2", "avx512", "neon"].index(name)))
    return ", ".join(name if by_set[name] == pairs else f"{name} {grouped(by_set[name])} of them" for name in order)


def findings_part(state):
    """The findings, and known.md: what is known of them and of those of earlier runs, written by hand."""
    lines = []
    for family, c in state["families"].items():
        for f in c["findings"]:
            lines.append(f"- {family}, block {f['block']}, pair {f['pair']}, step {f['step']}, law `{f['deck']}`: {f['words']}")
    lines += [f"- {words}" for words in state["refusals"]["wrong"]]
    text = "## What was found wrong\n\n"
    return text + ("\n".join(lines) + "\n" if lines else "Nothing that is wrong now.\n") + "\n" + (HERE / "known.md").read_text()


def billion_part(state, pairs):
    """What it takes to get to the pairs that are aimed at."""
    rate, aim = pairs / state["seconds"], 1e9
    text = f"\n{grouped(pairs)} pairs took {grouped(state['seconds'])} s of processor time, {grouped(rate)} pairs a second."
    if pairs < aim:
        text += f" The aim of 1e9 pairs would take {aim / rate / 3600:.0f} hours of a core: this is {100 * pairs / aim:.2g} % of it."
    return text + "\n"


def reference_part(rows):
    families = {}
    for row in rows:
        families.setdefault(row["family"], []).append(row)

    def line(name, rows):
        most = {key: max(float(row[key]) for row in rows) for key in ("excess", "force_error", "units_of_rounding")}
        return [
            name,
            len(rows),
            sum(row["why"] != "random" for row in rows),
            sum(int(row["forces_compared"]) for row in rows),
            sum(bool(row["wrong"]) for row in rows),
            short(most["excess"]),
            short(most["force_error"]),
            short(most["units_of_rounding"]),
        ]

    head = ["family", "pairs", "of them worst or slowest", "forces", "wrong", "penetration", "force, relative", "force, of what is allowed"]
    text = (
        "## A sample against 60 digits\n\n"
        "Pairs drawn at random, those whose paths differed most, those of the slowest searches, and all findings, at rest and elastic, against "
        "the reference in `validation/reference`, which finds the contact by another formulation. On each instruction set, with the force along the normal and with "
        "the complete gradient. Where several minima are equally deep, or the contact is deeper than the closed form of the gradient, penetrations alone are compared.\n\n"
        + table(head, [line(name, rows) for name, rows in families.items()] + [line("**all**", rows)])
    )
    text += (
        "\nThe penetration that was found exceeds the exact one by at most so many times 64 roundings of the size of the bodies. The largest relative error of a force is that of the "
        "smallest overlaps, in which few digits of the coordinates are left; the last column is the error over 64 times what rounding of the input explains.\n"
    )
    wrong = [f"- {row['family']}, block {row['block']}, pair {row['pair']}, step {row['step']}: {row['wrong']}" for row in rows if row["wrong"]]
    return text + ("\nWrong:\n\n" + "\n".join(wrong) + "\n" if wrong else "")


def refusals_part(state):
    refusals = state["refusals"]
    return (
        "## Out of range\n\n"
        f"{grouped(refusals['tried'])} inputs, each number of a body in turn not finite, zero, negative, denormal or too large, among sound pairs and on each instruction set: "
        f"{len(refusals['wrong'])} were not refused in words that name the particle and the value. Nothing is written then.\n\n"
        + table(["words", "times"], [["`" + words + "`", grouped(times)] for words, times in refusals["words"].items()])
    )


def stability_part(rows):
    body, off, gains, room = [], [], [], []
    ratios = list(dict.fromkeys(row["mass_ratio"] for row in rows))
    for shape in ("spheres", "ellipsoids"):
        for deck in dict.fromkeys(row["deck"] for row in rows):
            cells = []
            for ratio in ratios:
                row = next(r for r in rows if (r["deck"], r["shape"], r["mass_ratio"]) == (deck, shape, ratio))
                number = {key: float(row[key]) for key in ("critical", "critical_found", "advised", "gain", "collision_found")}
                small = number["critical_found"] / number["critical"]
                longest = number["collision_found"] / number["advised"]
                off.append(abs(small - 1))
                gains.append(number["gain"])
                room.append(longest)
                cells += [f"{small:.3f}", f"{100 * number['gain']:.2f} %".replace("-", "−"), f"{longest:.2g}"]
            body.append([f"{shape}, `{deck}`", *cells])
    head = ["law"]
    for ratio in ratios:
        head += [f"{float(ratio):g}: critical", "energy", "1 % at"]
    return (
        "## Steps up to and beyond stability\n\n"
        "Two grains of 1 mm, spheres or ellipsoids of 2:1:1.3 that meet obliquely, the lighter of 10 mg, the other so many times as heavy; from no damping to overdamped.\n\n"
        "- **critical**: the largest step with which small motions about the contact do not grow, over the critical step that the library says (`src/contact/stability.rs`, "
        "`ellgran_contact_stiffness`). Overlap of 1e-5 of the radius.\n"
        "- **energy**: how the energy changes in a collision at 0.1 m/s with the step that LAMMPS' plugin advises, which is the critical one at the deepest overlap or a tenth of the "
        "elastic collision's time; the largest of 16 collisions that begin at another time within a step.\n"
        "- **1 % at**: the largest step, in advised ones, with which no collision leaves 1 % more energy than it found.\n\n"
        + table(head, body)
        + f"\nIn all {len(rows)} cases the critical step is where small motions become unstable, to {100 * max(off):.1f} %. With the advised step a collision gains {100 * max(gains):.2g} % of its "
        f"energy at most; steps {min(room):.2g} times as long are needed for 1 %. It is the undamped collisions that gain, and what they gain falls with the step.\n"
    )


def page(state, origin, reference, stability):
    """The text of the page."""
    rows = counts(state)
    pairs = sum(row["pairs"] for row in rows)
    wrong = sum(row[key] for row in rows for key in WRONG)
    wrong_reference = sum(bool(row["wrong"]) for row in reference)
    sets = instruction_sets(state, pairs)
    verb = "is" if wrong == 1 else "are"
    text = (
        "# Stiff and extreme\n\n"
        f"**Conclusion.** Of {grouped(pairs)} pairs made to be hard, through the neighbour-list path on each instruction set ({sets}), {grouped(wrong)} {verb} wrong; of a sample of "
        f"{len(reference)}, with the worst, {wrong_reference} are wrong against 60 digits. Nothing hung: the slowest search took "
        f"{max(row['slowest_microseconds'] for row in rows) / 1000:.2g} ms.\n\n"
        "Each block of 64 pairs has a law of its own: Hertz, NFD or LSD with Young's modulus 1e3 to 1e13, friction 0 to 1e3, from no damping to relaxation times of 1e7 steps, all "
        "kinds of tangential laws. Masses differ by up to 1e9, speeds by eight decades: in a step the bodies move by 1e-9 to 0.1 of their overlap.\n\n"
    )
    text += "\n".join([pairs_part(state, rows) + billion_part(state, pairs), findings_part(state), reference_part(reference), refusals_part(state), stability_part(stability)])
    machine = "; ".join(line for line in origin["machine"] if not line.startswith("load"))
    text += (
        f"\n## Where the numbers come from\n\n`{origin['command']}`, ellgran {origin['version']}, seed {state['seed']}, {round(state['seconds'])} s of processor time, on a machine that others shared "
        f"({machine}). `cargo xtask stress` goes on where the last run stopped, for `--minutes`, `--hours`, `--night`, or until there are so many `--pairs`; with `--stored` it goes on with this run. A pair is had again by family "
        "(counted from 0 in the order of `Family::ALL`), block and number: `cargo bench --bench stress -- pair FAMILY BLOCK PAIR`; `block FAMILY BLOCK` tries a whole block again, with descents for each contact, `again` those of all findings. The numbers: "
        "[counts.csv](../../validation/stress/counts.csv), [reference.csv](../../validation/stress/reference.csv), [stability.csv](../../validation/stress/stability.csv), "
        "[origin.json](../../validation/stress/origin.json).\n"
    )
    return text


def main():
    run = pathlib.Path(sys.argv[1])
    state = json.loads((run / "state.json").read_text())
    origin = json.loads((run / "origin.json").read_text())
    reference, stability = read_csv(run / "reference.csv"), read_csv(run / "stability.csv")
    rows = counts(state)
    origin.update(seed=state["seed"], seconds=round(state["seconds"]), pairs_by_instruction_set=state["pairs_by_instruction_set"])
    write_csv(HERE / "counts.csv", rows, ["family", "blocks", *COUNTS])
    write_csv(HERE / "reference.csv", reference, list(reference[0]))
    write_csv(HERE / "stability.csv", stability, list(stability[0]))
    (HERE / "origin.json").write_text(json.dumps(origin, indent=2) + "\n")
    (HERE / "state.json").write_text(json.dumps(state, indent=1) + "\n")
    text = page(state, origin, reference, stability)
    PAGE.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
