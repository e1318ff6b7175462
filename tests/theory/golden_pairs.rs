// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geometry, force and torques of 800 random pairs against the 60-digit reference.

use crate::support::golden::{pairs, GoldenPair, Wrench};
use crate::support::scene::{laws, size, touch, vector, Felt};

/// 1e-9, or what the rounding of coordinates of this size allows at this overlap.
fn tolerance(p: &GoldenPair) -> f64 {
    f64::max(1e-9, 8.0 * f64::EPSILON * size(&p.i, &p.j) / p.penetration)
}

fn feel(p: &GoldenPair, keyword: &str) -> Felt {
    let deck = |k: usize| {
        let [e, nu] = p.materials[k];
        format!("hertz {e:e} {nu:e} conservative {keyword}")
    };
    let laws = laws(&[&deck(0), &deck(1)]);
    touch(&laws, &p.i, &p.j).unwrap_or_else(|| panic!("case {} does not touch", p.case))
}

struct Worst {
    what: &'static str,
    error: f64,
    of_tolerance: f64,
}

fn hold(p: &GoldenPair, worst: &mut [Worst], errors: &[f64]) {
    let allowed = tolerance(p);
    for (w, &e) in worst.iter_mut().zip(errors) {
        if e / allowed > w.of_tolerance {
            w.of_tolerance = e / allowed;
            w.error = e;
        }
        assert!(
            e <= allowed,
            "case {}: {} off by {e:e}, allowed {allowed:e}",
            p.case,
            w.what
        );
    }
}

fn table(names: &[&'static str]) -> Vec<Worst> {
    names
        .iter()
        .map(|what| Worst {
            what,
            error: 0.0,
            of_tolerance: 0.0,
        })
        .collect()
}

fn show(aspect: usize, worst: &[Worst]) {
    for w in worst {
        println!(
            "aspect ratio {aspect}: {} off by {:.1e}, {:.3} of what is allowed",
            w.what, w.error, w.of_tolerance
        );
    }
}

#[test]
fn geometry() {
    for aspect in [10, 100] {
        let mut worst = table(&["penetration", "normal", "contact point", "A", "B"]);
        for p in pairs(aspect) {
            let g = feel(&p, "no").geometry;
            let errors = [
                (g.penetration / p.penetration - 1.0).abs(),
                (vector(g.normal) - p.normal).norm(),
                (vector(g.contact_point) - p.contact_point).norm() / size(&p.i, &p.j),
                (g.curvature_a / p.curvature_a - 1.0).abs(),
                (g.curvature_b / p.curvature_b - 1.0).abs(),
            ];
            hold(&p, &mut worst, &errors);
        }
        show(aspect, &worst);
    }
}

fn wrench_errors(p: &GoldenPair, felt: &Felt, wanted: &Wrench) -> [f64; 3] {
    let force = wanted.force.norm();
    let arm = size(&p.i, &p.j);
    // A torque is held to its own size, or to a thousandth of force times size where it nearly vanishes.
    let torque = |got: nalgebra::Vector3<f64>, wanted: nalgebra::Vector3<f64>| {
        (got - wanted).norm() / wanted.norm().max(1e-3 * force * arm)
    };
    [
        (felt.force - wanted.force).norm() / force,
        torque(felt.torque_i, wanted.torque_i),
        torque(felt.torque_j, wanted.torque_j),
    ]
}

#[test]
fn hertz_force_and_torques() {
    for aspect in [10, 100] {
        let mut worst = table(&["force", "torque on i", "torque on j"]);
        for p in pairs(aspect) {
            let errors = wrench_errors(&p, &feel(&p, "no"), &p.hertz);
            hold(&p, &mut worst, &errors);
        }
        show(aspect, &worst);
    }
}

#[test]
fn conservative_force_and_torques() {
    for aspect in [10, 100] {
        let mut worst = table(&["conservative force", "torque on i", "torque on j"]);
        let mut matters = 0.0f64;
        for p in pairs(aspect) {
            let felt = feel(&p, "yes");
            let errors = wrench_errors(&p, &felt, &p.conservative);
            hold(&p, &mut worst, &errors);
            matters =
                matters.max((p.conservative.force - p.hertz.force).norm() / p.hertz.force.norm());
        }
        show(aspect, &worst);
        println!(
            "aspect ratio {aspect}: the additional terms are up to {matters:.1e} of the force"
        );
        assert!(matters > 1e-3);
    }
}
