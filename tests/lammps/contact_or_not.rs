// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is every contact found, and none invented, where solvers stumble? Judged by Perram and Wertheim's contact function.

use crate::harness::{forces_of_many, Engine, Frame, Grain, Scene};
use crate::shapes::{
    about, add, hertz_stiffness, length, perram_wertheim, rotate, scale, sub, Quaternion, Random,
    Vector, IDENTITY,
};

struct Case {
    name: String,
    grains: [Grain; 2],
}

fn case(
    name: String,
    a: Vector,
    qa: Quaternion,
    b: Vector,
    qb: Quaternion,
    d: Vector,
    turn: Quaternion,
) -> Case {
    let offset = [0.3, -0.7, 0.2];
    let place = |a: Vector, q: Quaternion, x: Vector| {
        let (x, q) = if turn == IDENTITY {
            (x, q)
        } else {
            (rotate(turn, x), crate::shapes::compose(turn, q))
        };
        Grain::new(a, add(offset, x)).turned(q)
    };
    Case {
        name,
        grains: [place(a, qa, [0.0; 3]), place(b, qb, d)],
    }
}

fn contact_function(c: &Case) -> f64 {
    let body = |g: &Grain| (g.semi_axes, g.quaternion, g.position);
    perram_wertheim(body(&c.grains[0]), body(&c.grains[1]))
}

/// Runs the cases; each must have a finite force, which is zero when and only when the bodies are apart.
fn judge(name: &str, cases: &[Case], margin: f64) -> Vec<Vec<Frame>> {
    let engine = Engine::from_environment();
    let half_width = |c: &Case| {
        4.0 * c
            .grains
            .iter()
            .flat_map(|g| g.semi_axes.into_iter().chain(g.position))
            .fold(1.0f64, |m, x| m.max(x.abs()))
    };
    let scenes: Vec<Scene> = cases
        .iter()
        .map(|c| Scene::open(half_width(c), c.grains.to_vec()))
        .collect();
    let laws = vec![
        vec![
            vec!["* * hertz 1e7 0.3".to_string()],
            vec!["* * hertz 1e7 0.3 conservative no".into()]
        ];
        cases.len()
    ];
    let all = forces_of_many(&engine, name, &scenes, &laws, "ellipsoid");
    let (mut touching, mut apart, mut wrong) = (0, 0, vec![]);
    for (c, frames) in cases.iter().zip(&all) {
        let f = contact_function(c);
        assert!(
            (f - 1.0).abs() > margin,
            "{}: too close to call, {f}",
            c.name
        );
        if f < 1.0 {
            touching += 1;
        } else {
            apart += 1;
        }
        for frame in frames {
            let numbers = frame
                .states
                .iter()
                .flat_map(|s| s.force.into_iter().chain(s.torque));
            let finite = numbers.clone().all(f64::is_finite);
            let some_force = length(frame.states[1].force) > 0.0;
            let balanced = length(add(frame.states[0].force, frame.states[1].force))
                <= 1e-14 * length(frame.states[1].force);
            if !finite || some_force != (f < 1.0) || !balanced {
                wrong.push(format!(
                    "{}: contact function {f}, forces {:?}",
                    c.name,
                    numbers.collect::<Vec<_>>()
                ));
            }
        }
    }
    println!(
        "{name}: {touching} touching and {apart} apart, {} wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    all
}

#[test]
fn both_versions_exactly_parallel_and_crossed_needles() {
    let mut cases = vec![];
    let quarter = about([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    for aspect in [3.0, 10.0, 30.0, 100.0] {
        for gap in [-0.05, -1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3, 0.05] {
            for (t, turn) in [
                IDENTITY,
                about([1.0, 2.0, -0.5], 1.0),
                about([0.1, 0.2, 0.9], 2.7),
            ]
            .into_iter()
            .enumerate()
            {
                let a = [aspect, 1.0, 1.0];
                let flat = [aspect, 1.0, 0.5];
                let mut push = |what: &str, a: Vector, b: Vector, qb: Quaternion, d: Vector| {
                    cases.push(case(
                        format!("{what}, aspect {aspect}, gap {gap}, turn {t}"),
                        a,
                        IDENTITY,
                        b,
                        qb,
                        d,
                        turn,
                    ));
                };
                push("side by side", a, a, IDENTITY, [0.0, 2.0 + gap, 0.0]);
                push(
                    "side by side, triaxial",
                    flat,
                    flat,
                    IDENTITY,
                    [0.0, 0.0, 1.0 + gap],
                );
                push("end to end", a, a, IDENTITY, [2.0 * aspect + gap, 0.0, 0.0]);
                push("crossed", a, a, quarter, [0.0, 0.0, 2.0 + gap]);
                push("end on side", a, a, quarter, [aspect + 1.0 + gap, 0.0, 0.0]);
                push(
                    "half turned about itself",
                    flat,
                    flat,
                    about([1.0, 0.0, 0.0], std::f64::consts::PI),
                    [0.0, 0.0, 1.0 + gap],
                );
            }
        }
    }
    judge("needles", &cases, 1e-13);
}

#[test]
fn both_versions_needles_beside_each_other_off_centre() {
    let mut cases = vec![];
    let mut random = Random(11);
    for aspect in [3.0, 10.0, 30.0, 100.0] {
        for shift in [0.1, 0.5, 0.9, 1.5, 1.9] {
            for gap in [-1e-2, -1e-5, 1e-5, 1e-2] {
                // parallel bodies of equal shape touch where the scaled distance is two
                let across = (4.0f64 - shift * shift).sqrt() + gap;
                let a = [aspect, 1.0, 1.0];
                let d = [shift * aspect, across, 0.0];
                let name = format!("parallel, aspect {aspect}, shift {shift}, gap {gap}");
                cases.push(case(name.clone(), a, IDENTITY, a, IDENTITY, d, IDENTITY));
                cases.push(case(
                    name + ", turned",
                    a,
                    IDENTITY,
                    a,
                    IDENTITY,
                    d,
                    random.quaternion(),
                ));
            }
        }
    }
    judge("off_centre", &cases, 1e-13);
}

#[test]
fn both_versions_size_ratio_of_one_to_a_hundred() {
    let mut cases = vec![];
    let mut random = Random(12);
    for k in 0..60 {
        let large: Vector = std::array::from_fn(|_| random.between(50.0, 100.0));
        let small: Vector = std::array::from_fn(|_| random.between(0.5, 1.0));
        let (qa, qb, u) = (random.quaternion(), random.quaternion(), random.direction());
        place_near_touch(
            &mut cases,
            format!("size ratio 1:100, {k}"),
            large,
            qa,
            small,
            qb,
            u,
        );
    }
    judge("size_ratio", &cases, 1e-13);
}

#[test]
fn both_versions_random_pairs_about_first_touch() {
    let mut cases = vec![];
    let mut random = Random(13);
    for k in 0..150 {
        let aspect = 100f64.powf(random.uniform());
        let mut axes = || [1.0, aspect.powf(-random.uniform()), 1.0 / aspect];
        let (a, b) = (axes(), axes());
        let (qa, qb, u) = (random.quaternion(), random.quaternion(), random.direction());
        place_near_touch(
            &mut cases,
            format!("random pair {k}, aspect {aspect:.1}"),
            a,
            qa,
            b,
            qb,
            u,
        );
    }
    judge("first_touch", &cases, 1e-13);
}

/// Puts the second body along `u` so that the bodies just overlap, and so that they are just apart.
fn place_near_touch(
    cases: &mut Vec<Case>,
    name: String,
    a: Vector,
    qa: Quaternion,
    b: Vector,
    qb: Quaternion,
    u: Vector,
) {
    let far = a.into_iter().chain(b).fold(0.0, f64::max);
    let here = perram_wertheim((a, qa, [0.0; 3]), (b, qb, scale(far, u)));
    for change in [-1e-2, -1e-5, -1e-8, 1e-8, 1e-5, 1e-2] {
        // the contact function grows with the square of the distance
        let distance = far * ((1.0 + change) / here).sqrt();
        cases.push(case(
            format!("{name}, {change:e}"),
            a,
            qa,
            b,
            qb,
            scale(distance, u),
            IDENTITY,
        ));
    }
}

/// The centres coincide: the deepest common normal lies along the shortest combined axis, the force is that of its depth.
#[test]
fn both_versions_coincident_centres() {
    let mut cases = vec![];
    let mut random = Random(14);
    let shapes: [Vector; 6] = [
        [1.0, 1.0, 1.0],
        [10.0, 1.0, 1.0],
        [10.0, 10.0, 1.0],
        [3.0, 2.0, 1.0],
        [100.0, 3.0, 1.0],
        [1.0, 1.01, 0.99],
    ];
    for (k, a) in shapes.into_iter().enumerate() {
        for turn in [IDENTITY, random.quaternion()] {
            cases.push(case(
                format!("coincident equal {k}"),
                a,
                IDENTITY,
                a,
                IDENTITY,
                [0.0; 3],
                turn,
            ));
            cases.push(case(
                format!("coincident half turn {k}"),
                a,
                IDENTITY,
                a,
                about([0.0, 0.0, 1.0], std::f64::consts::PI),
                [0.0; 3],
                turn,
            ));
        }
        cases.push(case(
            format!("coincident, other pose {k}"),
            a,
            random.quaternion(),
            a,
            random.quaternion(),
            [0.0; 3],
            IDENTITY,
        ));
        cases.push(case(
            format!("nearly coincident {k}"),
            a,
            IDENTITY,
            a,
            IDENTITY,
            [1e-14, -2e-15, 1e-15],
            IDENTITY,
        ));
    }
    let frames = judge("coincident", &cases, 1e-13);
    for (c, frames) in cases.iter().zip(&frames) {
        let a = c.grains[0].semi_axes;
        let distinct = a[0].min(a[1]) > 1.05 * a[2];
        if !(c.name.starts_with("coincident equal") && distinct) {
            continue;
        }
        let q = c.grains[0].quaternion;
        let n = rotate(q, [0.0, 0.0, 1.0]);
        let modulus = 1e7 / (2.0 * (1.0 - 0.09));
        let expected = hertz_stiffness(modulus, (a, q), (a, q), n) * (2.0 * a[2]).powf(1.5);
        let got = frames[1].states[1].force;
        let error = length(sub(got, scale(expected, n))).min(length(add(got, scale(expected, n))))
            / expected;
        println!(
            "{}: force {:.6e}, relative error {error:.1e}",
            c.name,
            length(got)
        );
        assert!(
            error < 1e-6,
            "{}: {got:?} in place of {expected} along {n:?}",
            c.name
        );
    }
}
