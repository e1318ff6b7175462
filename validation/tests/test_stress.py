# SPDX-License-Identifier: MIT OR Apache-2.0
"""The page of the stored run of hard pairs is that of its files, and its program runs on the Python of the other chapters."""
import json
from pathlib import Path
from types import SimpleNamespace

STORED = Path(__file__).resolve().parent.parent / "stress"


def test_the_page_is_that_of_the_stored_run(stress: SimpleNamespace) -> None:
    state, origin = (json.loads((STORED / name).read_text()) for name in ("state.json", "origin.json"))
    reference, stability = (stress.page.read_csv(STORED / name) for name in ("reference.csv", "stability.csv"))
    assert stress.page.page(state, origin, reference, stability) == stress.page.PAGE.read_text()


def test_the_stored_run_is_on_all_sets_and_has_the_pairs_of_its_families(stress: SimpleNamespace) -> None:
    state = json.loads((STORED / "state.json").read_text())
    pairs = sum(row["pairs"] for row in stress.page.counts(state))
    sets = state["pairs_by_instruction_set"]
    assert {"scalar", "baseline", "avx2"} <= set(sets)
    assert all(sets[name] == pairs for name in ("scalar", "baseline", "avx2"))
    assert 0 < sets.get("avx512", pairs) <= pairs
