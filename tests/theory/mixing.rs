// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two unlike materials: moduli and relaxation times in series.

use crate::support::scene::{body, laws, pair_law, parameters, touch, vector, Rotation, Vector};
use ellgran::force::damping::{normal_relaxation_time, tangential_relaxation_numbers};
use ellgran::force::{Closure, PairLaw};

const SOFT: &str = "nfd 2e6 0.45 30 5 tangential mindlin 0.3";
const HARD: &str = "nfd 9e7 0.15 700 900 tangential mindlin 0.3";

#[test]
fn effective_modulus_and_relaxation_time_in_series() {
    let (i, j) = (parameters(SOFT), parameters(HARD));
    let law = PairLaw::resolve(&i, &j).unwrap();
    let ci = (1.0 - 0.45f64.powi(2)) / 2e6;
    let cj = (1.0 - 0.15f64.powi(2)) / 9e7;
    let modulus = 1.0 / (ci + cj);
    assert!((law.constants.normal.stiffness / (4.0 / 3.0 * modulus) - 1.0).abs() < 1e-14);
    let time =
        |p: &ellgran::force::LawParameters| normal_relaxation_time(&p.material(), Closure::Energy);
    let wanted = (time(&i) * ci + time(&j) * cj) / (ci + cj);
    assert!((law.constants.normal.damping / wanted - 1.0).abs() < 1e-14);
}

#[test]
fn tangential_compliances_of_the_two_bodies_add() {
    let law = PairLaw::resolve(&parameters(SOFT), &parameters(HARD)).unwrap();
    let shear = |e: f64, nu: f64| e / (2.0 * (1.0 + nu));
    let (gi, gj) = (shear(2e6, 0.45), shear(9e7, 0.15));
    for beta in [0.5, 0.3, 0.1, 0.7] {
        // C_k ~ (1 - nu beta)/G and C_n ~ (1 - nu)/G, with the same factor K/(2 pi a).
        let wanted = ((1.0 - 0.45 * beta) / gi + (1.0 - 0.15 * beta) / gj)
            / ((1.0 - 0.45) / gi + (1.0 - 0.15) / gj);
        let got = law.constants.tangential.kappa0 - law.constants.tangential.kappa1 * beta;
        assert!((got / wanted - 1.0).abs() < 1e-14, "beta {beta}");
    }
}

#[test]
fn tangential_relaxation_of_the_energy_closure_as_in_section_4() {
    let p = parameters(SOFT);
    let nu = 0.45;
    let (tau1, tau2) = (
        p.material().shear_relaxation_time(),
        p.material().bulk_relaxation_time(),
    );
    let (t0, t1) = tangential_relaxation_numbers(&p.material(), Closure::Energy);
    for beta in [0.5, 0.2, 0.8] {
        let wanted = tau1 * (3.0 - beta * (1.0 + 2.0 * nu - 2.0 * nu * nu))
            / (3.0 * (1.0 - beta * nu))
            + tau2 * beta * (1.0 + nu) * (1.0 - 2.0 * nu) / (3.0 * (1.0 - beta * nu));
        let got = (t0 - t1 * beta) / (1.0 - nu * beta);
        assert!(
            (got / wanted - 1.0).abs() < 1e-14,
            "beta {beta}: {got} {wanted}"
        );
    }
}

/// The other closures take the shear relaxation time, whatever the ellipse.
#[test]
fn tangential_relaxation_of_the_other_closures_is_that_of_shear() {
    let material = parameters(SOFT).material();
    let (nu, tau1) = (0.45, material.shear_relaxation_time());
    for closure in [Closure::Surface, Closure::Brilliantov] {
        let (t0, t1) = tangential_relaxation_numbers(&material, closure);
        for beta in [0.0, 0.5, 0.8, 1.0] {
            let got = (t0 - t1 * beta) / (1.0 - nu * beta);
            assert!(
                (got / tau1 - 1.0).abs() < 1e-14,
                "{closure:?}, beta {beta}: {got}"
            );
        }
    }
}

/// Constants of a contact: geometric means, and two springs in series.
#[test]
fn constants_of_the_contact_are_means() {
    let law = |i: &str, j: &str| PairLaw::resolve(&parameters(i), &parameters(j)).unwrap();
    let deck =
        |e: f64, mu: f64| format!("hertz 1e7 0.3 damping restitution {e} tangential mindlin {mu}");
    let mixed = law(&deck(0.36, 0.9), &deck(0.81, 0.4));
    let wanted = pair_law(&deck(0.54, 0.6));
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
    let of = |law: &PairLaw| law.constants.normal.restitution;
    assert!(close(of(&mixed), of(&wanted)));
    assert!(close(mixed.constants.tangential.friction, 0.6));
    let deck = |kn: f64, cn: f64, kt: f64, ct: f64| {
        format!("lsd {kn} {cn} tangential linear {kt} {ct} 0.5")
    };
    let mixed = law(&deck(100.0, 4.0, 60.0, 9.0), &deck(300.0, 1.0, 20.0, 0.0));
    let wanted = pair_law(&deck(150.0, 2.0, 30.0, 0.0));
    let (found, wanted) = (&mixed.constants, &wanted.constants);
    assert!(close(found.normal.stiffness, wanted.normal.stiffness));
    assert!(close(found.normal.damping, wanted.normal.damping));
    assert!(close(found.tangential.stiffness, 30.0));
    assert_eq!(found.tangential.damping, 0.0);
}

#[test]
fn a_pair_mixed_with_itself_is_the_pair() {
    let law = PairLaw::resolve(&parameters(SOFT), &parameters(SOFT)).unwrap();
    assert_eq!(law.kinds, pair_law(SOFT).kinds);
    assert_eq!(law.constants.share_i, 0.5);
}

#[test]
fn the_contact_point_divides_the_penetration_by_compliance() {
    let both = laws(&[SOFT, HARD]);
    let i = body([1.0; 3], Vector::zeros(), Rotation::identity());
    let mut j = body([1.0; 3], Vector::new(1.99, 0.0, 0.0), Rotation::identity());
    j.particle_type = 2;
    let felt = touch(&both, &i, &j).unwrap();
    let ci = (1.0 - 0.45f64.powi(2)) / 2e6;
    let cj = (1.0 - 0.15f64.powi(2)) / 9e7;
    // The soft body gives way further.
    let wanted = 1.0 - 0.01 * ci / (ci + cj);
    assert!((vector(felt.geometry.contact_point).x - wanted).abs() < 1e-14);
}

/// What the engines print of a law: each term of the deck, with the constants of the pair.
#[test]
fn a_law_in_words() {
    for (deck, terms) in [
        ("hertz 1e7 0.3", vec!["hertz"]),
        (
            "hertz 1e7 0.3 damping restitution 0.5 tangential mindlin 0.25",
            vec!["hertz", "restitution", "mindlin", "0.25"],
        ),
        (
            "nfd 1e7 0.3 50 60 tangential tfd 0.5 rolling sds 11 12 0.125 twisting sds 13 14 0.375",
            vec![
                "hertz E*",
                "unloading ting",
                "tfd",
                "0.5",
                "conservative",
                "rolling sds",
                "11",
                "12",
                "0.125",
                "twisting sds",
                "13",
                "14",
                "0.375",
            ],
        ),
        (
            "nfd 1e7 0.3 50 60 tangential tfd 0.5 twisting marshall conservative no",
            vec!["twisting marshall"],
        ),
        (
            "nfd 1e7 0.3 50 60 viscosity memory",
            vec!["A_n", "memory A_n at once", " + ", " in "],
        ),
        (
            "hertz 1e7 0.3 factors hale conservative no",
            vec!["factors hale"],
        ),
        ("lsd 60 0.25 conservative no", vec!["lsd kn 60 cn 0.25"]),
    ] {
        let law = pair_law(deck);
        let said = law.describe();
        if deck.starts_with("nfd") {
            let time = format!(" A_n {} ", law.normal_relaxation_time());
            assert!(said.contains(&time), "{said:?} lacks{time}");
        }
        for term in terms {
            assert!(said.contains(term), "{deck}: {said:?} lacks {term}");
        }
        for (word, asked) in [
            ("conservative", !deck.contains("conservative no")),
            ("rolling", deck.contains("rolling")),
            ("twisting", deck.contains("twisting")),
            ("hale", deck.contains("hale")),
            (" memory", deck.contains("memory")),
        ] {
            assert_eq!(said.contains(word), asked, "{deck}: {said:?} and {word}");
        }
    }
}

/// Laws of which the engines warn: a stiffness that changes with the contact, a memory that is not reduced, and nothing that dissipates.
#[test]
fn laws_that_can_create_energy() {
    for (can, deck) in [
        (
            true,
            "hertz 1e7 0.3 tangential mindlin 0.5 displacement total",
        ),
        (
            true,
            "hertz 1e7 0.3 tangential mindlin 0.5 displacement incremental",
        ),
        (true, "hertz 1e7 0.3 tangential tfd 0.5 displacement total"),
        (false, "hertz 1e7 0.3 tangential tfd 0.5"),
        (
            false,
            "hertz 1e7 0.3 tangential mindlin 0.5 displacement rescaled",
        ),
        (false, "hertz 1e7 0.3"),
        (
            false,
            "hertz 1e7 0.3 damping restitution 0.9 tangential tfd 0.5 displacement total",
        ),
        (
            false,
            "nfd 1e7 0.3 50 50 tangential tfd 0.5 displacement total",
        ),
        (false, "nfd 1e7 0.3 50 50 tangential tfd 0.5"),
        (false, "lsd 1e4 0.1 tangential linear 1e4 0 0.5"),
    ] {
        assert_eq!(pair_law(deck).can_create_energy(), can, "{deck}");
    }
}
