# SPDX-License-Identifier: MIT OR Apache-2.0
"""What hatchling cannot read from pyproject.toml: the wheel holds compiled libraries, and a plugin for one LAMMPS."""

import sysconfig
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

PACKAGE = Path(__file__).parent / "ellgran"
LIBRARIES = [PACKAGE / "libellgran.so", PACKAGE / "plugins" / "ellgranplugin.so"]
LAMMPS_RELEASE = PACKAGE / "plugins" / "lammps_release.txt"


class CompiledLibraries(BuildHookInterface):
    """Tags the wheel for any Python 3 and this machine. auditwheel then says how old a system may be."""

    def initialize(self, version, build_data):
        if version == "editable":
            return
        missing = [str(file) for file in [*LIBRARIES, LAMMPS_RELEASE] if not file.is_file()]
        if missing:
            raise FileNotFoundError(
                f"{', '.join(missing)}: missing. Build the wheel by `cargo xtask wheel`, which compiles what belongs into it"
            )
        build_data["pure_python"] = False
        build_data["tag"] = "py3-none-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")


class MatchingLammps(MetadataHookInterface):
    """The extra `lammps` asks for the LAMMPS that the plugin was built for."""

    def update(self, metadata):
        extras = {}
        if LAMMPS_RELEASE.is_file():
            extras["lammps"] = [f"lammps[mpi]=={LAMMPS_RELEASE.read_text().strip()}.*"]
        metadata["optional-dependencies"] = extras
