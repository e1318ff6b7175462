// SPDX-License-Identifier: MIT OR Apache-2.0
// Prints the forces of the laws that docs/how-to-add-a-law.md adds; appended to the modules of the changed sources.

use contact::stability::collision;
use contact::{one_contact, prepare_body, Body, Laws, Step};
use force::syntax::parse;
use force::{tangential_force, Factors, PairLaw};
use vector::{Symmetric2, Vector2};

fn main() {
    let (quadratic, _) = parse(&["quadratic", "7000"]).expect("the word is known");
    let laws = Laws::new(1, &[Some(quadratic)], true).expect("the law is valid");
    let grain = |z: f64| {
        let body = Body {
            position: [0.0, 0.0, z],
            quaternion: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [1.0; 3],
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            mass: 1.0,
            particle_type: 1,
            identifier: 1,
        };
        prepare_body(&body, Some(1)).expect("the body is valid")
    };
    let (i, j) = (grain(0.0), grain(1.99));
    let step = Step { time_step: 1e-6, advance_history: true };
    let mut history = vec![0.0; laws.layout().length];
    let contact = one_contact(&laws, &i, &j, &step, &mut false, &mut history);
    let (_, forces) = contact.expect("no Hale form").expect("they touch");
    println!("{:e} {:e}", forces.normal_force, forces.elastic_energy);
    println!("{:e}", collision(&laws, &i, &j, 0.1).expect("no Hale form").time);

    let words = ["hertz", "1e6", "0.3", "tangential", "parabolic", "0.5", "displacement", "total"];
    let (parabolic, _) = parse(&words).expect("the word is known");
    let law = PairLaw::resolve(&parabolic, &parabolic).expect("the law is valid");
    let (normal, stiffness) = (3.0, 100.0);
    let limit = 0.5 * normal;
    // A circular contact: the compliance is (kappa0 - kappa1/2)/stiffness.
    let c = &law.constants.tangential;
    let all_slides = 2.0 * limit * (c.kappa0 - 0.5 * c.kappa1) / stiffness;
    for share in [0.5, 1.5] {
        let t = tangential_force(
            &law.kinds.tangential,
            c,
            (normal, stiffness, 0.0),
            &Factors { phi: 1.0, sigma: 1.0 / 6.0 },
            Symmetric2::new(1.0, 0.0, 1.0),
            Vector2::new(0.0, 0.0),
            0.0,
            true,
            Vector2::new(share * all_slides, 0.0),
            Vector2::new(0.0, 0.0),
        );
        println!("{:e}", -t.force.u / limit);
    }
}
