# SPDX-License-Identifier: MIT OR Apache-2.0
"""The shared library: where it is, how it is called, and what its errors become."""
from __future__ import annotations

import ctypes
import os
import threading
import weakref
from pathlib import Path
from typing import Any, Optional

from . import _interface
from .errors import error_of


def library_path() -> Path:
    """The shared library that is loaded: what the environment variable ELLGRAN_LIBRARY names, else the one of the wheel."""
    chosen = os.environ.get("ELLGRAN_LIBRARY")
    return Path(chosen) if chosen else Path(__file__).resolve().parent / "libellgran.so"


def _load() -> ctypes.CDLL:
    path = library_path()
    if not path.is_file():
        raise ImportError(
            f"ellgran: there is no library {path}: install the wheel, or set ELLGRAN_LIBRARY to the libellgran.so that "
            "`cargo xtask install --prefix DIR --shared` puts into DIR/lib"
        )
    library = ctypes.CDLL(str(path))
    version = library.ellgran_abi_version
    version.restype = ctypes.c_uint32
    if version() != _interface.ELLGRAN_ABI_VERSION:
        raise ImportError(
            f"ellgran: {path} has version {version()} of the binary interface, this module is written for version "
            f"{_interface.ELLGRAN_ABI_VERSION}: install both from the same release"
        )
    for name, (result, arguments) in _interface.FUNCTIONS.items():
        try:
            function = getattr(library, name)
        except AttributeError as missing:
            raise ImportError(f"ellgran: {path} is older than this module: it has no {name}") from missing
        function.restype = result
        function.argtypes = arguments
    return library


library = _load()


def version() -> str:
    """The library's version, such as ``0.1.0``."""
    return str(library.ellgran_version().decode())


def call(name: str, *arguments: Any) -> None:
    """Calls a function that returns a status; its failure becomes an exception."""
    status = getattr(library, name)(*arguments)
    if status != _interface.ELLGRAN_SUCCESS:
        raise error_of(status, library.ellgran_last_error().decode())


def sized(struct: Any, /, **fields: Any) -> Any:
    """A struct of the interface that has its size and is zero where no field is given."""
    return struct(size=ctypes.sizeof(struct), **fields)


class _Workspace:
    """Memory for the calls of one thread: calls give the interpreter's lock back, so two threads must not share it."""

    def __init__(self) -> None:
        pointer = ctypes.c_void_p()
        call("ellgran_workspace_new", ctypes.byref(pointer))
        self.pointer = pointer
        weakref.finalize(self, library.ellgran_workspace_free, pointer)


class _PerThread(threading.local):
    workspace: Optional[_Workspace] = None


_per_thread = _PerThread()


def workspace() -> ctypes.c_void_p:
    """The workspace of this thread."""
    if _per_thread.workspace is None:
        _per_thread.workspace = _Workspace()
    return _per_thread.workspace.pointer
