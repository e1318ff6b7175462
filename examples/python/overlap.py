# SPDX-License-Identifier: MIT OR Apache-2.0
"""Overlap of two unit spheres through the shared library, by ctypes.

    cargo xtask install --prefix DIR --shared
    python3 overlap.py DIR/lib/libellgran.so

Every struct begins with its size; the rest of a new ctypes structure is zero, as ellgran.h asks.
"""
import ctypes
import sys

number = ctypes.c_double


class Body(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("position", number * 3), ("quaternion", number * 4),
                ("semi_axes", number * 3), ("velocity", number * 3), ("angular_velocity", number * 3),
                ("mass", number), ("particle_type", ctypes.c_int32), ("identifier", ctypes.c_int64)]


class ContactGeometry(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("touching", ctypes.c_int32), ("penetration", number),
                ("normal", number * 3), ("contact_point", number * 3), ("witness_i", number * 3),
                ("witness_j", number * 3), ("curvature_a", number), ("curvature_b", number),
                ("major_direction", number * 3)]


library = ctypes.CDLL(sys.argv[1])
library.ellgran_last_error.restype = ctypes.c_char_p
library.ellgran_version.restype = ctypes.c_char_p
library.ellgran_abi_version.restype = ctypes.c_uint32
assert library.ellgran_abi_version() == 1, "written for version 1 of the binary interface"

bodies = []
for x in (0.0, 1.5):
    body = Body(size=ctypes.sizeof(Body), mass=1.0, particle_type=1)
    body.position[0] = x
    body.quaternion[0] = 1.0
    body.semi_axes[:] = [1.0, 1.0, 1.0]
    bodies.append(body)
geometry = ContactGeometry(size=ctypes.sizeof(ContactGeometry))
status = library.ellgran_contact_geometry(None, ctypes.byref(bodies[0]), ctypes.byref(bodies[1]), None,
                                          ctypes.byref(geometry))
if status != 0:
    sys.exit(library.ellgran_last_error().decode())
print(f"ellgran {library.ellgran_version().decode()}: {geometry.touching} {geometry.penetration:.3f}")
