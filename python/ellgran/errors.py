# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a failing call of the library becomes."""
from __future__ import annotations

from . import _interface


class EllgranError(Exception):
    """A call of the library failed. The text is the library's own message.

    Attributes
    ----------
    status : int
        The status code, ``ELLGRAN_ERROR_*`` of ellgran.h.
    """

    status: int = 0


class ArgumentError(EllgranError, ValueError):
    """An argument is out of its range."""


class LawError(EllgranError, ValueError):
    """Words or constants of a law are wrong."""


class BodyError(EllgranError, ValueError):
    """A body has a value that cannot be."""


class ContactError(EllgranError, ArithmeticError):
    """A contact has no answer: ``factors hale`` beyond its range, a history that no call wrote, or an overflow."""


class InternalError(EllgranError, RuntimeError):
    """A defect of the library. Please report it."""


def error_of(status: int, message: str) -> EllgranError:
    """The exception of a status code, with the library's message."""
    kinds = {
        _interface.ELLGRAN_ERROR_LAW: LawError,
        _interface.ELLGRAN_ERROR_PARTICLE: BodyError,
        _interface.ELLGRAN_ERROR_HALE: ContactError,
        _interface.ELLGRAN_ERROR_HISTORY: ContactError,
        _interface.ELLGRAN_ERROR_RESULT: ContactError,
        _interface.ELLGRAN_ERROR_PANIC: InternalError,
    }
    error = kinds.get(status, ArgumentError)(message)
    error.status = status
    return error


