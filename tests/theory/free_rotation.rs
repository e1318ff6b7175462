// SPDX-License-Identifier: MIT OR Apache-2.0
//! Free rotation against Jacobi's closed form (Landau and Lifshitz, Mechanics, section 37), its invariants over many steps, and
//! what a step is for bodies of revolution and spheres.

use ellgran::motion::{finish_step, start_step, Bodies, BodyArrays, Extrapolation, Selection};
use ellgran::simd::InstructionSet;

const ALL: Selection<'static> = Selection {
    groups: &[],
    bits: 0,
};

/// Bodies on which nothing acts.
#[derive(Clone)]
struct Free {
    semi_axes: Vec<[f64; 3]>,
    quaternions: Vec<[f64; 4]>,
    momenta: Vec<[f64; 3]>,
    masses: Vec<f64>,
}

impl Bodies for &mut Free {
    fn shape(&self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        Some((self.semi_axes[k], self.quaternions[k]))
    }
    fn turn(&mut self, k: usize, quaternion: [f64; 4]) {
        self.quaternions[k] = quaternion;
    }
}

impl Free {
    fn steps(&mut self, set: InstructionSet, count: usize, time_step: f64) {
        let n = self.masses.len();
        let (mut positions, mut velocities) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        let still = vec![[0.0; 3]; n];
        let mut momenta = self.momenta.clone();
        let masses = self.masses.clone();
        let mut arrays = BodyArrays {
            positions: &mut positions,
            velocities: &mut velocities,
            angular_momenta: &mut momenta,
            forces: &still,
            torques: &still,
            masses: &masses,
            bodies: self,
            extrapolation: None,
        };
        for _ in 0..count {
            start_step(set, &mut arrays, ALL, time_step).unwrap();
            finish_step(set, &mut arrays, ALL, time_step);
        }
    }

    /// Angular velocity in body axes, energy.
    fn state(&self, k: usize) -> ([f64; 3], f64) {
        let body = to_body(self.quaternions[k], self.momenta[k]);
        let i = moments(self.semi_axes[k], self.masses[k]);
        let w = [body[0] / i[0], body[1] / i[1], body[2] / i[2]];
        let energy = (0..3).map(|axis| 0.5 * body[axis] * w[axis]).sum();
        (w, energy)
    }
}

fn moments([a, b, c]: [f64; 3], mass: f64) -> [f64; 3] {
    [b * b + c * c, a * a + c * c, a * a + b * b].map(|sum| 0.2 * mass * sum)
}

fn rotate([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let t = [
        2.0 * (y * v[2] - z * v[1]),
        2.0 * (z * v[0] - x * v[2]),
        2.0 * (x * v[1] - y * v[0]),
    ];
    [
        v[0] + w * t[0] + y * t[2] - z * t[1],
        v[1] + w * t[1] + z * t[0] - x * t[2],
        v[2] + w * t[2] + x * t[1] - y * t[0],
    ]
}

fn to_body([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    rotate([w, -x, -y, -z], v)
}

/// `sn`, `cn`, `dn` of `u` and the square of the modulus, by the arithmetic-geometric mean (Abramowitz and Stegun 16.4).
fn jacobi(u: f64, m: f64) -> (f64, f64, f64) {
    let (mut a, mut b, mut ratios) = (1.0f64, (1.0 - m).sqrt(), Vec::new());
    while (a - b).abs() > 1e-16 * a {
        ratios.push(0.5 * (a - b) / (0.5 * (a + b)));
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        if ratios.len() > 40 {
            break;
        }
    }
    let mut phase = a * u * (1u64 << ratios.len()) as f64;
    for ratio in ratios.iter().rev() {
        phase = 0.5 * (phase + (ratio * phase.sin()).asin());
    }
    (
        phase.sin(),
        phase.cos(),
        (1.0 - m * phase.sin().powi(2)).sqrt(),
    )
}

/// Angular velocity in body axes at a time, for `I_x < I_y < I_z`, where it is `(x, 0, z)` at time 0 and the motion goes round
/// the axis of the greatest moment.
fn closed_form(i: [f64; 3], x: f64, z: f64, time: f64) -> [f64; 3] {
    let energy = i[0] * x * x + i[2] * z * z;
    let square = (i[0] * x).powi(2) + (i[2] * z).powi(2);
    let (low, high) = (square - energy * i[0], energy * i[2] - square);
    assert!(square > energy * i[1], "another branch of the closed form");
    let rate = ((i[2] - i[1]) * low / (i[0] * i[1] * i[2])).sqrt();
    let m = (i[1] - i[0]) * high / ((i[2] - i[1]) * low);
    let (sn, cn, dn) = jacobi(rate * time, m);
    [
        (high / (i[0] * (i[2] - i[0]))).sqrt() * cn,
        (high / (i[1] * (i[2] - i[1]))).sqrt() * sn,
        (low / (i[2] * (i[2] - i[0]))).sqrt() * dn,
    ]
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / length)
}

/// Triaxial bodies whose angular velocity at the start is `(x, 0, z)` in body axes.
fn triaxial(velocities: &[(f64, f64)]) -> Free {
    let mut free = Free {
        semi_axes: vec![],
        quaternions: vec![],
        momenta: vec![],
        masses: vec![],
    };
    for (k, &(x, z)) in velocities.iter().enumerate() {
        let (a, mass) = ([1.7 + 0.1 * k as f64, 1.1, 0.6], 2.0 + k as f64);
        let q = unit([0.3, -0.5, 0.2 + 0.1 * k as f64, 0.7]);
        let i = moments(a, mass);
        free.semi_axes.push(a);
        free.quaternions.push(q);
        free.momenta.push(rotate(q, [i[0] * x, 0.0, i[2] * z]));
        free.masses.push(mass);
    }
    free
}

fn available() -> Vec<InstructionSet> {
    InstructionSet::ALL
        .into_iter()
        .filter(|set| set.is_available())
        .collect()
}

#[test]
fn triaxial_bodies_follow_jacobi() {
    let starts = [(0.3, 1.0), (0.8, 0.9), (1.3, 1.4), (0.01, 2.0), (1.0, 1.3)];
    for set in available() {
        // Through every way of a step: in lanes, in parts, and in one large turn.
        for (time_step, count) in [(1e-3, 20_000), (0.02, 1000), (0.5, 40)] {
            let mut free = triaxial(&starts);
            free.steps(set, count, time_step);
            for (k, &(x, z)) in starts.iter().enumerate() {
                let i = moments(free.semi_axes[k], free.masses[k]);
                let exact = closed_form(i, x, z, time_step * count as f64);
                let (w, _) = free.state(k);
                for axis in 0..3 {
                    let error = (w[axis] - exact[axis]).abs();
                    assert!(
                        error < 2e-12,
                        "{} body {k} axis {axis}, step {time_step}: {} for {}",
                        set.name(),
                        w[axis],
                        exact[axis]
                    );
                }
            }
        }
    }
}

#[test]
fn the_attitude_is_that_of_much_smaller_steps() {
    let starts = [(0.3, 1.0), (0.8, 0.9), (1.5, 1.4)];
    let mut fine = triaxial(&starts);
    fine.steps(InstructionSet::Scalar, 16_384, 2.0f64.powi(-13));
    for set in available() {
        for (count, time_step) in [
            (2, 1.0),
            (4, 0.5),
            (64, 2.0f64.powi(-5)),
            (1024, 2.0f64.powi(-9)),
        ] {
            let mut coarse = triaxial(&starts);
            coarse.steps(set, count, time_step);
            for k in 0..starts.len() {
                for c in 0..4 {
                    let error = (coarse.quaternions[k][c] - fine.quaternions[k][c]).abs();
                    assert!(
                        error < 1e-13,
                        "{} body {k}, {count} steps: {error:e}",
                        set.name()
                    );
                }
            }
        }
    }
}

#[test]
fn the_axis_in_the_middle_is_unstable_as_it_should_be() {
    // Nearly about the y axis: on the separatrix but for a small part.
    for set in available() {
        let mut free = triaxial(&[(0.0, 1.0)]);
        let i = moments(free.semi_axes[0], free.masses[0]);
        // L^2 = 2 E I_y (1 + 1e-6)
        let ratio = {
            let excess = 1.0 + 1e-6;
            ((i[2] * (i[2] - excess * i[1])) / (i[0] * (excess * i[1] - i[0]))).sqrt()
        };
        free.momenta[0] = rotate(free.quaternions[0], [i[0] * ratio, 0.0, i[2]]);
        let mut time = 0.0;
        let (mut smallest, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..60 {
            free.steps(set, 500, 2e-3);
            time += 1.0;
            let exact = closed_form(i, ratio, 1.0, time);
            let (w, _) = free.state(0);
            for axis in 0..3 {
                // What rounding began has grown with the instability.
                let error = (w[axis] - exact[axis]).abs();
                assert!(
                    error < 1e-8,
                    "{} at {time}: {w:?} for {exact:?}",
                    set.name()
                );
            }
            smallest = smallest.min(w[1]);
            largest = largest.max(w[1]);
        }
        assert!(
            smallest < -0.9 * largest && largest > 0.0,
            "it has not tumbled"
        );
    }
}

/// Relative change of the energy of four bodies.
fn changes_of_energy(set: InstructionSet, steps: usize) -> Vec<f64> {
    let mut free = triaxial(&[(0.3, 1.0), (0.8, 0.9), (1.5, 1.4), (1.0, 0.2)]);
    let before: Vec<f64> = (0..4).map(|k| free.state(k).1).collect();
    free.steps(set, steps, 4e-3);
    let change = |(k, before): (usize, &f64)| (free.state(k).1 / before - 1.0).abs();
    before.iter().enumerate().map(change).collect()
}

#[test]
fn energy_has_no_drift() {
    for set in available() {
        let changes = changes_of_energy(set, 400_000);
        println!("{}: {changes:?}", set.name());
        assert!(changes.iter().all(|c| *c < 2e-13), "{changes:?}");
    }
}

/// Errors of one sign, 1e-19 a step, have made 1.1e-12 of it.
#[test]
#[ignore = "twenty seconds; `cargo xtask test` runs it"]
fn energy_has_no_drift_in_ten_million_steps() {
    let sets = available();
    let set = sets[sets.len() - 1];
    let changes = changes_of_energy(set, 10_000_000);
    println!("{}: {changes:?}", set.name());
    assert!(changes.iter().all(|c| *c < 1e-12), "{changes:?}");
}

#[test]
fn a_step_backwards_undoes_a_step() {
    const STEPS: usize = 3000;
    // Each step rounds a component of a unit quaternion, by half of the last place; they add up at most. What is left differs
    // from machine to machine: below 2e-13 on x86-64, 2.3e-13 on AArch64, whose sums of products are fused.
    let rounding = (2 * STEPS) as f64 * 0.5 * f64::EPSILON;
    for set in available() {
        let start = triaxial(&[(0.3, 1.0), (0.8, 0.9), (1.5, 1.4), (1.0, 0.2), (2.0, 2.0)]);
        let mut free = start.clone();
        free.steps(set, STEPS, 3e-3);
        for l in &mut free.momenta {
            *l = l.map(|x| -x);
        }
        free.steps(set, STEPS, 3e-3);
        for (q, before) in free.quaternions.iter().zip(&start.quaternions) {
            for c in 0..4 {
                assert!(
                    (q[c] - before[c]).abs() < rounding,
                    "{}: {q:?} {before:?}",
                    set.name()
                );
            }
        }
    }
}

#[test]
fn bodies_of_revolution_precess_and_spheres_turn() {
    for set in available() {
        for (a, polar) in [
            ([2.0, 1.0, 1.0], 0),
            ([1.0, 3.0, 1.0], 1),
            ([1.0, 1.0, 0.3], 2),
            ([1.0, 1.0, 1.0], 2),
        ] {
            let mass = 2.5;
            let i = moments(a, mass);
            let q = unit([0.3, -0.5, 0.2, 0.7]);
            let own = [0.3, -0.2, 0.9];
            let momentum = rotate(q, [i[0] * own[0], i[1] * own[1], i[2] * own[2]]);
            let mut free = Free {
                semi_axes: vec![a; 3],
                quaternions: vec![q; 3],
                momenta: vec![momentum; 3],
                masses: vec![mass; 3],
            };
            let (time_step, count) = (0.01, 777);
            let time = time_step * count as f64;
            free.steps(set, count, time_step);
            // In body axes the equatorial components turn with (1 - I_p/I_e) w_p.
            let e = (polar + 1) % 3;
            let f = (polar + 2) % 3;
            let angle = (1.0 - i[polar] / i[e]) * own[polar] * time;
            let (w, _) = free.state(2);
            let exact_e = own[e] * angle.cos() + own[f] * angle.sin();
            let exact_f = own[f] * angle.cos() - own[e] * angle.sin();
            for (axis, exact) in [(polar, own[polar]), (e, exact_e), (f, exact_f)] {
                assert!(
                    (w[axis] - exact).abs() < 1e-12,
                    "{} {a:?} {axis}",
                    set.name()
                );
            }
            // One large step is the same.
            let mut once = free.clone();
            once.quaternions = vec![q; 3];
            once.steps(set, 1, 2.0);
            let mut many = free.clone();
            many.quaternions = vec![q; 3];
            many.steps(set, 500, 4e-3);
            for c in 0..4 {
                let error = (once.quaternions[1][c] - many.quaternions[1][c]).abs();
                assert!(error < 1e-13, "{} {a:?}: {error:e}", set.name());
            }
        }
    }
}

#[test]
fn what_cannot_be_moved_is_refused() {
    for set in available() {
        for (change, said) in [
            (
                (|f: &mut Free| f.momenta[3] = [0.0, 0.0, 1e6]) as fn(&mut Free),
                "half a circle",
            ),
            (|f| f.momenta[3] = [0.0, f64::NAN, 0.0], "half a circle"),
            (|f| f.quaternions[3] = [0.0; 4], "length 0"),
            (|f| f.quaternions[3] = [f64::NAN; 4], "length"),
        ] {
            let mut free = triaxial(&[(0.3, 1.0); 20]);
            change(&mut free);
            let n = free.masses.len();
            let (mut x, mut v) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
            let still = vec![[0.0; 3]; n];
            let mut momenta = free.momenta.clone();
            let masses = free.masses.clone();
            let mut arrays = BodyArrays {
                positions: &mut x,
                velocities: &mut v,
                angular_momenta: &mut momenta,
                forces: &still,
                torques: &still,
                masses: &masses,
                bodies: &mut free,
                extrapolation: None,
            };
            let error = start_step(set, &mut arrays, ALL, 1e-3).unwrap_err();
            assert_eq!(error.body, 3, "{}", set.name());
            assert!(error.what.contains(said), "{}: {}", set.name(), error.what);
        }
    }
}

/// What velocities and angular momenta get by the extrapolation, where these loads follow on those.
fn extrapolated(set: InstructionSet, before: f64, now: f64) -> Vec<[f64; 6]> {
    let n = 11;
    let mut free = Free {
        semi_axes: vec![[1.0, 0.8, 0.6]; n],
        quaternions: vec![[1.0, 0.0, 0.0, 0.0]; n],
        momenta: vec![[0.0; 3]; n],
        masses: vec![1.0; n],
    };
    let direction = [0.6, -0.3, 0.2];
    let loads = vec![direction.map(|d| now * d); n];
    let [x, y, z] = direction.map(|d| before * d);
    let (mut changes, mut loads_before) = (vec![[0.0; 6]; n], vec![[x, y, z, x, y, z]; n]);
    let (mut positions, mut velocities) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    let mut momenta = free.momenta.clone();
    let masses = free.masses.clone();
    let mut arrays = BodyArrays {
        positions: &mut positions,
        velocities: &mut velocities,
        angular_momenta: &mut momenta,
        forces: &loads,
        torques: &loads,
        masses: &masses,
        bodies: &mut free,
        extrapolation: Some(Extrapolation {
            changes: &mut changes,
            loads_before: &mut loads_before,
            step_ratio: 1.0,
        }),
    };
    start_step(set, &mut arrays, ALL, 1e-3).unwrap();
    changes
}

/// Extrapolation ends where the acceleration has turned. One that is nothing but rounding, as the torque of a contact of a smooth sphere
/// is, has a sign by chance, which decides nothing.
#[test]
fn rounding_of_a_load_decides_nothing() {
    for set in available() {
        for rounding in [1e-20, 1e-12] {
            for loads in [(rounding, 1.0), (1.0, rounding)] {
                let [one, other] = [1.0, -1.0].map(|sign| {
                    let (before, now) = loads;
                    extrapolated(set, sign * before, now)
                });
                // With the other sign of the load before, that of the change follows it, where it is not from rounding.
                let sign = if loads.0 == 1.0 { -1.0 } else { 1.0 };
                for (a, b) in one.iter().flatten().zip(other.iter().flatten()) {
                    assert!(a.abs() > 1e-5, "{}: {loads:?}: {a}", set.name());
                    assert!(
                        (a - sign * b).abs() < 1e-10 * a.abs(),
                        "{}: {loads:?}: {a}, {b}",
                        set.name()
                    );
                }
            }
        }
        for before in [-1e-6, -1.0, -1e6] {
            let changes = extrapolated(set, before, 1.0);
            assert!(
                changes.iter().flatten().all(|change| *change == 0.0),
                "{}: {before}",
                set.name()
            );
        }
    }
}
