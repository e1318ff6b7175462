# SPDX-License-Identifier: MIT OR Apache-2.0
"""The law on many pairs of bodies in one call: geometry, force, stiffness, duration of a collision."""
from __future__ import annotations

import ctypes
from typing import Any, Dict, Iterable, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _interface
from ._arrays import in_place, pointer
from ._library import call, sized, workspace
from .bodies import Bodies, Floats
from .law import Law, Laws, as_laws


def _lengths(arrays: Any, *records: Any) -> Dict[str, Tuple[int, ...]]:
    """Name and shape behind the pairs of each array of a struct of pointers, from the struct of one contact."""
    of_one = {name: kind for record in records for name, kind in record._fields_}
    shapes: Dict[str, Tuple[int, ...]] = {}
    for name, _ in arrays._fields_[1:]:
        # The one array that holds two fields: curvature_a and curvature_b.
        length = 2 if name == "curvatures" else getattr(of_one[name], "_length_", None)
        shapes[name] = () if length is None else (length,)
    return shapes


_CONTACT = _lengths(
    _interface.EllgranContactArrays, _interface.EllgranContactGeometry, _interface.EllgranContactForce
)
_STIFFNESS = _lengths(_interface.EllgranStiffnessArrays, _interface.EllgranContactStiffness)


class _Quantities:
    """Arrays by name, one entry a pair."""

    _shapes: Dict[str, Tuple[int, ...]] = {}

    def __init__(self, count: int, quantities: Optional[Iterable[str]]) -> None:
        names = list(self._shapes) if quantities is None else list(quantities)
        for name in names:
            if name not in self._shapes:
                raise ValueError(f"quantities has '{name}', which is none of {', '.join(self._shapes)}")
            setattr(self, name, np.empty((count,) + self._shapes[name]))
        self._count = count
        self._names: List[str] = names

    def __len__(self) -> int:
        return self._count

    def __getattr__(self, name: str) -> Any:
        if name in self._shapes:
            raise AttributeError(f"'{name}' was not asked for: name it in quantities, or leave quantities out")
        raise AttributeError(f"{type(self).__name__} has no '{name}'")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._count})"

    def _struct(self, kind: Any) -> Any:
        return sized(kind, **{name: pointer(getattr(self, name)) for name in self._names})

    def columns(self) -> Dict[str, NDArray[Any]]:
        """One-dimensional arrays by name, as ``pandas.DataFrame`` takes them: a vector ``force`` is ``force_x``, ``force_y``,
        ``force_z``, two numbers have ``_a`` and ``_b``. Views, no copies."""
        table: Dict[str, NDArray[Any]] = {}
        for name in self._names:
            array = getattr(self, name)
            if array.ndim == 1:
                table[name] = array
            else:
                for k, letter in enumerate("xyz" if array.shape[1] == 3 else "ab"):
                    table[f"{name}_{letter}"] = array[:, k]
        return table


class Contacts(_Quantities):
    """Geometry and forces of pairs of bodies i and j, one entry a pair; world frame.

    Attributes
    ----------
    touching : numpy.ndarray of bool, shape (m,)
        Whether the bodies overlap.
    penetration : numpy.ndarray, shape (m,)
        The smallest translation that separates the bodies, length; minus the gap where they are apart.
    normal : numpy.ndarray, shape (m, 3)
        Unit vector from i to j.
    contact_point, witness_i, witness_j : numpy.ndarray, shape (m, 3)
        Where the force acts; the point of i deepest in j, and of j deepest in i; length.
    curvatures : numpy.ndarray, shape (m, 2)
        Relative curvatures A <= B, 1/length.
    major_direction : numpy.ndarray, shape (m, 3)
        Unit vector along the major semi-axis of the contact ellipse.
    contact_semi_axes : numpy.ndarray, shape (m, 2)
        Semi-axes a >= b of the contact ellipse, length; 0 for the linear law.
    force : numpy.ndarray, shape (m, 3)
        Force on j; on i the opposite.
    torque_i, torque_j : numpy.ndarray, shape (m, 3)
        Torques on i and j, each about its own centre, force x length.
    normal_force : numpy.ndarray, shape (m,)
        > 0 pushes apart.
    tangential_force, viscous_force, frictional_force : numpy.ndarray, shape (m, 3)
        Parts of the force on j: tangential; of the viscous terms; tangential without its viscous part.
    displacement : numpy.ndarray, shape (m, 3)
        Tangential displacement of j relative to i that the tangential spring holds, length.
    penetration_rate : numpy.ndarray, shape (m,)
        Length/time, > 0 while the bodies approach.
    elastic_energy, tangential_energy : numpy.ndarray, shape (m,)
        Elastic energy of the normal and of the tangential deformation.
    viscous_power, tangential_power : numpy.ndarray, shape (m,)
        What viscosity dissipates; what the rest of the tangential force takes up, stored or dissipated; energy/time.
    frictional_couple, viscous_couple : numpy.ndarray, shape (m, 3)
        Parts of the torque on i that resists rolling and twisting, its opposite on j: without its viscous part; viscous.

    Of bodies that are apart all forces, energies and powers are 0.
    """

    _shapes = _CONTACT

    touching: NDArray[np.bool_]
    penetration: Floats
    normal: Floats
    contact_point: Floats
    witness_i: Floats
    witness_j: Floats
    curvatures: Floats
    major_direction: Floats
    contact_semi_axes: Floats
    force: Floats
    torque_i: Floats
    torque_j: Floats
    normal_force: Floats
    tangential_force: Floats
    displacement: Floats
    penetration_rate: Floats
    elastic_energy: Floats
    tangential_energy: Floats
    viscous_force: Floats
    frictional_force: Floats
    viscous_power: Floats
    tangential_power: Floats
    frictional_couple: Floats
    viscous_couple: Floats


class Stiffnesses(_Quantities):
    """Springs and dashpots of contacts at their present penetration, one entry a pair; 0 where the bodies are apart.

    Attributes
    ----------
    normal_stiffness : numpy.ndarray, shape (m,)
        Derivative of the normal force by the penetration, force/length.
    tangential_stiffness : numpy.ndarray, shape (m, 2)
        Along the major and the minor semi-axis of the contact ellipse, before any slip, force/length.
    normal_damping : numpy.ndarray, shape (m,)
        Of the normal dashpot on approach, force x time/length.
    tangential_damping : numpy.ndarray, shape (m, 2)
        Of the tangential dashpots, force x time/length.
    critical_step : numpy.ndarray, shape (m,)
        The largest time step at which this contact alone is stable, time; ``inf`` where the bodies are apart or both fixed. A
        grain with n contacts needs a step shorter by the root of n.
    """

    _shapes = _STIFFNESS

    normal_stiffness: Floats
    tangential_stiffness: Floats
    normal_damping: Floats
    tangential_damping: Floats
    critical_step: Floats


class ContactMemory:
    """What pairs remember from step to step: whether they touched, and their histories.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws that write it.
    count : int
        Number of pairs, m.

    Attributes
    ----------
    touching : numpy.ndarray of int32, shape (m,)
    history : numpy.ndarray, shape (m, laws.history_length)
        Zero at first. To begin a pair anew set both to 0.
    """

    def __init__(self, laws: Union[Laws, Law, str], count: int) -> None:
        self.touching: NDArray[np.int32] = np.zeros(count, dtype=np.int32)
        self.history: Floats = np.zeros((count, as_laws(laws).history_length))


def _pairs(pairs: ArrayLike) -> Any:
    return in_place(pairs, (None, 2), "pairs", np.int32)


def side_by_side(bodies_i: Bodies, bodies_j: Bodies) -> Tuple[Bodies, NDArray[np.int32]]:
    """The k-th of one with the k-th of the other: all bodies, copied into one, and the pairs, shape (m, 2)."""
    count = len(bodies_i)
    if len(bodies_j) != count:
        raise ValueError(f"there are {count} bodies i and {len(bodies_j)} bodies j: they must be as many")
    first = np.arange(count, dtype=np.int32)
    return Bodies.joined(bodies_i, bodies_j), np.stack([first, first + np.int32(count)], axis=1)


def contacts(
    laws: Union[Laws, Law, str],
    bodies: Bodies,
    pairs: ArrayLike,
    *,
    time_step: float = 0.0,
    advance_history: bool = True,
    memory: Optional[ContactMemory] = None,
    quantities: Optional[Iterable[str]] = None,
    out: Optional[Contacts] = None,
) -> Contacts:
    """Geometry and forces of many pairs of bodies, to the last bit those of the C interface's ``ellgran_contact``.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between the types of the bodies.
    bodies : Bodies
        n of them.
    pairs : array_like of int, shape (m, 2)
        Indices of the bodies i and j of each pair; int32 and C-contiguous arrays are not copied.
    time_step : float
        Time that the velocities took to bring the bodies where they are; it moves the tangential displacement. Default: 0,
        forces at this instant.
    advance_history : bool
        False: forces from the history as it stands.
    memory : ContactMemory, optional
        What the pairs remember, read and written; default: all contacts are new.
    quantities : iterable of str, optional
        Names of the arrays of `Contacts` that are wanted; default: all of them. `touching` is always there.
    out : Contacts, optional
        Result of an earlier call of as many pairs, to be overwritten in place of new memory; it brings its own quantities.

    Returns
    -------
    Contacts

    Raises
    ------
    ArgumentError, BodyError, ContactError
        With the library's message, which names the pair or the body and the value. Messages name bodies by
        ``bodies.identifiers``.
    """
    laws = as_laws(laws)
    which = _pairs(pairs)
    count = len(which)
    if out is not None and len(out) != count:
        raise ValueError(f"out has {len(out)} pairs, but there are {count}")
    result = Contacts(count, quantities) if out is None else out
    length = laws.history_length
    if memory is None:
        memory = ContactMemory(laws, count)
    elif memory.touching.shape != (count,) or memory.history.shape != (count, length):
        raise ValueError(
            f"memory is of {len(memory.touching)} pairs with {memory.history.shape[1]} numbers each, but there are {count} "
            f"pairs with {length}: make a ContactMemory(laws, {count})"
        )
    elif not (
        memory.touching.dtype == np.int32
        and memory.history.dtype == np.float64
        and memory.touching.flags.carray
        and memory.history.flags.carray
    ):
        raise ValueError(
            "memory must hold C-contiguous arrays that can be written, touching of int32 and history of float64"
        )
    step = sized(_interface.EllgranStep, time_step=time_step, advance_history=int(advance_history))
    particles = bodies._particles()
    arrays = result._struct(_interface.EllgranContactArrays)
    call(
        "ellgran_pair_contacts",
        laws._pointer,
        workspace(),
        ctypes.byref(particles),
        ctypes.byref(step),
        count,
        pointer(which),
        pointer(memory.touching),
        pointer(memory.history) if length else None,
        ctypes.byref(arrays),
    )
    result.touching = memory.touching != 0
    return result


def stiffnesses(laws: Union[Laws, Law, str], bodies: Bodies, pairs: ArrayLike) -> Stiffnesses:
    """Springs, dashpots and critical time steps of many contacts at their present penetration.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between the types of the bodies.
    bodies : Bodies
        n of them; masses are read, velocities are not.
    pairs : array_like of int, shape (m, 2)
        Indices of the bodies of each pair.

    Returns
    -------
    Stiffnesses

    Raises
    ------
    ArgumentError, BodyError, ContactError
        As `contacts`.
    """
    laws = as_laws(laws)
    which = _pairs(pairs)
    result = Stiffnesses(len(which), None)
    particles = bodies._particles()
    arrays = result._struct(_interface.EllgranStiffnessArrays)
    call(
        "ellgran_pair_stiffnesses",
        laws._pointer,
        workspace(),
        ctypes.byref(particles),
        len(which),
        pointer(which),
        ctypes.byref(arrays),
    )
    return result


def elastic_collisions(
    laws: Union[Laws, Law, str], bodies: Bodies, pairs: ArrayLike, speed: ArrayLike
) -> Tuple[Floats, Floats]:
    """How long elastic collisions last and how deep they go, with the normals, curvatures and levers that pairs have now.

    Parameters
    ----------
    laws : Laws, Law or str
        The laws between the types of the bodies.
    bodies : Bodies
        n of them, apart or touching; masses are read, velocities are not.
    pairs : array_like of int, shape (m, 2)
        Indices of the bodies of each pair.
    speed : array_like, shape (m,) or ()
        Speed along the normal at first touch, length/time, > 0.

    Returns
    -------
    time, penetration : numpy.ndarray, shape (m,)
        From first to last touch; the largest penetration, length. Damping makes a collision longer and less deep.
        ``inf`` for two fixed bodies.
    """
    laws = as_laws(laws)
    which = _pairs(pairs)
    speeds = in_place(speed, (len(which),), "speed")
    time, penetration = np.empty(len(which)), np.empty(len(which))
    particles = bodies._particles()
    call(
        "ellgran_pair_collisions",
        laws._pointer,
        workspace(),
        ctypes.byref(particles),
        len(which),
        pointer(which),
        pointer(speeds),
        pointer(time),
        pointer(penetration),
    )
    return time, penetration


def rayleigh_times(laws: Union[Laws, Law, str], bodies: Bodies) -> Floats:
    """How long a surface wave takes from pole to pole of each grain's inscribed sphere, shape (n,), time.

    Time steps are commonly a fifth of it or less. ``inf`` for the linear law, which has no material.
    """
    laws = as_laws(laws)
    parameters = (_interface.EllgranLawParameters * laws.type_count)(*[law._parameters for law in laws.materials])
    times = np.empty(len(bodies))
    particles = bodies._particles()
    call(
        "ellgran_rayleigh_times",
        laws.type_count,
        ctypes.addressof(parameters),
        ctypes.byref(particles),
        pointer(times),
    )
    return times
