# SPDX-License-Identifier: MIT OR Apache-2.0
"""Dumps of LAMMPS: every form of box and position; and a restart file, through a real LAMMPS where there is one."""
import gzip
import os
import subprocess

import numpy as np
import pytest

import ellgran

UPRIGHT = """ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp ff
-1.0 3.0
0.0 5.0
0.0 6.0
ITEM: ATOMS id type x y z c_quat[1] c_quat[2] c_quat[3] c_quat[4] c_shape[1] c_shape[2] c_shape[3]
7 1 0.5 1.0 {z} 1 0 0 0 2.0 1.0 1.0
3 2 1.5 1.0 1.0 0.6 0.8 0 0 1.0 1.0 1.5
"""


def test_grains_of_each_step(tmp_path):
    path = tmp_path / "grains.dump"
    path.write_text(UPRIGHT.format(step=0, z=1) + UPRIGHT.format(step=500, z=2.5))
    frames = list(ellgran.read_dump(path))
    assert [frame.step for frame in frames] == [0, 500] and len(frames[0]) == 2
    packing = frames[1].packing(density=3.0)
    bodies = packing.bodies
    assert bodies.positions.tolist() == [[0.5, 1.0, 2.5], [1.5, 1.0, 1.0]]
    assert bodies.semi_axes.tolist() == [[1.0, 0.5, 0.5], [0.5, 0.5, 0.75]]
    assert bodies.quaternions[1].tolist() == [0.6, 0.8, 0, 0]
    assert bodies.quaternions_xyzw[1].tolist() == [0.8, 0, 0, 0.6]
    assert bodies.identifiers.tolist() == [7, 3] and bodies.types.tolist() == [1, 2]
    assert bodies.masses[0] == pytest.approx(3.0 * 4 / 3 * np.pi * 0.25)
    assert packing.box.origin.tolist() == [-1.0, 0.0, 0.0] and packing.box.periodic.tolist() == [True, True, False]
    assert packing.box.volume == pytest.approx(120.0)
    assert ellgran.last_frame(path).step == 500
    with gzip.open(tmp_path / "grains.dump.gz", "wt") as file:
        file.write(path.read_text())
    assert len(list(ellgran.read_dump(tmp_path / "grains.dump.gz"))) == 2


def test_a_tilted_box_and_scaled_positions(tmp_path):
    path = tmp_path / "tilted.dump"
    # lx 4, ly 5, lz 6, xy 1, xz -2, yz 0.5.
    path.write_text(
        "ITEM: UNITS\nsi\nITEM: TIME\n0.25\nITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n1\n"
        "ITEM: BOX BOUNDS xy xz yz pp pp pp\n-2.0 5.0 1.0\n0.0 5.5 -2.0\n0.0 6.0 0.5\n"
        "ITEM: ATOMS id element xs ys zs quatw quati quatj quatk shapex shapey shapez mass vx vy vz angmomx angmomy angmomz\n"
        "1 Si 0.5 0.5 0.5 0 0 0 1 2 4 6 2 0.1 0.2 0.3 1.0 2.0 3.0\n"
    )
    frame = next(ellgran.read_dump(path))
    assert frame.time == 0.25 and frame.columns["element"].tolist() == ["Si"]
    box = frame.box
    assert box.origin.tolist() == [0, 0, 0]
    assert box.edges.tolist() == [[4, 0, 0], [1, 5, 0], [-2, 0.5, 6]]
    bodies = frame.packing().bodies
    assert bodies.positions[0] == pytest.approx([1.5, 2.75, 3.0])
    assert bodies.masses.tolist() == [2.0] and bodies.velocities[0].tolist() == [0.1, 0.2, 0.3]
    # A half turn about z: moments along the world axes are those along the body axes.
    moments = 2.0 / 5.0 * np.array([4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0])
    assert bodies.angular_velocities[0] == pytest.approx(np.array([1.0, 2.0, 3.0]) / moments)
    assert bodies.inertia[0] == pytest.approx(moments)


def test_what_is_no_dump_is_said(tmp_path):
    path = tmp_path / "no.dump"
    path.write_text("2\ncomment\nSi 0 0 0\n")
    with pytest.raises(ValueError, match="ITEM:"):
        list(ellgran.read_dump(path))
    path.write_text("".join(UPRIGHT.format(step=0, z=1).splitlines(True)[:-1]))
    with pytest.raises(ValueError, match="step 0 ends after 1 of 2 lines"):
        list(ellgran.read_dump(path))
    path.write_bytes(b"\x00\xe8\xff" * 40)
    with pytest.raises(ValueError, match="no.dump is no text dump of LAMMPS"):
        list(ellgran.read_dump(path))
    path.write_text("")
    with pytest.raises(ValueError, match="is empty"):
        ellgran.last_frame(path)
    path.write_text(UPRIGHT.format(step=0, z=1).replace("c_shape", "c_size"))
    with pytest.raises(KeyError, match="diameters.*shapex shapey shapez"):
        ellgran.last_frame(path).packing()
    named = ellgran.last_frame(path).packing(diameters=["c_size[1]", "c_size[2]", "c_size[3]"])
    assert named.bodies.semi_axes[0].tolist() == [1.0, 0.5, 0.5]
    path.write_text(UPRIGHT.format(step=0, z=1).replace("1.0 1.0 1.5\n", "0 0 0\n"))
    with pytest.raises(ValueError, match="particle 3: diameters"):
        ellgran.last_frame(path).packing()


DECK = """
plugin load {plugin}
units si
atom_style ellipsoid
boundary p p p
comm_modify vel yes
newton on
region box block 0 0.03 0 0.03 0 0.03
create_box 1 box
lattice sc 0.01
create_atoms 1 box
set type 1 shape 0.0125 0.0095 0.0095
set type 1 density 2500
set type 1 quat/random 4711
velocity all create 1.0 87287 loop geom
velocity all set 0.2 NULL NULL sum yes
pair_style gran/ellipsoid
pair_coeff 1 1 {law}
neighbor 0.002 bin
fix integrate all nve/asphere
compute quat all property/atom quatw quati quatj quatk
compute shape all property/atom shapex shapey shapez
compute atoms all property/local patom1 patom2
compute contact all pair/local p12 p9 p10 p11 p17 p18 p19
dump grains all custom 400 grains.dump id type x y z c_quat[*] c_shape[*]
dump_modify grains format float %.17g
dump contacts all local 400 contacts.dump index c_atoms[*] c_contact[*]
dump_modify contacts format float %.17g
timestep 1e-5
run 400
write_restart frame.restart
"""


@pytest.mark.skipif("ELLGRAN_TEST_LAMMPS" not in os.environ, reason="ELLGRAN_TEST_LAMMPS names no LAMMPS")
def test_dumps_and_restart_of_a_run(tmp_path):
    lammps, plugin = os.environ["ELLGRAN_TEST_LAMMPS"], os.environ["ELLGRAN_TEST_LAMMPS_PLUGIN"]
    law = "nfd 3e6 0.3 200 200 tangential tfd 0.5"
    (tmp_path / "deck.lmp").write_text(DECK.format(plugin=plugin, law=law))
    subprocess.run([lammps, "-in", "deck.lmp"], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    packing = ellgran.last_frame(tmp_path / "grains.dump").packing(density=2500)
    assert sorted(packing.bodies.semi_axes[0]) == pytest.approx([0.00475, 0.00475, 0.00625])

    # Every contact of the engine, with its penetration and normal.
    found = packing.contacts(law)
    names = np.sort(packing.bodies.identifiers[found.pairs], axis=1)
    ours = {tuple(pair): k for k, pair in enumerate(names.tolist())}
    local = ellgran.last_frame(tmp_path / "contacts.dump")
    touching = local.columns["c_contact[1]"] > 0.0
    atoms = local.array("c_atoms[1]", "c_atoms[2]").astype(int)[touching]
    depth, normal = local.columns["c_contact[1]"][touching], local.array(*[f"c_contact[{k}]" for k in (2, 3, 4)])[touching]
    assert len(found) == len(atoms) > 25
    for pair, one_depth, one_normal in zip(atoms, depth, normal):
        k = ours[tuple(sorted(pair.tolist()))]
        assert found.penetration[k] == pytest.approx(one_depth, abs=1e-12)
        assert np.abs(found.normal[k] @ one_normal) == pytest.approx(1.0, abs=1e-9)

    # What the restart file remembers is what acted last.
    grains, contacts = ellgran.read_restart(tmp_path / "frame.restart", lammps=[lammps], plugin=plugin)
    assert len(grains.bodies) == len(packing.bodies) and len(contacts) == len(atoms)
    displacements = local.array(*[f"c_contact[{k}]" for k in (5, 6, 7)])[touching]
    by_pair = {tuple(sorted(pair)): d for pair, d in zip(atoms.tolist(), displacements)}
    signs = {tuple(sorted(pair)): np.sign(pair[1] - pair[0]) for pair in atoms.tolist()}
    largest = np.abs(displacements).max()
    assert largest > 0.0
    for pair, displacement in zip(contacts.identifiers.tolist(), contacts.displacement):
        key = tuple(sorted(pair))
        sign = signs[key] * np.sign(pair[1] - pair[0])
        assert displacement == pytest.approx(sign * by_pair[key], abs=1e-3 * largest)
    with pytest.raises(RuntimeError, match="ERROR"):
        ellgran.read_restart(tmp_path / "deck.lmp", lammps=[lammps], plugin=plugin)
