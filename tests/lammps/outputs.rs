// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the outputs right: geometry of each contact, stored and dissipated energy, pressure?

use crate::decomposition::LAW;
use crate::golden_pairs::{read_pairs, ASPECT_10, ASPECT_100};
use crate::harness::{attempt_in, crowd, last_rows, run, Deck, Engine, Grain, Scene};
use crate::shapes::{dot, length, scale, sub, Vector};

/// `compute pair/local` and thermo output of golden pairs, through `single()`.
#[test]
fn both_versions_pair_local_energy_and_pressure() {
    let engine = Engine::from_environment();
    let mut worst = [0.0f64; 7];
    let mut count = 0;
    for text in [ASPECT_10, ASPECT_100] {
        for pair in read_pairs(text).into_iter().step_by(10) {
            let (arm, extent) = pair.size();
            let allowed = 1e-8f64.max(16.0 * f64::EPSILON * extent / pair.delta);
            let mut grains = pair.grains.to_vec();
            grains[1].kind = 2;
            let scene = Scene::open(8.0, grains);
            let law = |k: usize| {
                format!(
                    "pair_coeff {0} {0} hertz {1:e} {2:e}",
                    k + 1,
                    pair.materials[k][0],
                    pair.materials[k][1]
                )
            };
            let mut deck =
                Deck::with_pair(vec!["pair_style gran/ellipsoid".into(), law(0), law(1)]);
            deck.fixes = vec![
                "compute first all property/local patom1".into(),
                "compute contact all pair/local dist eng force p1 p6 p7 p8 p9 p10 p11 p12 p13 p14 p21 p22 p23".into(),
                "dump contacts all local 1 contacts index c_first c_contact[*]".into(),
                "dump_modify contacts format float %.17g".into(),
                "compute pressing all pressure NULL pair".into(),
            ];
            deck.thermo_columns = "step pe c_pressing".into();
            let outcome = run(&engine, "pair_local", &scene, &deck, 1);
            let row = &last_rows(&outcome.directory.join("contacts"))[0];
            let sign = if row[1] == 1.0 { 1.0 } else { -1.0 };
            let [_, _, dist, energy, force, p1, cx, cy, cz, nx, ny, nz, delta, a, b, fx, fy, fz] =
                row[..]
            else {
                panic!("{} columns", row.len())
            };
            let vector = |x: f64, y: f64, z: f64| -> Vector { [x, y, z] };
            let d = sub(pair.grains[1].position, pair.grains[0].position);
            let along = length(pair.expected[0][0]);
            let volume = 16.0f64.powi(3);
            let thermo = &outcome.thermo()[0];
            let stored = 0.4 * along * pair.delta;
            let pressure = dot(d, pair.expected[1][0]) / (3.0 * volume);
            let errors = [
                (dist / length(d) - 1.0).abs() / 1e-7,
                length(sub(vector(cx, cy, cz), pair.contact_point)) / arm / allowed,
                length(sub(scale(sign, vector(nx, ny, nz)), pair.normal)) / allowed,
                (delta / pair.delta - 1.0)
                    .abs()
                    .max((a / pair.curvatures[0] - 1.0).abs())
                    .max((b / pair.curvatures[1] - 1.0).abs())
                    / allowed,
                (force / along - 1.0).abs().max((p1 / along - 1.0).abs()) / allowed,
                length(sub(scale(-sign, vector(fx, fy, fz)), pair.expected[1][0]))
                    / along
                    / allowed,
                (energy / stored - 1.0)
                    .abs()
                    .max((thermo["PotEng"] / stored - 1.0).abs())
                    .max((thermo["c_pressing"] / pressure - 1.0).abs())
                    / (4.0 * allowed),
            ];
            for (w, e) in worst.iter_mut().zip(errors) {
                *w = w.max(if e.is_nan() { f64::INFINITY } else { e });
            }
            assert!(
                errors.iter().all(|e| *e < 1.0),
                "case {}: {errors:?} of the allowance",
                pair.case
            );
            count += 1;
        }
    }
    println!(
        "{count} pairs; largest share of the allowance: contact point {:.2}, normal {:.2}, penetration and curvatures {:.2}, normal force {:.2}, force {:.2}, energy and pressure {:.2}",
        worst[1], worst[2], worst[3], worst[4], worst[5], worst[6]
    );
}

/// Kinetic, stored and dissipated energy add up to what was there.
#[test]
fn both_versions_energy_is_kept_stored_or_dissipated() {
    let engine = Engine::from_environment();
    for law in [
        LAW,
        "hertz 1e8 0.3 damping restitution 0.7 tangential mindlin 0.4",
        "lsd 2e5 5 tangential linear 1.5e5 3 0.5",
    ] {
        let departure = |time_step: f64| {
            let steps = (5e-3 / time_step).round() as u64;
            let deck = Deck {
                time_step,
                steps,
                thermo_every: steps / 20,
                thermo_columns:
                    "step pe ke c_turning c_energy[1] c_energy[2] c_energy[3] c_energy[4]".into(),
                fixes: vec![
                    "compute turning all erotate/asphere".into(),
                    "compute energy all pair gran/ellipsoid".into(),
                ],
                skin: 2e-3,
                ..Deck::new(law)
            };
            let outcome = run(&engine, "energy", &crowd(64), &deck, 1);
            let rows = outcome.thermo();
            let total = |k: usize| {
                rows[k]["PotEng"]
                    + rows[k]["KinEng"]
                    + rows[k]["c_turning"]
                    + rows[k]["c_energy[3]"]
            };
            let last = rows.len() - 1;
            assert!(
                rows[last]["c_energy[3]"] > 0.02 * total(0),
                "{law}: nothing is dissipated"
            );
            for row in &rows {
                let parts = row["c_energy[1]"] + row["c_energy[2]"];
                assert!(
                    (row["PotEng"] - parts).abs() <= 1e-12 * parts.abs(),
                    "pe is not the sum of its parts"
                );
            }
            let largest = (0..=last)
                .map(|k| (total(k) / total(0) - 1.0).abs())
                .fold(0.0, f64::max);
            (largest, rows[last]["c_energy[3]"] / total(0))
        };
        let (coarse, fine) = (departure(4e-6), departure(1e-6));
        println!(
            "{law}: {:.1} % dissipated; the sum departs by {:.1e} at 4 us, {:.1e} at 1 us",
            100.0 * fine.1,
            coarse.0,
            fine.0
        );
        assert!(fine.0 < 2e-3 && fine.0 < 0.5 * coarse.0, "{law}");
    }
}

/// `compute pair/local` shows the forces and torques that acted: over all pairs they add up to those on the atoms.
#[test]
fn both_versions_pair_local_shows_the_forces_that_acted() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    for law in [
        LAW,
        "nfd 1e8 0.3 2000 3000 tangential tfd 0.5 displacement rescaled",
        "hertz 1e8 0.3 damping restitution 0.5 tangential mindlin 0.5 displacement incremental",
        "lsd 2e5 5 tangential linear 1.5e5 3 0.5",
        "nfd 1e8 0.3 2000 3000 unloading first_order limit_force no",
    ] {
        let all = [
            (1, true, 0),
            (1, true, 300),
            (4, false, 300),
            (2, true, 300),
            (2, false, 300),
            (4, true, 300),
        ];
        // The first law on all ranks, the others on some.
        let decompositions = if law == LAW { &all[..] } else { &all[..3] };
        // LAMMPS' integrator hands velocities of the half step to the forces, ours those of the step.
        let ours = decompositions[..3].iter().map(|d| ("nve/ellipsoid", d));
        let theirs = decompositions.iter().map(|d| ("nve/asphere", d));
        let mut powers = [vec![], vec![]];
        for (integrator, &(ranks, newton, steps)) in theirs.chain(ours) {
            let deck = Deck {
                integrate: false,
                newton,
                time_step: 1e-5,
                steps,
                skin: 2e-3,
                fixes: vec![
                    format!("fix step all {integrator}"),
                    "compute ends all property/local patom1 patom2".into(),
                    "compute contact all pair/local p21 p22 p23 p24 p25 p26 p27 p28 p29 p32 p33"
                        .into(),
                ],
                runs: vec![
                    format!("run {steps}"),
                    "write_dump all local contacts c_ends[1] c_ends[2] c_contact[*] modify format float %.17g"
                        .into(),
                ],
                ..Deck::new(law)
            };
            let outcome = run(&engine, "local_sums", &scene, &deck, ranks);
            let rows = last_rows(&outcome.directory.join("contacts"));
            let mut sums = vec![[0.0f64; 6]; scene.grains.len()];
            let mut contacts = 0;
            let mut power = [0.0; 2];
            for row in &rows {
                let (i, j) = (row[0] as usize - 1, row[1] as usize - 1);
                contacts += (row[2] != 0.0) as usize;
                for k in 0..3 {
                    sums[i][k] += row[2 + k];
                    sums[j][k] -= row[2 + k];
                    sums[i][3 + k] += row[5 + k];
                    sums[j][3 + k] += row[8 + k];
                }
                assert!(row[11] >= 0.0, "{law}: a viscous force that gives energy");
                power[0] += row[11];
                power[1] += row[12];
            }
            let states = &outcome.last().states;
            let scale = |of: fn(&crate::harness::State) -> Vector| {
                states.iter().map(|s| length(of(s))).fold(0.0, f64::max)
            };
            let scales = [scale(|s| s.force), scale(|s| s.torque)];
            let error = sums
                .iter()
                .zip(states)
                .flat_map(|(sum, s)| {
                    [
                        length(sub([sum[0], sum[1], sum[2]], s.force)) / scales[0],
                        length(sub([sum[3], sum[4], sum[5]], s.torque)) / scales[1],
                    ]
                })
                .fold(0.0, f64::max);
            println!("{law}, {integrator}: {ranks} ranks, newton {newton}, {steps} steps: {contacts} contacts, off by {error:.1e}");
            assert!(steps == 0 || contacts >= 3);
            assert!(error < 1e-11, "{law}: {ranks} ranks, newton {newton}");
            if steps > 0 {
                powers[(integrator == "nve/ellipsoid") as usize].push(power);
            }
        }
        for powers in powers {
            let size = powers[0][0].abs() + powers[0][1].abs();
            assert!(size > 0.0, "{law}");
            for power in &powers {
                for k in 0..2 {
                    assert!((power[k] - powers[0][k]).abs() < 1e-6 * size, "{law}");
                }
            }
        }
    }
}

/// A dump has all that frictionless spheres are; what contacts remember is not in it, those with walls neither.
#[test]
fn both_versions_a_rerun_shows_the_forces_of_the_run_or_is_refused() {
    let engine = Engine::from_environment();
    let grains = (0..6).map(|k| {
        let place = [0.9 * f64::from(k % 2), 1.1 * f64::from(k / 2), 0.48];
        Grain::sphere(0.5, place).moving([0.3, -0.2, -0.5])
    });
    let mut scene = Scene::open(10.0, grains.collect());
    scene.boundary = "f f f".into();
    let deck = |wall: &str, runs: &[&str]| Deck {
        time_step: 1e-4,
        steps: 50,
        dump_every: 10,
        fixes: vec![format!(
            "fix floor all wall/gran/ellipsoid {wall} zplane 0 NULL"
        )],
        runs: runs.iter().map(|r| r.to_string()).collect(),
        ..Deck::new("hertz 1e7 0.3")
    };
    let plain = "hertz 1e7 0.3";
    let friction = "hertz 1e7 0.3 tangential mindlin 0.5";
    let first = [
        "dump a all custom 10 all.dump id x y z vx vy vz",
        "dump_modify a format float %.17g first yes",
        "run 50",
    ];
    for (wall, words) in [(plain, None), (friction, Some("'rerun' cannot be used"))] {
        let run = run(&engine, "rerun_spheres", &scene, &deck(wall, &first), 1);
        let again = deck(wall, &["rerun all.dump dump x y z vx vy vz"]);
        let outcome = attempt_in(&engine, run.directory.clone(), &scene, &again, 1);
        if let Some(words) = words {
            assert!(!outcome.success && outcome.output.contains(words), "{wall}");
            continue;
        }
        let outcome = outcome.succeeded();
        assert_eq!((outcome.frames.len(), run.frames.len()), (6, 6));
        for (one, other) in run.frames.iter().zip(&outcome.frames) {
            assert_eq!(one.step, other.step);
            let largest = one
                .states
                .iter()
                .flat_map(|s| s.force)
                .fold(0.0, |a: f64, f| a.max(f.abs()));
            assert!(largest > 1.0);
            for (a, b) in one.states.iter().zip(&other.states) {
                for k in 0..3 {
                    assert!(
                        (a.force[k] - b.force[k]).abs() < 1e-9 * largest,
                        "step {}",
                        one.step
                    );
                }
            }
        }
    }
}
