# SPDX-License-Identifier: MIT OR Apache-2.0
"""Laws of materials, in the words of a deck, and the table of laws between all types of grains."""
from __future__ import annotations

import ctypes
import weakref
from dataclasses import dataclass
from typing import List, Mapping, Optional, Tuple, Union

from . import _interface
from ._library import call, library, sized


#: The constants of a law: the fields of the struct that are numbers, as the library's table has them.
_CONSTANTS = frozenset(
    field[0] for field in _interface.EllgranLawParameters._fields_ if field[1] is ctypes.c_double
)


class Law:
    """The law of one material, in the words that follow ``I J`` in LAMMPS' ``pair_coeff``.

    Parameters
    ----------
    words : str
        Such as ``"nfd 3e6 0.3 200 200 tangential tfd 0.5"``: Young's modulus (pressure), Poisson's ratio, shear and bulk
        viscosity (pressure x time), coefficient of friction. Any consistent units.

    Raises
    ------
    LawError
        Words or constants are wrong; the text names the word.

    Notes
    -----
    Constants are attributes, named as in ``EllgranLawParameters`` of ellgran.h: ``youngs_modulus``, ``poissons_ratio``,
    ``friction`` and so on. A constant that the law does not have is 0, ``restitution`` 1.
    """

    def __init__(self, words: str) -> None:
        texts = words.split()
        strings = (ctypes.c_char_p * max(len(texts), 1))(*[text.encode() for text in texts])
        parameters = sized(_interface.EllgranLawParameters)
        call(
            "ellgran_law_parameters_parse",
            len(texts),
            ctypes.cast(strings, ctypes.c_void_p),
            None,
            ctypes.byref(parameters),
        )
        self._parameters = parameters
        #: The words, one blank between them: what a deck's ``pair_coeff 1 1`` takes.
        self.words: str = " ".join(texts)

    def __getattr__(self, name: str) -> float:
        if name in _CONSTANTS:
            return float(getattr(self._parameters, name))
        raise AttributeError(f"Law has no '{name}'")

    def with_viscosities(self, shear: float, bulk: float) -> Law:
        """The same law with other viscosities, pressure x time; only for ``nfd``."""
        if self._parameters.normal != _interface.ELLGRAN_NORMAL_NFD:
            raise ValueError(f"'{self.words}' has no viscosities: begin it with nfd E nu eta1 eta2")
        texts = self.words.split()
        texts[3:5] = [repr(float(shear)), repr(float(bulk))]
        return Law(" ".join(texts))

    def __repr__(self) -> str:
        return f"Law({self.words!r})"


@dataclass(frozen=True)
class Mixture:
    """What the contact of two materials has, as the library mixes them.

    Attributes
    ----------
    effective_modulus : float
        E*, pressure: ``1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j``.
    effective_shear_modulus : float
        G*, pressure: ``1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j``.
    normal_relaxation_time, tangential_relaxation_time : float
        A_n and A_t (of a circular contact), time: the ratio of dashpot and spring. 0 for damping by a coefficient of
        restitution, which has none; A_t without a tangential law.
    """

    effective_modulus: float
    effective_shear_modulus: float
    normal_relaxation_time: float
    tangential_relaxation_time: float


class Laws:
    """The laws between all types of a scene. Immutable; threads may share it.

    Parameters
    ----------
    *materials : Law or str
        The laws of types 1, 2, ...
    pairs : mapping of (int, int) to Law or str, optional
        Laws of pairs of types that are given rather than mixed.

    Raises
    ------
    LawError
        Laws of different kinds cannot be mixed.

    Notes
    -----
    Other pairs are mixed from their materials: moduli in series, relaxation times by compliance, friction and restitution by
    geometric mean.
    """

    def __init__(
        self, *materials: Union[Law, str], pairs: Optional[Mapping[Tuple[int, int], Union[Law, str]]] = None
    ) -> None:
        laws: List[Law] = [as_law(material) for material in materials]
        count = len(laws)
        parameters = (_interface.EllgranLawParameters * max(count * count, 1))()
        is_set = (ctypes.c_uint8 * max(count * count, 1))()
        for entry in parameters:
            entry.size = ctypes.sizeof(entry)

        def give(i: int, j: int, law: Law) -> None:
            if not (1 <= i <= count and 1 <= j <= count):
                raise ValueError(f"pairs has types {i} {j}, but there are {count}, counted from 1")
            parameters[(i - 1) * count + j - 1] = law._parameters
            is_set[(i - 1) * count + j - 1] = 1

        for k, law in enumerate(laws):
            give(k + 1, k + 1, law)
        for (i, j), pair in (pairs or {}).items():
            give(i, j, as_law(pair))
        pointer = ctypes.c_void_p()
        call(
            "ellgran_laws_new",
            count,
            ctypes.addressof(parameters),
            ctypes.addressof(is_set),
            0,
            ctypes.byref(pointer),
        )
        weakref.finalize(self, library.ellgran_laws_free, pointer)
        self._pointer = pointer
        given = [entry for entry, known in zip(parameters, is_set) if known]
        #: Whether the normal force of some of them depends on what was before.
        self._remembers_normal_force = any(
            entry.viscosity == _interface.ELLGRAN_VISCOSITY_MEMORY for entry in given
        )
        #: The materials by type; the first is type 1.
        self.materials: Tuple[Law, ...] = tuple(laws)

    @property
    def type_count(self) -> int:
        """Number of types."""
        return len(self.materials)

    @property
    def history_length(self) -> int:
        """Numbers that a contact remembers from step to step."""
        return int(library.ellgran_laws_history_length(self._pointer))

    def describe(self, i: int = 1, j: int = 1) -> str:
        """One line: terms and constants of the law between types `i` and `j`."""
        text = ctypes.create_string_buffer(1024)
        call("ellgran_laws_describe", self._pointer, i, j, text, len(text))
        return text.value.decode()

    def mixture(self, i: int = 1, j: int = 1) -> Mixture:
        """E*, G* and relaxation times between types `i` and `j`; not for the linear law, which has no moduli."""
        mixed = sized(_interface.EllgranMixture)
        call("ellgran_laws_mixture", self._pointer, i, j, ctypes.byref(mixed))
        if mixed.effective_modulus == 0.0:
            raise ValueError(f"types {i} and {j}: the law '{self.describe(i, j)}' has no moduli")
        return Mixture(
            effective_modulus=mixed.effective_modulus,
            effective_shear_modulus=mixed.effective_shear_modulus,
            normal_relaxation_time=mixed.normal_relaxation_time,
            tangential_relaxation_time=mixed.tangential_relaxation_time,
        )

    def __repr__(self) -> str:
        return f"Laws({', '.join(repr(law.words) for law in self.materials)})"


def as_law(law: Union[Law, str]) -> Law:
    """A law from its words, or the law itself."""
    return law if isinstance(law, Law) else Law(law)


def as_laws(laws: Union[Laws, Law, str]) -> Laws:
    """The laws of a scene of one type from its law or its words, or the laws themselves."""
    if isinstance(laws, Laws):
        return laws
    return Laws(laws)
