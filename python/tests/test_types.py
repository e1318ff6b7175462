# SPDX-License-Identifier: MIT OR Apache-2.0
"""The type hints of the package hold among themselves."""
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")

PACKAGE = Path(__file__).parents[1] / "ellgran"


def test_types_hold():
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict-optional", "--disallow-untyped-defs", "--cache-dir", "/dev/null", str(PACKAGE)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert done.returncode == 0, done.stdout
