# SPDX-License-Identifier: MIT OR Apache-2.0
"""The programs of the comparisons as modules: each folder has a compare.py of its own."""
from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

_VALIDATION = Path(__file__).resolve().parent.parent
_LOADED: dict = {}


def _load(folder: str, names: tuple) -> SimpleNamespace:
    if folder not in _LOADED:
        sys.path.insert(0, str(_VALIDATION / folder))
        try:
            _LOADED[folder] = SimpleNamespace(**{name: importlib.import_module(name) for name in names})
        finally:
            sys.path.pop(0)
            for name in names:
                sys.modules.pop(name, None)
    return _LOADED[folder]


@pytest.fixture
def elastic() -> SimpleNamespace:
    return _load("elastic_contact", ("ellipsoid_pair", "half_space", "finite_bodies", "whole_bodies", "compare"))


@pytest.fixture
def tangential() -> SimpleNamespace:
    return _load("tangential_contact", ("friction", "grains", "twisting", "compare"))


@pytest.fixture
def viscoelastic() -> SimpleNamespace:
    return _load("viscoelastic_contact", ("kelvin_voigt", "compare"))


@pytest.fixture
def collisions() -> SimpleNamespace:
    return _load("collisions", ("free_body", "two_bodies", "whole_mesh", "compare", "engines"))


@pytest.fixture
def packings() -> SimpleNamespace:
    return _load("packings", ("packing_measures", "compare"))


@pytest.fixture
def single_grains() -> SimpleNamespace:
    return _load("single_grains", ("damped_tangential_spring",))


@pytest.fixture
def stress() -> SimpleNamespace:
    return _load("stress", ("page",))
