// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sizes, offsets and constants are those of the Rust side for a C and a C++ compiler, and every declared function is in
//! the library.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use ellgran::c_api::contact::{EllgranBody, EllgranContactForce, EllgranContactGeometry};
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::grain_sums::ELLGRAN_GRAIN_SUMS_LENGTH;
use ellgran::c_api::law::*;
use ellgran::c_api::many_contacts::{EllgranContactArrays, EllgranStiffnessArrays};
use ellgran::c_api::motion::EllgranMotion;
use ellgran::c_api::neighbour_list::EllgranNeighbourList;
use ellgran::c_api::particles::{EllgranParticles, EllgranStep};
use ellgran::c_api::plane::EllgranPlane;
use ellgran::c_api::recorded::EllgranContactPlace;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::servo::EllgranServo;
use ellgran::c_api::stable_step::{EllgranContactExtremes, ELLGRAN_STEP_SUMS_LENGTH};
use ellgran::c_api::staged::{EllgranStagedGeometry, EllgranStagedHistory, EllgranWallSurface};
use ellgran::c_api::status::*;
use ellgran::c_api::stiffness::EllgranContactStiffness;
use ellgran::c_api::tallies::EllgranTallies;
use ellgran::c_api::version::ELLGRAN_ABI_VERSION;

use crate::emulator;
use crate::harness::{
    build, compiler, declarations, declared_functions, fail, installed, scratch, succeed, Language,
};

/// What must hold, as C expressions.
#[derive(Default)]
struct Claims {
    names: BTreeSet<&'static str>,
    expressions: Vec<String>,
}

/// Size of the field that an accessor borrows.
fn field_size<S, F>(_: fn(&S) -> &F) -> usize {
    size_of::<F>()
}

macro_rules! structures {
    ($claims:ident: $($name:ident { $($field:ident),* $(,)? })*) => {$(
        // Fails to compile where a field is missing here.
        let _ = |x: $name| { let $name { $($field: _),* } = x; };
        let mut end = 0;
        $claims.names.insert(stringify!($name));
        $claims.expressions.push(format!("sizeof({}) == {}", stringify!($name), size_of::<$name>()));
        $(
            let (name, field) = (stringify!($name), stringify!($field));
            let bytes = field_size(|x: &$name| &x.$field);
            $claims.expressions.push(format!(
                "offsetof({name}, {field}) == {}", core::mem::offset_of!($name, $field)));
            $claims.expressions.push(format!("sizeof((({name} *) 0)->{field}) == {bytes}"));
            end = end.max(core::mem::offset_of!($name, $field) + bytes);
        )*
        // A field that a later version adds must not lie in what older callers never set.
        assert_eq!(end, size_of::<$name>(), "{} ends in padding", stringify!($name));
    )*};
}

macro_rules! constants {
    ($claims:ident: $($name:ident)*) => {$(
        $claims.names.insert(stringify!($name));
        $claims.expressions.push(format!("{} == {}", stringify!($name), $name));
    )*};
}

fn claims() -> Claims {
    let mut claims = Claims::default();
    structures! { claims:
        EllgranBody {
            size, position, quaternion, semi_axes, velocity, angular_velocity, mass, particle_type, identifier,
            velocity_change, angular_velocity_change, velocities_of_step,
        }
        EllgranContactGeometry {
            size, touching, penetration, normal, contact_point, witness_i, witness_j, curvature_a, curvature_b,
            major_direction,
        }
        EllgranContactForce {
            size, force, torque_i, torque_j, normal_force, tangential_force, displacement, penetration_rate, elastic_energy,
            tangential_energy, viscous_force, frictional_force, viscous_power, tangential_power, contact_semi_axes,
            frictional_couple, viscous_couple,
        }
        EllgranLawParameters {
            size, normal, damping, tangential, closure, unloading, factors, displacement, conservative,
            limit_force, youngs_modulus, poissons_ratio, shear_viscosity, bulk_viscosity, relaxation_time, restitution,
            normal_stiffness, normal_damping, friction, tangential_stiffness, tangential_damping,
            rolling, twisting, rolling_stiffness, rolling_damping, rolling_friction,
            twisting_stiffness, twisting_damping, twisting_friction, viscosity, reserved,
        }
        EllgranMixture {
            size, effective_modulus, effective_shear_modulus, normal_relaxation_time, tangential_relaxation_time, share_i,
        }
        EllgranMotion {
            size, count, positions, velocities, angular_momenta, forces, torques, masses, shape_indices, semi_axes,
            semi_axes_stride, quaternions, quaternions_stride, masks, group_mask,
            identifier_bytes, identifiers, velocity_changes, loads_before, time_step_before,
        }
        EllgranNeighbourList {
            size, count, central, neighbour_counts, neighbours, index_mask, special_shift, special_factors, newton,
            unchanged, keep_history, record_contacts, touching, history,
        }
        EllgranParticles {
            size, owned_count, count, positions, velocities, angular_velocities, angular_momenta, masses, contact_masses,
            types, shape_indices, semi_axes, semi_axes_stride, quaternions, quaternions_stride, identifiers,
            identifier_bytes, forces, torques, velocity_changes, unchanged, prepared_by,
        }
        EllgranWallSurface {
            size, point, normal, direction, curvatures, turning_radii, velocity, others_share, others_share_by_position,
            others_share_by_rotation, velocity_change,
        }
        EllgranStagedGeometry { size, touching, penetration, normal, contact_point }
        EllgranStagedHistory { size, friction, touched, normal }
        EllgranLentTriangles { size, count, corners, velocities, particle_count, near_starts, near, velocity_changes }
        EllgranFoundWallContact {
            size, particle, part, triangle, point, velocity, touched, is_forgotten, last_normal, history,
        }
        EllgranContactStiffness {
            size, normal_stiffness, tangential_stiffness, normal_damping, tangential_damping, critical_step,
        }
        EllgranContactArrays {
            size, penetration, normal, contact_point, witness_i, witness_j, curvatures, major_direction, contact_semi_axes,
            force, torque_i, torque_j, normal_force, tangential_force, displacement, penetration_rate, elastic_energy,
            tangential_energy, viscous_force, frictional_force, viscous_power, tangential_power,
            frictional_couple, viscous_couple,
        }
        EllgranStiffnessArrays {
            size, normal_stiffness, tangential_stiffness, normal_damping, tangential_damping, critical_step,
        }
        EllgranContactExtremes {
            size, touching_count, shortest_collision, collision_speed, collision_stiffness, collision_inverse_mass,
            collision_effective_mass, collision_identifiers, collision_types, deepest_overlap, deepest_identifiers,
        }
        EllgranContactPlace { size, i, j, entry }
        EllgranStep { size, advance_history, time_step }
        EllgranPlane { size, point, normal, velocity, velocity_change }
        EllgranWallShape { size, name, point, axis, radii, bounds, ends, side, unused }
        EllgranWallMotion {
            size, origin, displacement, quaternion, velocity, angular_velocity, along_itself, unused, velocity_change,
            angular_velocity_change,
        }
        EllgranWallLoad {
            size, force, torque, power, contact_count, stiffness, damping, crowded_particle, viscous_force, viscous_torque,
            tangential_force, tangential_torque,
        }
        EllgranServo { size, target, gain, largest_speed, steady_velocity, velocity }
        EllgranRecordedWallContact {
            size, particle, part, point, normal, penetration, normal_force, tangential_force, force, torque, elastic_energy,
        }
        EllgranTallies {
            size, particle_energies, particle_virials, inelastic_loads, wall_powers, viscous_dissipation, tangential_work,
            frictional_dissipation, dissipated_energy, normal_elastic_energy, tangential_elastic_energy, virial,
            touching_count, pair_count,
        }
    }
    constants! { claims:
        ELLGRAN_ABI_VERSION
        ELLGRAN_NORMAL_HERTZ ELLGRAN_NORMAL_NFD ELLGRAN_NORMAL_LSD
        ELLGRAN_DAMPING_NONE ELLGRAN_DAMPING_RESTITUTION ELLGRAN_DAMPING_RELAXATION
        ELLGRAN_TANGENTIAL_NONE ELLGRAN_TANGENTIAL_TFD ELLGRAN_TANGENTIAL_MINDLIN ELLGRAN_TANGENTIAL_LINEAR
        ELLGRAN_CLOSURE_ENERGY ELLGRAN_CLOSURE_SURFACE ELLGRAN_CLOSURE_BRILLIANTOV
        ELLGRAN_VISCOSITY_FIRST_ORDER ELLGRAN_VISCOSITY_MEMORY
        ELLGRAN_UNLOADING_TING ELLGRAN_UNLOADING_FIRST_ORDER
        ELLGRAN_FACTORS_EXACT ELLGRAN_FACTORS_HALE
        ELLGRAN_DISPLACEMENT_TOTAL ELLGRAN_DISPLACEMENT_INCREMENTAL ELLGRAN_DISPLACEMENT_RESCALED
        ELLGRAN_DISPLACEMENT_HYSTERETIC
        ELLGRAN_ROLLING_NONE ELLGRAN_ROLLING_SDS
        ELLGRAN_TWISTING_NONE ELLGRAN_TWISTING_MARSHALL ELLGRAN_TWISTING_SDS ELLGRAN_TWISTING_LUBKIN
        ELLGRAN_OPTION_NO_WARM_START
        ELLGRAN_STEP_SUMS_LENGTH
        ELLGRAN_GRAIN_SUMS_LENGTH
        ELLGRAN_SIDE_OF_CENTRE ELLGRAN_SIDE_INSIDE ELLGRAN_SIDE_OUTSIDE
        ELLGRAN_END_NONE ELLGRAN_END_OPEN ELLGRAN_END_CLOSED
        ELLGRAN_SUCCESS ELLGRAN_ERROR_NULL_POINTER ELLGRAN_ERROR_ARGUMENT ELLGRAN_ERROR_TEXT ELLGRAN_ERROR_LAW
        ELLGRAN_ERROR_HALE ELLGRAN_ERROR_PARTICLE ELLGRAN_ERROR_HISTORY ELLGRAN_ERROR_RESULT ELLGRAN_ERROR_PANIC
    }
    claims
}

#[test]
fn every_structure_and_constant_of_the_header_is_compared() {
    let text = declarations();
    let named: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| {
            let constant = line
                .strip_prefix("#define ")
                .and_then(|l| l.split_whitespace().next())
                .filter(|name| *name != "ELLGRAN_H" && !name.contains('('));
            let structure = line
                .strip_prefix("typedef struct ")
                .and_then(|l| l.strip_suffix(" {"));
            constant.or(structure)
        })
        .collect();
    assert_eq!(named, claims().names);
}

#[test]
fn every_name_of_the_header_is_ours() {
    let text = declarations();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["#define", name, ..] => assert!(name.starts_with("ELLGRAN_"), "{line}"),
            ["typedef", "struct", name, ..] => assert!(name.starts_with("Ellgran"), "{line}"),
            _ => {}
        }
    }
}

/// C99 has no static assertion: an array of negative size stands for one.
fn assertions(expressions: &[String]) -> String {
    let mut text = String::from("#include <ellgran.h>\n");
    for (k, expression) in expressions.iter().enumerate() {
        let _ = writeln!(text, "typedef char claim_{k}[({expression}) ? 1 : -1];");
    }
    text + "int main(void) { return 0; }\n"
}

fn compile(language: Language, directory: &Path, text: &str) -> Command {
    let name = match language {
        Language::C99 => "layout.c",
        Language::Cxx11 => "layout.cpp",
    };
    let source = directory.join(name);
    fs::write(&source, text).expect("a source");
    let mut command = compiler(language);
    command
        .arg("-I")
        .arg(installed().prefix.join("include"))
        .arg("-c")
        .arg(source)
        .arg("-o")
        .arg(directory.join("layout.o"));
    command
}

#[test]
fn sizes_offsets_and_constants_are_the_same() {
    let directory = scratch("layout");
    let mut expressions = claims().expressions;
    assert!(expressions.len() > 150);
    for language in [Language::C99, Language::Cxx11] {
        succeed(&mut compile(
            language,
            &directory,
            &assertions(&expressions),
        ));
    }
    // One false claim among them must not pass.
    expressions.push("offsetof(EllgranBody, quaternion) == 40".into());
    fail(&mut compile(
        Language::C99,
        &directory,
        &assertions(&expressions),
    ));
}

#[test]
fn every_declared_function_is_in_the_library() {
    let names = declared_functions();
    assert!(names.len() > 15, "{names:?}");
    let mut program = String::from(
        "#include <ellgran.h>\ntypedef void (*Function)(void);\nstatic const Function all[] = {\n",
    );
    for name in &names {
        let _ = writeln!(program, "  (Function) {name},");
    }
    program +=
        "};\nint main(void) { return all[ellgran_abi_version() - ELLGRAN_ABI_VERSION] == NULL; }\n";
    let directory = scratch("functions");
    let source = directory.join("functions.c");
    fs::write(&source, program).expect("a source");
    let linked = directory.join("functions");
    succeed(&mut build(Language::C99, &source, &linked, &[]));
    succeed(&mut emulator::program(&linked));
}
