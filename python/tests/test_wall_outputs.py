# SPDX-License-Identifier: MIT OR Apache-2.0
"""What walls write, through a real LAMMPS: the stress on triangles by VTK's own reader, and their contacts in OVITO beside those of pairs."""
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

needs_lammps = pytest.mark.skipif("ELLGRAN_TEST_LAMMPS" not in os.environ, reason="ELLGRAN_TEST_LAMMPS names no LAMMPS")

#: A floor of eight triangles, 40 mm wide, in millimetres.
CORNERS = [(x, y, 0) for x in (-20, 0, 20) for y in (-20, 0, 20)]
TRIANGLES = [t for k in (0, 1, 3, 4) for t in ((k, k + 3, k + 4), (k, k + 4, k + 1))]

DECK = """
plugin load {plugin}
units si
atom_style ellipsoid
boundary f f f
comm_modify vel yes
region box block -0.02 0.02 -0.02 0.02 -0.005 0.03
create_box 1 box
lattice sc 0.008
region fill block -0.013 0.013 -0.013 0.013 0.003 0.02 units box
create_atoms 1 region fill
set type 1 shape 0.0075 0.0045 0.0045
set type 1 density 2500
set type 1 quat/random 4711
pair_style gran/ellipsoid
pair_coeff 1 1 {law}
neighbor 0.001 bin
fix integrate all nve/ellipsoid
fix gravity all gravity 9.81 vector 0 0 -1
fix hopper all wall/gran/ellipsoid {law} mesh floor.stl scale 0.001 contacts vtk 10000 floor.*.vtk
fix side all wall/gran/ellipsoid {law} xplane -0.014 0.014
fix front all wall/gran/ellipsoid {law} yplane -0.014 0.014
{commands}
thermo_style custom step f_hopper[14] f_hopper[15] f_hopper[16] f_hopper[10]
thermo_modify format float %.15g
timestep 2e-5
run 10000
"""


def stl():
    lines = ["solid floor"]
    for triangle in TRIANGLES:
        lines += ["facet normal 0 0 1", "outer loop", *("vertex {} {} {}".format(*CORNERS[k]) for k in triangle), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid floor", ""])


def run(folder, commands=""):
    """The last row of the thermo output."""
    (folder / "floor.stl").write_text(stl())
    lammps, plugin = os.environ["ELLGRAN_TEST_LAMMPS"], os.environ["ELLGRAN_TEST_LAMMPS_PLUGIN"]
    (folder / "deck.lmp").write_text(DECK.format(plugin=plugin, law="nfd 3e6 0.3 200 200 tangential tfd 0.5", commands=commands))
    output = subprocess.run([lammps, "-in", "deck.lmp"], cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
    row = re.findall(r"^ +10000 .*$", output, re.M)[-1].split()
    return np.array([float(word) for word in row[1:4]]), int(row[4])


def last_rows(path):
    """The columns of the last step of a dump of LAMMPS, by their names."""
    lines = path.read_text().split("ITEM: TIMESTEP\n")[-1].splitlines()
    [at] = [k for k, line in enumerate(lines) if line.startswith(("ITEM: ENTRIES ", "ITEM: ATOMS "))]
    rows = np.array([[float(word) for word in line.split()] for line in lines[at + 1 :]])
    return dict(zip(lines[at].split()[2:], rows.T))


@needs_lammps
def test_vtk_reads_the_stress_on_triangles(tmp_path):
    pyvista = pytest.importorskip("pyvista", exc_type=ImportError)
    force, contacts = run(tmp_path)
    assert contacts > 4
    mesh = pyvista.read(tmp_path / "floor.10000.vtk")
    assert mesh.n_cells == len(TRIANGLES) and mesh.is_all_triangles
    assert set(mesh.cell_data.keys()) == {"force", "area", "normal_stress", "shear_stress"}
    assert np.allclose(mesh["force"].sum(axis=0), force, atol=1e-6 * np.abs(force).max())
    area = mesh.compute_cell_sizes(length=False, volume=False)["Area"]
    assert np.allclose(mesh["area"], area) and area.sum() == pytest.approx(0.04**2)
    # A flat floor with grains above it: what presses is the force along -z.
    assert np.allclose(mesh["normal_stress"] * area, -mesh["force"][:, 2], atol=1e-6 * np.abs(force).max())
    assert np.allclose(mesh["shear_stress"] * area, np.linalg.norm(mesh["force"][:, :2], axis=1), atol=1e-6 * np.abs(force).max())
    # Nothing touches in the first step of the file series.
    assert not pyvista.read(tmp_path / "floor.0.vtk")["force"].any()


@needs_lammps
def test_ovito_shows_the_contacts_of_walls_beside_the_network(tmp_path):
    """The dumps of the plugin's page: bonds of pairs, and a particle at each contact with the wall."""
    pytest.importorskip("ovito")
    from ovito.io import import_file
    from ovito.modifiers import LoadTrajectoryModifier

    page = (Path(__file__).parents[2] / "lammps-plugin" / "README.md").read_text()
    [recipe] = re.findall(r"^compute ends all property/local.*?(?=^```)", page, re.M | re.S)
    of_walls = re.search(r"^dump wall all local 1000 .*\ndump_modify wall .*$", page, re.M)[0]
    commands = (recipe + of_walls).replace(" 1000 ", " 10000 ")
    commands += "\ndump grains all custom 10000 grains.dump id type x y z\ndump_modify grains sort id"
    force, contacts = run(tmp_path, commands)

    def columns(title):
        words = re.search(rf"^{title}: (.*)\.$", page, re.M)[1].replace("`", "").split(",")
        return [None if word.strip() == "none" else word.strip() for word in words]

    pipeline = import_file(str(tmp_path / "grains.dump"))
    modifier = LoadTrajectoryModifier()
    modifier.source.load(str(tmp_path / "network.dump"), columns=columns("Columns for OVITO"))
    pipeline.modifiers.append(modifier)
    last = pipeline.source.num_frames - 1
    bonds = pipeline.compute(last).particles.bonds
    normal_forces = last_rows(tmp_path / "network.dump")["c_link[2]"]
    assert (normal_forces > 0).sum() > 4
    assert np.allclose(np.sort(np.asarray(bonds["Normal force"])), np.sort(normal_forces), rtol=1e-5)

    at_wall = import_file(str(tmp_path / "wall.dump"), columns=columns("Columns of the contacts with a wall for OVITO"))
    data = at_wall.compute(at_wall.source.num_frames - 1)
    points = np.asarray(data.particles.positions)
    rows = last_rows(tmp_path / "wall.dump")
    assert len(points) == contacts > 4
    assert np.allclose(points, np.column_stack([rows[f"f_hopper[{k}]"] for k in (3, 4, 5)]), atol=1e-6)
    assert np.abs(points[:, 2]).max() < 1e-4
    forces = np.asarray(data.particles["Force"])
    assert np.allclose(-forces.sum(axis=0), force, rtol=1e-4, atol=1e-5 * np.abs(force).max())
