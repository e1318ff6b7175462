// SPDX-License-Identifier: MIT OR Apache-2.0
//! `ellgran_contact`: two bodies for a few steps, with what is remembered of them.

use ellgran::c_api::contact::*;

use super::scene::*;

pub fn run(bytes: &[u8]) {
    let _ = steps(&mut Bytes::new(bytes));
}

fn steps(u: &mut Bytes) -> arbitrary::Result<()> {
    let Some(laws) = Laws::read(u)? else {
        return Ok(());
    };
    let mut bodies = [body(u, laws.types)?, body(u, laws.types)?];
    let step = step(u)?;
    let mut touching = 0;
    let mut history = vec![0.0; laws.length];
    for _ in 0..3 {
        contact(&laws, &bodies, &step, &mut touching, &mut history);
        for body in &mut bodies {
            advance(body, step.time_step);
        }
        if one_in(u, 4)? {
            bodies.swap(0, 1);
        }
    }
    Ok(())
}

/// One contact, checked.
pub fn contact(
    laws: &Laws,
    [i, j]: &[EllgranBody; 2],
    step: &ellgran::c_api::particles::EllgranStep,
    touching: &mut i32,
    history: &mut [f64],
) {
    let mut geometry = sized::<EllgranContactGeometry>();
    let mut force = sized::<EllgranContactForce>();
    let before = (*touching, history.to_vec());
    // SAFETY: all pointers are valid, and the history is as long as one of these laws.
    let status = unsafe {
        ellgran_contact(
            laws.pointer,
            i,
            j,
            step,
            touching,
            history.as_mut_ptr(),
            &mut geometry,
            &mut force,
        )
    };
    if !succeeded(status) {
        assert_eq!(*touching, before.0);
        assert!(
            same_bits(history, &before.1),
            "history of a call that failed"
        );
        assert_eq!((geometry.penetration, force.force), (0.0, [0.0; 3]));
        return;
    }
    assert_eq!(*touching, geometry.touching);
    assert_finite("penetration", &[geometry.penetration]);
    for vector in [
        geometry.normal,
        geometry.contact_point,
        geometry.witness_i,
        geometry.witness_j,
        geometry.major_direction,
        force.force,
        force.torque_i,
        force.torque_j,
        force.tangential_force,
        force.displacement,
        force.viscous_force,
        force.frictional_force,
        force.frictional_couple,
        force.viscous_couple,
    ] {
        assert_finite("vectors", &vector);
    }
    assert_finite(
        "numbers",
        &[
            geometry.curvature_a,
            geometry.curvature_b,
            force.normal_force,
            force.penetration_rate,
            force.elastic_energy,
            force.tangential_energy,
            force.viscous_power,
            force.tangential_power,
            force.contact_semi_axes[0],
            force.contact_semi_axes[1],
        ],
    );
    if *touching != 0 {
        assert_finite("history", history);
    }
}
