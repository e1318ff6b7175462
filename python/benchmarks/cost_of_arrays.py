# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a contact costs by ellgran.contacts, beside the C interface's ellgran_contact in a loop of a C program.

    cargo xtask python --cost

The same 100 000 pairs of ellipsoids, half of them touching, the same library; the shortest of several turns of each.
"""
import ctypes
import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import ellgran
from ellgran import _interface
from ellgran._library import library_path, sized

COUNT, TURNS = 100_000, 7

LOOP = """
#include <ellgran.h>
#include <string.h>
int32_t loop(const EllgranLaws *laws, size_t count, const EllgranBody *i, const EllgranBody *j, const EllgranStep *step,
             int32_t *touching, double *history, size_t length, EllgranContactGeometry *geometry, EllgranContactForce *force)
{
  for (size_t k = 0; k < count; k++) {
    int32_t status = ellgran_contact(laws, i + k, j + k, step, touching + k, history + k * length, geometry + k, force + k);
    if (status) return status;
  }
  return 0;
}
"""


def records(struct, count):
    """A numpy array of structs that have their sizes."""
    kinds = {ctypes.c_size_t: "u8", ctypes.c_double: "f8", ctypes.c_int32: "i4", ctypes.c_int64: "i8"}
    fields = []
    for name, kind in struct._fields_:
        base = getattr(kind, "_type_", kind) if hasattr(kind, "_length_") else kind
        fields.append((name, kinds[base], (kind._length_,) if hasattr(kind, "_length_") else ()))
    layout = np.dtype(
        {
            "names": [name for name, _, _ in fields],
            "formats": [(form, shape) for _, form, shape in fields],
            "offsets": [getattr(struct, name).offset for name, _, _ in fields],
            "itemsize": ctypes.sizeof(struct),
        }
    )
    array = np.zeros(count, dtype=layout)
    array["size"] = ctypes.sizeof(struct)
    return array


def main():
    generator = np.random.default_rng(1)
    positions = np.zeros((2 * COUNT, 3))
    positions[COUNT:] = generator.normal(size=(COUNT, 3))
    positions[COUNT:] *= generator.uniform(1.75, 2.15, (COUNT, 1)) / np.linalg.norm(
        positions[COUNT:], axis=1, keepdims=True
    )
    bodies = ellgran.Bodies(
        positions,
        generator.uniform(0.8, 1.2, (2 * COUNT, 3)),
        ellgran.random_rotations(2 * COUNT, generator),
        velocities=generator.uniform(-0.1, 0.1, (2 * COUNT, 3)),
        angular_velocities=generator.uniform(-0.1, 0.1, (2 * COUNT, 3)),
    )
    first = np.arange(COUNT, dtype=np.int32)
    pairs = np.stack([first, first + np.int32(COUNT)], axis=1)
    laws = ellgran.Laws("nfd 1e4 0.3 40 60 tangential tfd 0.4")
    step = sized(_interface.EllgranStep, time_step=1e-3, advance_history=1)

    all_bodies = records(_interface.EllgranBody, 2 * COUNT)
    for name, array in (
        ("position", bodies.positions),
        ("quaternion", bodies.quaternions),
        ("semi_axes", bodies.semi_axes),
        ("velocity", bodies.velocities),
        ("angular_velocity", bodies.angular_velocities),
        ("mass", bodies.masses),
        ("particle_type", bodies.types),
    ):
        all_bodies[name] = array
    geometry = records(_interface.EllgranContactGeometry, COUNT)
    force = records(_interface.EllgranContactForce, COUNT)
    include = os.environ.get("ELLGRAN_INCLUDE", str(Path(__file__).parents[2] / "include"))
    shortest = {"C": np.inf, "Python": np.inf, "Python, new arrays": np.inf}
    with tempfile.TemporaryDirectory() as directory:
        (Path(directory) / "loop.c").write_text(LOOP)
        compiled = str(Path(directory) / "loop.so")
        command = [os.environ.get("CC", "cc"), "-O2", "-std=c99", "-shared", "-fPIC", "-I", include, "loop.c"]
        subprocess.run([*command, str(library_path()), "-o", compiled], cwd=directory, check=True)
        loop = ctypes.CDLL(compiled).loop
        loop.argtypes = [ctypes.c_void_p, ctypes.c_size_t] + [ctypes.c_void_p] * 5 + [ctypes.c_size_t] + [ctypes.c_void_p] * 2
        out = None
        for _ in range(TURNS):
            memory = ellgran.ContactMemory(laws, COUNT)
            begin = time.perf_counter()
            status = loop(
                laws._pointer, COUNT, all_bodies.ctypes.data, all_bodies[COUNT:].ctypes.data, ctypes.addressof(step),
                memory.touching.ctypes.data, memory.history.ctypes.data, laws.history_length, geometry.ctypes.data,
                force.ctypes.data,
            )  # fmt: skip
            shortest["C"] = min(shortest["C"], time.perf_counter() - begin)
            assert status == 0
            memory = ellgran.ContactMemory(laws, COUNT)
            begin = time.perf_counter()
            fresh = ellgran.contacts(laws, bodies, pairs, time_step=1e-3, memory=memory)
            shortest["Python, new arrays"] = min(shortest["Python, new arrays"], time.perf_counter() - begin)
            out = out or fresh
            memory = ellgran.ContactMemory(laws, COUNT)
            begin = time.perf_counter()
            ellgran.contacts(laws, bodies, pairs, time_step=1e-3, memory=memory, out=out)
            shortest["Python"] = min(shortest["Python"], time.perf_counter() - begin)
    assert np.array_equal(out.force, force["force"]) and np.array_equal(out.penetration, geometry["penetration"])
    print(f"{COUNT} pairs, {100 * out.touching.mean():.0f} % touching, ellgran {ellgran.version()}")
    print(f"ellgran_contact in a loop of C                    {1e9 * shortest['C'] / COUNT:8.0f} ns a pair")
    for title, key in (("ellgran.contacts", "Python, new arrays"), ("ellgran.contacts, out= of an earlier call", "Python")):
        ratio = shortest[key] / shortest["C"]
        print(f"{title:<50}{1e9 * shortest[key] / COUNT:8.0f} ns a pair, {ratio:.2f} of it")


if __name__ == "__main__":
    main()
