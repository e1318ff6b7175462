# SPDX-License-Identifier: MIT OR Apache-2.0
"""LAMMPS' text dumps of grains and of contacts, and what a restart file holds of both, as arrays."""
from __future__ import annotations

import gzip
import os
import subprocess
import tempfile
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import IO, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bodies import Bodies, Floats
from .packings import Box, Packing

#: Names under which decks commonly dump the four numbers of a quaternion and the three diameters.
_QUATERNIONS = [
    ["c_quat[1]", "c_quat[2]", "c_quat[3]", "c_quat[4]"],
    ["quatw", "quati", "quatj", "quatk"],
    ["c_orient[1]", "c_orient[2]", "c_orient[3]", "c_orient[4]"],
]
_DIAMETERS = [
    ["c_shape[1]", "c_shape[2]", "c_shape[3]"],
    ["shapex", "shapey", "shapez"],
    ["c_diameter[1]", "c_diameter[2]", "c_diameter[3]"],
]


@dataclass
class Frame:
    """One step of a dump.

    Attributes
    ----------
    step : int
        Number of the time step.
    time : float or None
        Simulated time, where the dump has it (``dump_modify time yes``).
    box : Box
    columns : dict of str to numpy.ndarray, shape (n,)
        By the names that the dump gives them; floats, but integers for ``id``, ``type``, ``mol`` and texts where there are some.
    """

    step: int
    time: Optional[float]
    box: Box
    columns: Dict[str, NDArray] = field(repr=False)

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def array(self, *names: str) -> Floats:
        """Some columns side by side, shape (n, number of names)."""
        missing = [name for name in names if name not in self.columns]
        if missing:
            raise KeyError(f"the dump has no column {missing[0]}, it has {' '.join(self.columns)}")
        return np.ascontiguousarray(np.stack([self.columns[name].astype(np.float64) for name in names], axis=1))

    def packing(
        self,
        *,
        quaternion: Optional[Sequence[str]] = None,
        diameters: Optional[Sequence[str]] = None,
        density: Optional[ArrayLike] = None,
    ) -> Packing:
        """The grains of a dump of atoms.

        Parameters
        ----------
        quaternion : 4 names of columns, optional
            ``w x y z``; default: ``c_quat[1]`` to ``[4]``, as of ``compute quat all property/atom quatw quati quatj quatk``.
        diameters : 3 names of columns, optional
            What ``compute shape all property/atom shapex shapey shapez`` prints; default: ``c_shape[1]`` to ``[3]``. Semi-axes
            are their halves.
        density : array_like, optional
            Mass/volume, where the dump has no ``mass``; default: 1.

        Returns
        -------
        Packing
            Positions from ``x y z``, ``xu yu zu``, ``xs ys zs`` or ``xsu ysu zsu``; velocities from ``vx vy vz``, angular velocities
            from ``omegax ...`` or, with masses, from ``angmomx ...``, where they are there; identifiers from ``id``.
        """
        quaternions = self.array(*self._names(quaternion, _QUATERNIONS, "quaternion", "quatw quati quatj quatk"))
        axes = 0.5 * self.array(*self._names(diameters, _DIAMETERS, "diameters", "shapex shapey shapez"))
        columns = self.columns
        wrong = np.flatnonzero(~(axes > 0.0).all(axis=1))
        if len(wrong):
            name = columns["id"][wrong[0]] if "id" in columns else wrong[0]
            raise ValueError(f"particle {name}: diameters {(2.0 * axes[wrong[0]]).tolist()} are none of an ellipsoid")
        for letters, scaled in (("", False), ("u", False), ("s", True), ("su", True)):
            names = [axis + letters for axis in "xyz"]
            if all(name in columns for name in names):
                positions = self.array(*names)
                if scaled:
                    positions = positions @ self.box.edges + self.box.origin
                break
        else:
            raise KeyError(f"the dump has no positions x y z, it has {' '.join(columns)}")
        bodies = Bodies(
            positions,
            axes,
            quaternions,
            velocities=self.array("vx", "vy", "vz") if "vx" in columns else None,
            masses=columns["mass"] if "mass" in columns else None,
            density=density if "mass" not in columns else None,
            types=columns["type"] if "type" in columns else 1,
            identifiers=columns.get("id"),
        )
        if "omegax" in columns:
            bodies.angular_velocities = self.array("omegax", "omegay", "omegaz")
        elif "angmomx" in columns and ("mass" in columns or density is not None):
            rotations = bodies.rotations
            momenta = np.einsum("kji,kj->ki", rotations, self.array("angmomx", "angmomy", "angmomz"))
            bodies.angular_velocities = np.einsum("kij,kj->ki", rotations, momenta / bodies.inertia)
        return Packing(bodies, self.box)

    def _names(
        self, given: Optional[Sequence[str]], usual: List[List[str]], parameter: str, property_atom: str
    ) -> Sequence[str]:
        if given is not None:
            return given
        for names in usual:
            if all(name in self.columns for name in names):
                return names
        raise KeyError(
            f"the dump has no column {usual[0][0]}, it has {' '.join(self.columns)}: name the columns in {parameter}, or dump a "
            f"compute property/atom {property_atom}"
        )


def read_dump(path: Union[str, os.PathLike]) -> Iterator[Frame]:
    """The steps of a text dump of LAMMPS, one after the other: ``dump custom`` and ``dump local``, also packed by gzip.

    Parameters
    ----------
    path : str or path

    Yields
    ------
    Frame

    Raises
    ------
    ValueError
        The file is no text dump, or ends within a step.
    """
    opened = gzip.open(path, "rt") if str(path).endswith(".gz") else open(path, encoding="utf-8")
    with opened as file:
        while True:
            try:
                frame = _frame(file, str(path))
            except UnicodeDecodeError as wrong:
                raise ValueError(f"{path} is no text dump of LAMMPS: {wrong}") from None
            if frame is None:
                return
            yield frame


def last_frame(path: Union[str, os.PathLike]) -> Frame:
    """The last step of a text dump."""
    frame = None
    for frame in read_dump(path):
        pass
    if frame is None:
        raise ValueError(f"{path} is empty")
    return frame


def _frame(file: IO[str], path: str) -> Optional[Frame]:
    step: Optional[int] = None
    time: Optional[float] = None
    count: Optional[int] = None
    box: Optional[Box] = None
    line = file.readline()
    if not line:
        return None
    while line.startswith("ITEM:"):
        what = line[len("ITEM:") :].split()
        if what[0] in ("ATOMS", "ENTRIES", "GRID"):
            if step is None or count is None or box is None:
                raise ValueError(f"{path}: 'ITEM: {what[0]}' comes before TIMESTEP, NUMBER OF and BOX BOUNDS")
            return Frame(step, time, box, _columns(file, path, step, count, what[1:]))
        if what[0] == "BOX":
            box = _box(what[2:], [file.readline().split() for _ in range(3)])
        else:
            value = file.readline()
            if what[0] == "TIMESTEP":
                step = int(value)
            elif what[0] == "TIME":
                time = float(value)
            elif what[0] == "NUMBER":
                count = int(value)
        line = file.readline()
    raise ValueError(f"{path}: '{line.strip()[:40]}' stands where a text dump of LAMMPS has 'ITEM:'")


def _box(words: List[str], rows: List[List[str]]) -> Box:
    bounds = np.array(rows, dtype=np.float64)
    low, high = bounds[:, 0], bounds[:, 1]
    periodic = [word == "pp" for word in words[-3:]]
    if bounds.shape[1] == 2:
        return Box(low, high - low, periodic)
    # The bounds are those of an upright box around the tilted one.
    xy, xz, yz = bounds[:, 2]
    low = low - [min(0.0, xy, xz, xy + xz), min(0.0, yz), 0.0]
    high = high - [max(0.0, xy, xz, xy + xz), max(0.0, yz), 0.0]
    edges = np.diag(high - low)
    edges[1, 0], edges[2, 0], edges[2, 1] = xy, xz, yz
    return Box(low, edges, periodic)


def _columns(file: IO[str], path: str, step: int, count: int, names: List[str]) -> Dict[str, NDArray]:
    lines = list(islice(file, count))
    if len(lines) < count:
        raise ValueError(f"{path}: step {step} ends after {len(lines)} of {count} lines")
    if count == 0:
        return {name: np.zeros(0, np.int64 if name in _INTEGERS else np.float64) for name in names}
    try:
        table = np.loadtxt(lines, ndmin=2)
        columns = {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}
    except ValueError:
        # Some column holds texts, such as element.
        texts = np.loadtxt(lines, ndmin=2, dtype=str)
        columns = {}
        for k, name in enumerate(names):
            try:
                columns[name] = texts[:, k].astype(np.float64)
            except ValueError:
                columns[name] = texts[:, k].copy()
    for name in _INTEGERS & columns.keys():
        columns[name] = columns[name].astype(np.int64)
    return columns


_INTEGERS = {"id", "type", "mol", "proc", "index"}

#: What `read_restart` asks `compute pair/local` for: names and the numbers of its values.
_OF_PAIRS: Tuple[Tuple[str, str, int], ...] = (
    ("normal_force", "p1", 1),
    ("contact_point", "p6 p7 p8", 3),
    ("normal", "p9 p10 p11", 3),
    ("penetration", "p12", 1),
    ("curvatures", "p13 p14", 2),
    ("contact_semi_axes", "p15 p16", 2),
    ("displacement", "p17 p18 p19", 3),
    ("force_on_first", "p21 p22 p23", 3),
    ("elastic_energy", "p30", 1),
    ("tangential_energy", "p31", 1),
)


@dataclass
class RestartContacts:
    """The touching pairs of a restart file, with what they remember; one entry a pair.

    Attributes
    ----------
    identifiers : numpy.ndarray of int64, shape (m, 2)
        Atoms, the first the i of normal and displacement.
    normal : numpy.ndarray, shape (m, 3)
        Unit vector from the first to the second.
    displacement : numpy.ndarray, shape (m, 3)
        Tangential displacement of the second relative to the first that the history holds, length.
    force_on_first, normal_force, contact_point, penetration, curvatures, contact_semi_axes, elastic_energy, tangential_energy
        As in `Contacts`, with the laws of the file.
    """

    identifiers: NDArray[np.int64]
    normal_force: Floats
    contact_point: Floats
    normal: Floats
    penetration: Floats
    curvatures: Floats
    contact_semi_axes: Floats
    displacement: Floats
    force_on_first: Floats
    elastic_energy: Floats
    tangential_energy: Floats

    def __len__(self) -> int:
        return len(self.penetration)


def restart_deck(restart: str, plugin: Optional[str] = None) -> str:
    """The deck that `read_restart` runs: it writes ``grains.dump`` and ``contacts.dump`` of a restart file of LAMMPS.

    Parameters
    ----------
    restart : str
        Name of the restart file.
    plugin : str, optional
        The plugin's file; default: LAMMPS finds the plugin by itself, as that of the wheel.
    """
    values = " ".join(numbers for _, numbers, _ in _OF_PAIRS)
    load = f"plugin load {plugin}\n" if plugin else ""
    return f"""{load}read_restart {restart}
compute quat all property/atom quatw quati quatj quatk
compute shape all property/atom shapex shapey shapez
compute atoms all property/local patom1 patom2
compute contact all pair/local {values}
dump grains all custom 1 grains.dump id type mass x y z vx vy vz angmomx angmomy angmomz c_quat[*] c_shape[*]
dump_modify grains sort id format float %.17g
dump contacts all local 1 contacts.dump c_atoms[*] c_contact[*]
dump_modify contacts format float %.17g
run 0
"""


def read_restart(
    restart: Union[str, os.PathLike], *, lammps: Sequence[str] = ("lmp",), plugin: Optional[Union[str, os.PathLike]] = None
) -> Tuple[Packing, RestartContacts]:
    """Grains and contacts of a binary restart file, with what friction remembers.

    LAMMPS reads the file, since nothing else does: its format belongs to LAMMPS and changes with it. Contacts with walls are
    not in it.

    Parameters
    ----------
    restart : str or path
    lammps : sequence of str
        The command that starts LAMMPS.
    plugin : str or path, optional
        The plugin's file; default: LAMMPS finds the plugin by itself, as that of the wheel.

    Returns
    -------
    packing : Packing
        Bodies by rising identifier.
    contacts : RestartContacts

    Raises
    ------
    RuntimeError
        LAMMPS stopped; the text is its error.
    """
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        deck = restart_deck(str(Path(restart).resolve()), str(Path(plugin).resolve()) if plugin else None)
        (directory / "deck.lmp").write_text(deck)
        done = subprocess.run(
            [*lammps, "-in", "deck.lmp", "-log", "none"],
            cwd=directory,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        if done.returncode != 0:
            said = [line for line in done.stdout.splitlines() if line.startswith("ERROR")]
            raise RuntimeError(said[0] if said else done.stdout[-2000:])
        grains, pairs = last_frame(directory / "grains.dump"), last_frame(directory / "contacts.dump")
    columns: Dict[str, Floats] = {}
    at = 0
    for quantity, _, length in _OF_PAIRS:
        names = [f"c_contact[{at + k + 1}]" for k in range(length)]
        at += length
        columns[quantity] = pairs.array(*names) if length > 1 else pairs.columns[names[0]]
    touching = columns["penetration"] > 0.0
    identifiers = pairs.array("c_atoms[1]", "c_atoms[2]").astype(np.int64)
    return grains.packing(), RestartContacts(
        identifiers=identifiers[touching], **{name: array[touching] for name, array in columns.items()}
    )
