# SPDX-License-Identifier: MIT OR Apache-2.0
"""What ellgran.h declares: constants, structs, and the types of the functions.

Generated from include/ellgran.h, do not edit; `cargo xtask header` writes it.
"""
import ctypes
from typing import Any, Dict, List, Tuple

ELLGRAN_NORMAL_HERTZ = 0
ELLGRAN_NORMAL_NFD = 1
ELLGRAN_NORMAL_LSD = 2
ELLGRAN_FACTORS_EXACT = 0
ELLGRAN_FACTORS_HALE = 1
ELLGRAN_DAMPING_NONE = 0
ELLGRAN_DAMPING_RESTITUTION = 1
ELLGRAN_DAMPING_RELAXATION = 2
ELLGRAN_CLOSURE_ENERGY = 0
ELLGRAN_CLOSURE_SURFACE = 1
ELLGRAN_CLOSURE_BRILLIANTOV = 2
ELLGRAN_UNLOADING_TING = 0
ELLGRAN_UNLOADING_FIRST_ORDER = 1
ELLGRAN_VISCOSITY_FIRST_ORDER = 0
ELLGRAN_VISCOSITY_MEMORY = 1
ELLGRAN_TANGENTIAL_NONE = 0
ELLGRAN_TANGENTIAL_TFD = 1
ELLGRAN_TANGENTIAL_MINDLIN = 2
ELLGRAN_TANGENTIAL_LINEAR = 3
ELLGRAN_DISPLACEMENT_TOTAL = 0
ELLGRAN_DISPLACEMENT_INCREMENTAL = 1
ELLGRAN_DISPLACEMENT_RESCALED = 2
ELLGRAN_DISPLACEMENT_HYSTERETIC = 3
ELLGRAN_ROLLING_NONE = 0
ELLGRAN_ROLLING_SDS = 1
ELLGRAN_TWISTING_NONE = 0
ELLGRAN_TWISTING_MARSHALL = 1
ELLGRAN_TWISTING_SDS = 2
ELLGRAN_TWISTING_LUBKIN = 3
ELLGRAN_GRAIN_SUMS_LENGTH = 14
ELLGRAN_OPTION_NO_WARM_START = 1
ELLGRAN_SIDE_OF_CENTRE = 0
ELLGRAN_SIDE_INSIDE = 1
ELLGRAN_SIDE_OUTSIDE = 2
ELLGRAN_END_NONE = 0
ELLGRAN_END_OPEN = 1
ELLGRAN_END_CLOSED = 2
ELLGRAN_STEP_SUMS_LENGTH = 42
ELLGRAN_SUCCESS = 0
ELLGRAN_ERROR_NULL_POINTER = 1
ELLGRAN_ERROR_ARGUMENT = 2
ELLGRAN_ERROR_TEXT = 3
ELLGRAN_ERROR_LAW = 100
ELLGRAN_ERROR_HALE = 101
ELLGRAN_ERROR_PARTICLE = 200
ELLGRAN_ERROR_HISTORY = 201
ELLGRAN_ERROR_RESULT = 202
ELLGRAN_ERROR_PANIC = 900
ELLGRAN_ABI_VERSION = 1


class EllgranBody(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("position", ctypes.c_double * 3),
        ("quaternion", ctypes.c_double * 4),
        ("semi_axes", ctypes.c_double * 3),
        ("velocity", ctypes.c_double * 3),
        ("angular_velocity", ctypes.c_double * 3),
        ("mass", ctypes.c_double),
        ("particle_type", ctypes.c_int32),
        ("identifier", ctypes.c_int64),
        ("velocity_change", ctypes.c_double * 3),
        ("angular_velocity_change", ctypes.c_double * 3),
        ("velocities_of_step", ctypes.c_int64),
    ]


class EllgranContactGeometry(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("touching", ctypes.c_int32),
        ("penetration", ctypes.c_double),
        ("normal", ctypes.c_double * 3),
        ("contact_point", ctypes.c_double * 3),
        ("witness_i", ctypes.c_double * 3),
        ("witness_j", ctypes.c_double * 3),
        ("curvature_a", ctypes.c_double),
        ("curvature_b", ctypes.c_double),
        ("major_direction", ctypes.c_double * 3),
    ]


class EllgranPlane(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("point", ctypes.c_double * 3),
        ("normal", ctypes.c_double * 3),
        ("velocity", ctypes.c_double * 3),
        ("velocity_change", ctypes.c_double * 3),
    ]


class EllgranStep(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("advance_history", ctypes.c_int32),
        ("time_step", ctypes.c_double),
    ]


class EllgranContactForce(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("force", ctypes.c_double * 3),
        ("torque_i", ctypes.c_double * 3),
        ("torque_j", ctypes.c_double * 3),
        ("normal_force", ctypes.c_double),
        ("tangential_force", ctypes.c_double * 3),
        ("displacement", ctypes.c_double * 3),
        ("penetration_rate", ctypes.c_double),
        ("elastic_energy", ctypes.c_double),
        ("tangential_energy", ctypes.c_double),
        ("viscous_force", ctypes.c_double * 3),
        ("frictional_force", ctypes.c_double * 3),
        ("viscous_power", ctypes.c_double),
        ("tangential_power", ctypes.c_double),
        ("contact_semi_axes", ctypes.c_double * 2),
        ("frictional_couple", ctypes.c_double * 3),
        ("viscous_couple", ctypes.c_double * 3),
    ]


class EllgranLentTriangles(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("corners", ctypes.c_void_p),
        ("velocities", ctypes.c_void_p),
        ("particle_count", ctypes.c_size_t),
        ("near_starts", ctypes.c_void_p),
        ("near", ctypes.c_void_p),
        ("velocity_changes", ctypes.c_void_p),
    ]


class EllgranParticles(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("owned_count", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("positions", ctypes.c_void_p),
        ("velocities", ctypes.c_void_p),
        ("angular_velocities", ctypes.c_void_p),
        ("angular_momenta", ctypes.c_void_p),
        ("masses", ctypes.c_void_p),
        ("contact_masses", ctypes.c_void_p),
        ("types", ctypes.c_void_p),
        ("shape_indices", ctypes.c_void_p),
        ("semi_axes", ctypes.c_void_p),
        ("semi_axes_stride", ctypes.c_size_t),
        ("quaternions", ctypes.c_void_p),
        ("quaternions_stride", ctypes.c_size_t),
        ("identifiers", ctypes.c_void_p),
        ("identifier_bytes", ctypes.c_int32),
        ("forces", ctypes.c_void_p),
        ("torques", ctypes.c_void_p),
        ("velocity_changes", ctypes.c_void_p),
        ("unchanged", ctypes.c_int64),
        ("prepared_by", ctypes.c_void_p),
    ]


class EllgranWallMotion(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("origin", ctypes.c_double * 3),
        ("displacement", ctypes.c_double * 3),
        ("quaternion", ctypes.c_double * 4),
        ("velocity", ctypes.c_double * 3),
        ("angular_velocity", ctypes.c_double * 3),
        ("along_itself", ctypes.c_int32),
        ("unused", ctypes.c_int32),
        ("velocity_change", ctypes.c_double * 3),
        ("angular_velocity_change", ctypes.c_double * 3),
    ]


class EllgranFoundWallContact(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("particle", ctypes.c_size_t),
        ("part", ctypes.c_size_t),
        ("triangle", ctypes.c_size_t),
        ("point", ctypes.c_double * 3),
        ("velocity", ctypes.c_double * 3),
        ("touched", ctypes.c_int32),
        ("is_forgotten", ctypes.c_int32),
        ("last_normal", ctypes.c_double * 3),
        ("history", ctypes.c_void_p),
    ]


class EllgranStagedGeometry(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("touching", ctypes.c_int32),
        ("penetration", ctypes.c_double),
        ("normal", ctypes.c_double * 3),
        ("contact_point", ctypes.c_double * 3),
    ]


class EllgranLawParameters(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("normal", ctypes.c_int32),
        ("damping", ctypes.c_int32),
        ("tangential", ctypes.c_int32),
        ("closure", ctypes.c_int32),
        ("unloading", ctypes.c_int32),
        ("factors", ctypes.c_int32),
        ("displacement", ctypes.c_int32),
        ("conservative", ctypes.c_int32),
        ("limit_force", ctypes.c_int32),
        ("youngs_modulus", ctypes.c_double),
        ("poissons_ratio", ctypes.c_double),
        ("shear_viscosity", ctypes.c_double),
        ("bulk_viscosity", ctypes.c_double),
        ("relaxation_time", ctypes.c_double),
        ("restitution", ctypes.c_double),
        ("normal_stiffness", ctypes.c_double),
        ("normal_damping", ctypes.c_double),
        ("friction", ctypes.c_double),
        ("tangential_stiffness", ctypes.c_double),
        ("tangential_damping", ctypes.c_double),
        ("rolling", ctypes.c_int32),
        ("twisting", ctypes.c_int32),
        ("rolling_stiffness", ctypes.c_double),
        ("rolling_damping", ctypes.c_double),
        ("rolling_friction", ctypes.c_double),
        ("twisting_stiffness", ctypes.c_double),
        ("twisting_damping", ctypes.c_double),
        ("twisting_friction", ctypes.c_double),
        ("viscosity", ctypes.c_int32),
        ("reserved", ctypes.c_int32),
    ]


class EllgranMixture(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("effective_modulus", ctypes.c_double),
        ("effective_shear_modulus", ctypes.c_double),
        ("normal_relaxation_time", ctypes.c_double),
        ("tangential_relaxation_time", ctypes.c_double),
        ("share_i", ctypes.c_double),
    ]


class EllgranContactArrays(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("penetration", ctypes.c_void_p),
        ("normal", ctypes.c_void_p),
        ("contact_point", ctypes.c_void_p),
        ("witness_i", ctypes.c_void_p),
        ("witness_j", ctypes.c_void_p),
        ("curvatures", ctypes.c_void_p),
        ("major_direction", ctypes.c_void_p),
        ("contact_semi_axes", ctypes.c_void_p),
        ("force", ctypes.c_void_p),
        ("torque_i", ctypes.c_void_p),
        ("torque_j", ctypes.c_void_p),
        ("normal_force", ctypes.c_void_p),
        ("tangential_force", ctypes.c_void_p),
        ("displacement", ctypes.c_void_p),
        ("penetration_rate", ctypes.c_void_p),
        ("elastic_energy", ctypes.c_void_p),
        ("tangential_energy", ctypes.c_void_p),
        ("viscous_force", ctypes.c_void_p),
        ("frictional_force", ctypes.c_void_p),
        ("viscous_power", ctypes.c_void_p),
        ("tangential_power", ctypes.c_void_p),
        ("frictional_couple", ctypes.c_void_p),
        ("viscous_couple", ctypes.c_void_p),
    ]


class EllgranStiffnessArrays(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("normal_stiffness", ctypes.c_void_p),
        ("tangential_stiffness", ctypes.c_void_p),
        ("normal_damping", ctypes.c_void_p),
        ("tangential_damping", ctypes.c_void_p),
        ("critical_step", ctypes.c_void_p),
    ]


class EllgranMotion(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("positions", ctypes.c_void_p),
        ("velocities", ctypes.c_void_p),
        ("angular_momenta", ctypes.c_void_p),
        ("forces", ctypes.c_void_p),
        ("torques", ctypes.c_void_p),
        ("masses", ctypes.c_void_p),
        ("shape_indices", ctypes.c_void_p),
        ("semi_axes", ctypes.c_void_p),
        ("semi_axes_stride", ctypes.c_size_t),
        ("quaternions", ctypes.c_void_p),
        ("quaternions_stride", ctypes.c_size_t),
        ("masks", ctypes.c_void_p),
        ("group_mask", ctypes.c_int32),
        ("identifier_bytes", ctypes.c_int32),
        ("identifiers", ctypes.c_void_p),
        ("velocity_changes", ctypes.c_void_p),
        ("loads_before", ctypes.c_void_p),
        ("time_step_before", ctypes.c_double),
    ]


class EllgranNeighbourList(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("central", ctypes.c_void_p),
        ("neighbour_counts", ctypes.c_void_p),
        ("neighbours", ctypes.c_void_p),
        ("index_mask", ctypes.c_int32),
        ("special_shift", ctypes.c_int32),
        ("special_factors", ctypes.c_void_p),
        ("newton", ctypes.c_int32),
        ("unchanged", ctypes.c_int32),
        ("keep_history", ctypes.c_int32),
        ("record_contacts", ctypes.c_int32),
        ("touching", ctypes.c_void_p),
        ("history", ctypes.c_void_p),
    ]


class EllgranTallies(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("particle_energies", ctypes.c_void_p),
        ("particle_virials", ctypes.c_void_p),
        ("inelastic_loads", ctypes.c_void_p),
        ("wall_powers", ctypes.c_double * 2),
        ("viscous_dissipation", ctypes.c_double),
        ("tangential_work", ctypes.c_double),
        ("frictional_dissipation", ctypes.c_double),
        ("dissipated_energy", ctypes.c_double),
        ("normal_elastic_energy", ctypes.c_double),
        ("tangential_elastic_energy", ctypes.c_double),
        ("virial", ctypes.c_double * 6),
        ("touching_count", ctypes.c_double),
        ("pair_count", ctypes.c_int64),
    ]


class EllgranContactPlace(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("i", ctypes.c_int32),
        ("j", ctypes.c_int32),
        ("entry", ctypes.c_size_t),
    ]


class EllgranWallShape(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("name", ctypes.c_void_p),
        ("point", ctypes.c_double * 3),
        ("axis", ctypes.c_double * 3),
        ("radii", ctypes.c_double * 2),
        ("bounds", ctypes.c_double * 2),
        ("ends", ctypes.c_int32 * 2),
        ("side", ctypes.c_int32),
        ("unused", ctypes.c_int32),
    ]


class EllgranWallLoad(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("force", ctypes.c_double * 3),
        ("torque", ctypes.c_double * 3),
        ("power", ctypes.c_double),
        ("contact_count", ctypes.c_int64),
        ("stiffness", ctypes.c_double),
        ("damping", ctypes.c_double),
        ("crowded_particle", ctypes.c_int64),
        ("viscous_force", ctypes.c_double * 3),
        ("viscous_torque", ctypes.c_double * 3),
        ("tangential_force", ctypes.c_double * 3),
        ("tangential_torque", ctypes.c_double * 3),
    ]


class EllgranRecordedWallContact(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("particle", ctypes.c_size_t),
        ("part", ctypes.c_size_t),
        ("point", ctypes.c_double * 3),
        ("normal", ctypes.c_double * 3),
        ("penetration", ctypes.c_double),
        ("normal_force", ctypes.c_double),
        ("tangential_force", ctypes.c_double * 3),
        ("force", ctypes.c_double * 3),
        ("torque", ctypes.c_double * 3),
        ("elastic_energy", ctypes.c_double * 2),
    ]


class EllgranServo(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("target", ctypes.c_double),
        ("gain", ctypes.c_double),
        ("largest_speed", ctypes.c_double),
        ("steady_velocity", ctypes.c_double),
        ("velocity", ctypes.c_double),
    ]


class EllgranContactExtremes(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("touching_count", ctypes.c_int64),
        ("shortest_collision", ctypes.c_double),
        ("collision_speed", ctypes.c_double),
        ("collision_stiffness", ctypes.c_double),
        ("collision_inverse_mass", ctypes.c_double),
        ("collision_effective_mass", ctypes.c_double),
        ("collision_identifiers", ctypes.c_int64 * 2),
        ("collision_types", ctypes.c_int32 * 2),
        ("deepest_overlap", ctypes.c_double),
        ("deepest_identifiers", ctypes.c_int64 * 2),
    ]


class EllgranWallSurface(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("point", ctypes.c_double * 3),
        ("normal", ctypes.c_double * 3),
        ("direction", ctypes.c_double * 3),
        ("curvatures", ctypes.c_double * 2),
        ("turning_radii", ctypes.c_double * 2),
        ("velocity", ctypes.c_double * 3),
        ("others_share", ctypes.c_double),
        ("others_share_by_position", ctypes.c_double * 3),
        ("others_share_by_rotation", ctypes.c_double * 3),
        ("velocity_change", ctypes.c_double * 3),
    ]


class EllgranStagedHistory(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("friction", ctypes.c_double),
        ("touched", ctypes.c_int32),
        ("normal", ctypes.c_double * 3),
    ]


class EllgranContactStiffness(ctypes.Structure):
    _fields_ = [
        ("size", ctypes.c_size_t),
        ("normal_stiffness", ctypes.c_double),
        ("tangential_stiffness", ctypes.c_double * 2),
        ("normal_damping", ctypes.c_double),
        ("tangential_damping", ctypes.c_double * 2),
        ("critical_step", ctypes.c_double),
    ]


#: Result and argument types by function.
FUNCTIONS: Dict[str, Tuple[Any, List[Any]]] = {
    "ellgran_contact_geometry": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_contact_geometry_plane": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_contact": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_contact_plane": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_lend_triangles": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_found_histories_length": (ctypes.c_size_t, [ctypes.c_void_p, ctypes.c_size_t]),
    "ellgran_find_wall_contacts": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_wall_found_count": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_wall_found": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_staged_found": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_void_p]),
    "ellgran_remember_wall_contacts": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_int32, ctypes.c_void_p]),
    "ellgran_add_recorded_to_grain_sums": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_void_p]),
    "ellgran_add_wall_recorded_to_grain_sums": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_law_parameters_default": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_law_parameters_parse": (ctypes.c_int32, [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_material_parse": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_new": (ctypes.c_int32, [ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_void_p]),
    "ellgran_laws_with_friction": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_with_restitution": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_mixture": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p]),
    "ellgran_laws_create_energy": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_free": (None, [ctypes.c_void_p]),
    "ellgran_laws_history_length": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_laws_memory_offset": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_laws_read_histories_of": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_uses_mass": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_history_swap": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_laws_describe": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p, ctypes.c_size_t]),
    "ellgran_pair_contacts": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_pair_stiffnesses": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_pair_collisions": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_rayleigh_times": (ctypes.c_int32, [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_start_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double]),
    "ellgran_finish_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double]),
    "ellgran_angular_velocities": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_compute_pairs": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_write_history": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_forget_history": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_workspace_new": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_workspace_free": (None, [ctypes.c_void_p]),
    "ellgran_workspace_instruction_set": (ctypes.c_char_p, [ctypes.c_void_p]),
    "ellgran_workspace_bytes": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_workspace_deep_contacts_count": (ctypes.c_int64, [ctypes.c_void_p]),
    "ellgran_recorded_count": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_recorded_contact": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_recorded_find": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p]),
    "ellgran_wall_new": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_wall_free": (None, [ctypes.c_void_p]),
    "ellgran_wall_add_shape": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_add_shape_words": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_add_triangles": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_flatten_triangles": (ctypes.c_int32, [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_add_block": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_add_stl": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_part_count": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_wall_histories_length": (ctypes.c_size_t, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_histories_used": (ctypes.c_size_t, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_compute_wall": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_part_plane": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_part_force": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_wall_record_contacts": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32]),
    "ellgran_wall_keep_inelastic_loads": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32]),
    "ellgran_wall_tally_following_half_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_recorded_count": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_wall_recorded": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]),
    "ellgran_wall_record_triangles": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_int32]),
    "ellgran_wall_triangle_count": (ctypes.c_size_t, [ctypes.c_void_p]),
    "ellgran_wall_triangle_loads": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_write_triangle_loads": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_wall_missing_image": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_servo_follow": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_double]),
    "ellgran_volumes": (ctypes.c_int32, [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_moments_of_inertia": (ctypes.c_int32, [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_angular_momentum": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_mean_angular_velocity": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]),
    "ellgran_add_pairs_to_step_sums": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_add_wall_to_step_sums": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_stable_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_step_for_error": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]),
    "ellgran_staged_new": (ctypes.c_int32, [ctypes.c_void_p]),
    "ellgran_staged_free": (None, [ctypes.c_void_p]),
    "ellgran_staged_set_time_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_double]),
    "ellgran_staged_prepare": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_neighbours": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_pair": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_wall": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]),
    "ellgran_staged_equivalent_radius": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_circular_stiffness": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_section_area": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_normal": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_double, ctypes.c_void_p]),
    "ellgran_staged_tangential": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_staged_forces": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_last_error": (ctypes.c_char_p, []),
    "ellgran_contact_stiffness": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_collision": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_two_grain_limits": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_rayleigh_time": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_tally_following_half_step": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_abi_version": (ctypes.c_uint32, []),
    "ellgran_version": (ctypes.c_char_p, []),
    "ellgran_pair_gaps": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]),
    "ellgran_pair_energies": (ctypes.c_int32, [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]),
}
