# SPDX-License-Identifier: MIT OR Apache-2.0
"""The notebook runs, and its decks do through LAMMPS what it promises."""
import os
import re
import subprocess
from pathlib import Path

import pytest

import ellgran

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOK = Path(__file__).parents[1] / "notebooks" / "from_restitution_to_deck.ipynb"


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """The folder where it ran, and what it printed."""
    folder = tmp_path_factory.mktemp("notebook")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "keep the notebook without outputs"
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(folder)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    return folder, "".join(output.get("text", "") for output in outputs)


def test_from_a_measured_restitution_to_a_deck(executed):
    folder, printed = executed
    assert "pair_coeff 1 1 ${law}" in printed and "StepAdvice(critical=" in printed
    assert (folder / "drop.lmp").is_file() and (folder / "box.lmp").is_file()


@pytest.mark.skipif("ELLGRAN_TEST_LAMMPS" not in os.environ, reason="ELLGRAN_TEST_LAMMPS names no LAMMPS")
def test_its_decks_run_and_show_the_restitution(executed):
    folder, _ = executed

    def run(*words):
        command = [os.environ["ELLGRAN_TEST_LAMMPS"], "-var", "plugin", os.environ["ELLGRAN_TEST_LAMMPS_PLUGIN"], *words]
        return subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout

    found = re.search(r"^restitution ([\d.]+)$", run("-in", "drop.lmp"), re.M)
    assert found and float(found.group(1)) == pytest.approx(0.82, abs=3e-3)
    assert "WARNING" not in run("-in", "box.lmp", "-var", "steps", "200")
    packing = ellgran.last_frame(folder / "grains.dump").packing(density=2500)
    assert len(packing.bodies) == 64
    assert packing.bodies.semi_axes[0] == pytest.approx([2e-3, 1.5e-3, 1e-3])
