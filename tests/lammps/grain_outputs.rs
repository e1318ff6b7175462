// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordination, fabric and stress of each grain, and what the walls add to the virial: against the contacts one by one, and against
//! what must hold at rest.

use crate::decomposition::LAW;
use crate::harness::{attempt, between_walls, last_rows, run, Deck, Engine};
use crate::shapes::{sub, Vector};

const COLUMNS: usize = 14;

/// `xx yy zz xy xz yz` of the symmetric part of `a (x) b`.
fn product(a: Vector, b: Vector) -> [f64; 6] {
    [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].map(|[k, l]| 0.5 * (a[k] * b[l] + a[l] * b[k]))
}

fn vector(row: &[f64]) -> Vector {
    [row[0], row[1], row[2]]
}

/// Adds a contact to the row of a grain at `centre`; `walls` says which count.
fn add(row: &mut [f64; COLUMNS], at_wall: bool, arm: Vector, normal: Vector, force: Vector) {
    row[at_wall as usize] += 1.0;
    let terms = [product(normal, normal), product(arm, force)].concat();
    for (sum, term) in row[2..].iter_mut().zip(terms) {
        *sum += term;
    }
}

/// The walls of these tests, across x and z; grains repeat along y.
fn walls(words: &str) -> Vec<String> {
    vec![
        format!("fix sides all wall/gran/ellipsoid {LAW} xplane 0.0 0.096 {words}"),
        format!("fix floor all wall/gran/ellipsoid {LAW} zplane 0.0 NULL {words}"),
        format!("fix round all wall/gran/ellipsoid {LAW} shape cylinder point 0.048 0 0.048 axis 0 1 0 radius 0.06 side inside {words}"),
    ]
}

/// Each grain has what the contacts of `compute pair/local` and the lists of the walls add up to, on any ranks, across the boundary too;
/// a grain outside the group has nothing.
#[test]
fn both_versions_grain_sums_are_those_of_the_contacts_one_by_one() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    let period = scene.high[1] - scene.low[1];
    for (ranks, newton, steps) in [
        (1, true, 0),
        (1, true, 300),
        (1, false, 300),
        (4, true, 300),
        (4, false, 300),
    ] {
        let mut fixes = walls("contacts");
        let virial = ["sides", "floor", "round"].map(|id| format!("fix_modify {id} virial yes"));
        fixes.extend(virial);
        fixes.extend([
            "compute pressing all pressure NULL pair fix".into(),
            "compute stress all stress/atom NULL pair fix".into(),
            "compute sum all reduce sum c_stress[*]".into(),
            "group some id <= 40".into(),
            "compute grains all contact/ellipsoid/atom".into(),
            "compute chosen some contact/ellipsoid/atom".into(),
            "compute ends all property/local patom1 patom2".into(),
            "compute contact all pair/local p12 p6 p7 p8 p9 p10 p11 p21 p22 p23".into(),
        ]);
        let every = steps.max(1);
        let wall_columns = |id: &str| {
            let columns = [1, 3, 4, 5, 6, 7, 8, 14, 15, 16].map(|k| format!("f_{id}[{k}]"));
            format!(
                "dump {id} all local {every} {id} index {}",
                columns.join(" ")
            )
        };
        fixes.extend([
            format!("dump grains all custom {every} grains id x y z c_grains[*] c_chosen[*]"),
            format!("dump pairs all local {every} pairs index c_ends[1] c_ends[2] c_contact[*]"),
            wall_columns("sides"),
            wall_columns("floor"),
            wall_columns("round"),
        ]);
        for dump in ["grains", "pairs", "sides", "floor", "round"] {
            fixes.push(format!("dump_modify {dump} format float %.17g"));
        }
        let deck = Deck {
            newton,
            steps,
            fixes,
            time_step: 1e-5,
            skin: 2e-3,
            thermo_columns:
                "step vol c_pressing[1] c_pressing[2] c_pressing[3] c_sum[1] c_sum[2] c_sum[3]"
                    .into(),
            ..Deck::new(LAW)
        };
        let outcome = run(&engine, "grain_sums", &scene, &deck, ranks);
        let rows = |name: &str| last_rows(&outcome.directory.join(name));
        let grains = rows("grains");
        let mut expected = vec![[0.0; COLUMNS]; grains.len()];
        let mut places = vec![[0.0; 3]; grains.len()];
        for row in &grains {
            places[row[0] as usize - 1] = vector(&row[1..]);
        }
        let arm = |grain: usize, point: Vector| {
            let mut arm = sub(point, places[grain]);
            arm[1] -= period * (arm[1] / period).round();
            arm
        };
        let (mut pairs, mut at_walls) = (0, 0);
        for row in rows("pairs").iter().filter(|row| row[3] > 0.0) {
            let (i, j) = (row[1] as usize - 1, row[2] as usize - 1);
            let (point, normal, force) = (vector(&row[4..]), vector(&row[7..]), vector(&row[10..]));
            add(&mut expected[i], false, arm(i, point), normal, force);
            let on_second = force.map(|f| -f);
            add(&mut expected[j], false, arm(j, point), normal, on_second);
            pairs += 1;
        }
        for row in ["sides", "floor", "round"].map(rows).concat() {
            let i = row[1] as usize - 1;
            let (point, normal, force) = (vector(&row[2..]), vector(&row[5..]), vector(&row[8..]));
            add(&mut expected[i], true, arm(i, point), normal, force);
            at_walls += 1;
        }
        let largest: Vec<f64> = (0..COLUMNS)
            .map(|k| expected.iter().fold(0.0, |m: f64, row| m.max(row[k].abs())))
            .collect();
        // Contacts of `compute pair/local` are computed once more, the lanes add in another order.
        let mut worst = 0.0f64;
        for row in &grains {
            let grain = row[0] as usize;
            let (found, chosen) = (&row[4..4 + COLUMNS], &row[4 + COLUMNS..]);
            for k in 0..COLUMNS {
                let error = (found[k] - expected[grain - 1][k]).abs() / largest[k];
                worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
                let of_group = if grain <= 40 { found[k] } else { 0.0 };
                assert_eq!(chosen[k], of_group, "grain {grain}, column {k}");
            }
        }
        println!(
            "{ranks} ranks, newton {newton}, {steps} steps: {pairs} pairs, {at_walls} contacts with walls, off by {worst:.1e}"
        );
        assert!(pairs >= 4 && at_walls >= 4);
        assert!(worst < 1e-10);
        // The virial of pairs and walls.
        let thermo = outcome.thermo().pop().unwrap();
        for k in 0..3 {
            let of_grains: f64 = expected.iter().map(|row| row[8 + k]).sum();
            let of_pressure = -thermo[&format!("c_pressing[{}]", k + 1)] * thermo["Volume"];
            let of_stress = thermo[&format!("c_sum[{}]", k + 1)];
            for of_engine in [of_pressure, of_stress] {
                assert!(
                    (of_engine / of_grains - 1.0).abs() < 1e-9,
                    "{of_engine}, {of_grains}"
                );
            }
        }
    }
}

/// Grains pressed by servo walls until they rest: their stresses, with those of the contacts with walls, add up to force times width; so
/// do the virial of pairs and walls, in `compute pressure` and `compute stress/atom`. Without `fix_modify virial yes` the walls are not in it.
#[test]
fn both_versions_the_stress_of_a_packing_at_rest_is_that_of_its_walls() {
    let engine = Engine::from_environment();
    let mut scene = between_walls();
    scene.boundary = "f f f".into();
    scene.low = [-0.03; 3];
    scene.high = [0.126; 3];
    for grain in &mut scene.grains {
        grain.velocity = [0.0; 3];
        grain.angular_momentum = [0.0; 3];
    }
    let forces = [40.0, 60.0, 80.0];
    // Smooth: with friction on the sides the force across would change along the packing.
    let smooth = "nfd 1e8 0.3 2000 3000";
    for (ranks, newton) in [(1, true), (2, false)] {
        let mut fixes = vec![];
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let direction = [0, 1, 2].map(|c| if c == k { "-1" } else { "0" }).join(" ");
            fixes.push(format!(
                "fix low_{axis} all wall/gran/ellipsoid {smooth} {axis}plane -0.01 NULL"
            ));
            fixes.push(format!(
                "fix high_{axis} all wall/gran/ellipsoid {smooth} {axis}plane NULL 0.106 servo {direction} {} 0.3",
                forces[k]
            ));
            fixes.push(format!(
                "fix_modify low_{axis} virial yes\nfix_modify high_{axis} virial yes"
            ));
        }
        fixes.extend(
            [
                "fix slow all viscous 0.05",
                "compute grains all contact/ellipsoid/atom",
                "compute total all reduce sum c_grains[*]",
                "compute pressing all pressure NULL pair fix",
                "compute of_pairs all pressure NULL pair",
                "compute stress all stress/atom NULL pair fix",
                "compute sum all reduce sum c_stress[*]",
            ]
            .map(String::from),
        );
        let columns = |id: &str, count: usize| {
            (1..=count)
                .map(|k| format!("c_{id}[{k}]"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        let deck = Deck {
            newton,
            time_step: 2e-5,
            skin: 2e-3,
            fixes,
            thermo_every: 25_000,
            thermo_columns: format!(
                "step ke vol f_high_x[21] f_high_y[22] f_high_z[23] f_high_x[27] f_high_y[27] f_high_z[27] {} {} {} {}",
                columns("total", COLUMNS),
                columns("pressing", 6),
                columns("of_pairs", 6),
                columns("sum", 6)
            ),
            steps: 50_000,
            ..Deck::new(LAW)
        };
        let outcome = run(&engine, "stress_at_rest", &scene, &deck, ranks);
        let last = outcome.thermo().pop().unwrap();
        let volume = last["Volume"];
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let force = last[&format!("f_high_{axis}[27]")];
            let width = 0.116 + last[&format!("f_high_{axis}[{}]", 21 + k)];
            let expected = force * width;
            let of_grains = -last[&format!("c_total[{}]", 9 + k)];
            let of_pressure = last[&format!("c_pressing[{}]", k + 1)] * volume;
            let of_stress = -last[&format!("c_sum[{}]", k + 1)];
            let of_pairs = last[&format!("c_of_pairs[{}]", k + 1)] * volume;
            println!(
                "{ranks} ranks, {axis}: {force:.3} N across {width:.4} m: {expected:.5} J; grains {of_grains:.5}, pressure {of_pressure:.5}, \
                 stress/atom {of_stress:.5}, pairs alone {of_pairs:.5}"
            );
            assert!((force / forces[k] - 1.0).abs() < 1e-3, "not at rest");
            // Contacts lie within the overlap with the wall, half of it inside: here 1e-3 of the width; and what still moves.
            assert!((of_grains / expected - 1.0).abs() < 4e-3);
            // The same sums, in another order.
            assert!((of_pressure / of_grains - 1.0).abs() < 1e-9);
            assert!((of_stress / of_grains - 1.0).abs() < 1e-9);
            assert!(of_pairs < 0.9 * of_grains);
        }
        let (contacts, at_walls) = (last["c_total[1]"], last["c_total[2]"]);
        let trace: f64 = (3..6).map(|k| last[&format!("c_total[{k}]")]).sum();
        println!("{contacts} contacts of 64 grains, {at_walls} with walls");
        assert!((trace - contacts - at_walls).abs() < 1e-9 * trace);
        assert!(contacts > 4.0 * 64.0 && at_walls > 30.0);
    }
}

/// Before the walls have their forces there are no contacts to show: a fix that asks when a run is set up must stand behind them.
#[test]
fn both_versions_grain_sums_before_the_walls_have_forces_are_an_error() {
    let engine = Engine::from_environment();
    let sums = "compute grains all contact/ellipsoid/atom\ncompute total all reduce sum c_grains[1] c_grains[2]";
    let early = "fix early all ave/time 1 1 1 c_total[1] c_total[2]";
    for (is_early, fixes) in [
        (true, [vec![sums.into(), early.into()], walls("")].concat()),
        (false, [walls(""), vec![sums.into(), early.into()]].concat()),
    ] {
        let deck = Deck {
            time_step: 1e-5,
            skin: 2e-3,
            steps: 3,
            fixes,
            ..Deck::new(LAW)
        };
        let outcome = attempt(&engine, "grain_sums_early", &between_walls(), &deck, 1);
        let said = outcome
            .output
            .contains("fix sides has not recorded its contacts in step 0");
        assert_eq!(outcome.success, !is_early, "{}", outcome.output);
        assert_eq!(said, is_early, "{}", outcome.output);
    }
}
