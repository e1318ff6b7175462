// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which terms does a resolved law have? What a constant of zero leaves out, and what a pair of unlike bodies has of each.

use crate::support::scene::{pair_law, parameters};
use ellgran::force::tangential::Tangential;
use ellgran::force::{Closure, PairLaw};

/// A closure is of no meaning to a law without viscosities.
#[test]
fn closures_matter_to_nfd_alone() {
    for (deck, mixes) in [("hertz 1e7 0.3", true), ("nfd 1e7 0.3 50 60", false)] {
        let (i, mut j) = (parameters(deck), parameters(deck));
        j.closure = Closure::Surface;
        assert_ne!(i.closure, j.closure);
        assert_eq!(PairLaw::resolve(&i, &j).is_ok(), mixes, "{deck}");
    }
}

#[test]
fn without_friction_nothing_drags_or_twists() {
    for (twisting, displacement) in [("marshall", "rescaled"), ("lubkin", "hysteretic")] {
        for (friction, any) in [(0.3, true), (0.0, false)] {
            let law = pair_law(&format!(
                "nfd 1e7 0.3 50 60 tangential tfd {friction} displacement {displacement} twisting {twisting}"
            ));
            assert_eq!(law.kinds.tangential.law != Tangential::None, any);
            assert_eq!(law.resistance.any(), any, "{twisting} {friction}");
        }
    }
}

#[test]
fn a_linear_spring_has_a_dashpot_where_it_is_given_one() {
    let mut p = parameters("hertz 1e7 0.3");
    p.tangential = Tangential::Linear;
    (p.tangential_stiffness, p.friction) = (10.0, 0.3);
    for (damping, viscous) in [(0.2, true), (0.0, false)] {
        p.tangential_damping = damping;
        let law = PairLaw::resolve(&p, &p).unwrap();
        assert_eq!(law.kinds.tangential.viscous, viscous);
    }
}

/// Of spheres whose viscosities are in proportion at Poisson's ratio 0 the shape of the ellipse is of no meaning: one of the two constants of the
/// dashpot is zero, and the dashpot is there all the same.
#[test]
fn proportional_viscosity_has_a_tangential_dashpot() {
    let law = pair_law("nfd 1e7 0 30 10 tangential mindlin 0.3");
    let c = &law.constants.tangential;
    assert!(c.tau0 > 0.0 && c.tau1 == 0.0, "{c:?}");
    assert!(law.kinds.tangential.viscous);
}

#[test]
fn a_law_takes_another_restitution_as_if_it_had_been_given() {
    let deck = |e: f64| format!("hertz 1e7 0.3 damping restitution {e}");
    for (from, to) in [(1.0, 0.6), (0.6, 1.0), (0.3, 0.6)] {
        let mut law = pair_law(&deck(from));
        law.set_restitution(to).unwrap();
        let given = pair_law(&deck(to));
        assert_eq!(law.kinds, given.kinds, "{from} to {to}");
        let of = |law: &PairLaw| law.constants.normal.restitution;
        assert_eq!(of(&law), of(&given), "{from} to {to}");
    }
}

/// An elastic body beside a viscous one: nothing acts as a dashpot at once, and yet the pair relaxes.
#[test]
fn memory_of_one_body_alone_is_a_relaxation() {
    let deck = |eta: &str| {
        format!(
            "nfd 1e7 0.3 {eta} viscosity memory tangential mindlin 0.3 displacement incremental"
        )
    };
    let law = PairLaw::resolve(&parameters(&deck("0 0")), &parameters(&deck("50 60"))).unwrap();
    assert_eq!(law.constants.normal.damping, 0.0);
    assert!(law.kinds.normal.memory > 0 && law.kinds.normal.relaxation);
    assert!(!law.can_create_energy());
}

/// A relaxing part resists no more than its spring, and one that is stiffer than 30 static springs no more than its dashpot.
#[test]
fn the_largest_springs_hold_those_of_the_memory() {
    let mut seen = [false; 2];
    for deck in [
        "nfd 1e7 0.3 50 0",
        "nfd 1e7 0.3 50 600",
        "nfd 1e7 0.499 50 0",
    ] {
        let law = pair_law(&format!("{deck} viscosity memory"));
        let (mut spring, mut dashpot) = (1.0, law.constants.normal.damping);
        for p in &law.constants.memory.parts()[..law.kinds.normal.memory as usize] {
            let modulus = p.share * p.ratio;
            let stiff = modulus > 30.0;
            seen[usize::from(stiff)] = true;
            if stiff {
                dashpot += modulus / p.rate;
            } else {
                spring += modulus;
            }
        }
        let (got_spring, got_dashpot) = law.largest_springs(2.0, 1e-3);
        assert!((got_spring / (2.0 * spring) - 1.0).abs() < 1e-14, "{deck}");
        assert!(
            (got_dashpot - 2.0 * dashpot).abs() <= 1e-14 * 2.0 * dashpot,
            "{deck}"
        );
    }
    assert_eq!(seen, [true; 2]);
}
