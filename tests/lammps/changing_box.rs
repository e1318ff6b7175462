// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do contacts feel the displacement with which a changing box carries the grains and their images?
//!
//! LAMMPS tells no velocity for it with `fix deform ... remap x` or `none`, `fix nph/asphere` and `fix press/berendsen`.

use crate::harness::{crowd, run, Deck, Engine, Frame, Grain, Scene};
use crate::shapes::{length, scale, sub, Vector};

const LAW: &str = "nfd 1e7 0.3 200 200 tangential tfd 0.5";
const STEPS: u64 = 200;
const TIME_STEP: f64 = 1e-5;

/// Grains at rest in contact, in a periodic box.
fn at_rest() -> Scene {
    let mut scene = crowd(64);
    for grain in &mut scene.grains {
        grain.position = scale(0.85, grain.position);
        grain.velocity = [0.0; 3];
        grain.angular_momentum = [0.0; 3];
    }
    scene.high = scale(0.85, scene.high);
    scene
}

/// Rates with which the edges of the box change, relative to the edge along the same axis, in the words of `fix deform`.
struct Flow {
    words: &'static str,
    /// Along the diagonal: xx, yy, zz.
    stretch: Vector,
    /// yz, xz, xy: over the edge along the second axis.
    shear: Vector,
}

impl Flow {
    /// Velocity of a point of the box of the start that the flow carries along: constant.
    fn velocity(&self, scene: &Scene, at: Vector) -> Vector {
        let (from_low, from_middle): (Vector, Vector) = (
            sub(at, scene.low),
            std::array::from_fn(|k| at[k] - 0.5 * (scene.low[k] + scene.high[k])),
        );
        let [yz, xz, xy] = self.shear;
        [
            self.stretch[0] * from_middle[0] + xy * from_low[1] + xz * from_low[2],
            self.stretch[1] * from_middle[1] + yz * from_low[2],
            self.stretch[2] * from_middle[2],
        ]
    }
}

const FLOWS: [Flow; 5] = [
    Flow {
        words: "x erate -10",
        stretch: [-10.0, 0.0, 0.0],
        shear: [0.0; 3],
    },
    Flow {
        words: "y erate -5 z erate 5",
        stretch: [0.0, -5.0, 5.0],
        shear: [0.0; 3],
    },
    Flow {
        words: "xy erate 20",
        stretch: [0.0; 3],
        shear: [0.0, 0.0, 20.0],
    },
    // flipped at half of an edge
    Flow {
        words: "xy erate 300 x erate -20",
        stretch: [-20.0, 0.0, 0.0],
        shear: [0.0, 0.0, 300.0],
    },
    Flow {
        words: "yz erate -290 xz erate 20",
        stretch: [0.0; 3],
        shear: [-290.0, 20.0, 0.0],
    },
];

fn deck(steps: u64) -> Deck {
    Deck {
        integrate: false,
        fixes: vec!["fix move all nve/noforce".into()],
        time_step: TIME_STEP,
        skin: 2e-3,
        steps,
        ..Deck::new(LAW)
    }
}

fn largest(frame: &Frame, vector: fn(&crate::harness::State) -> Vector) -> f64 {
    let sizes = frame.states.iter().map(|s| length(vector(s)));
    sizes.fold(0.0, f64::max)
}

fn apart(one: &Frame, other: &Frame, vector: fn(&crate::harness::State) -> Vector) -> f64 {
    let pairs = one.states.iter().zip(&other.states);
    pairs
        .map(|(a, b)| length(sub(vector(a), vector(b))))
        .fold(0.0, f64::max)
}

/// Images in an open box, as many along each axis: what stands in the middle has all its neighbours, whatever the shear.
const COPIES: [i32; 3] = [5, 5, 3];

/// The grains with velocities of their own, in the middle of copies of themselves: no box takes part. The first grains are those
/// that are copied.
fn without_box(scene: &Scene, flow: &Flow) -> Scene {
    let mut grains = vec![];
    let range = |k: usize| -(COPIES[k] / 2)..=COPIES[k] / 2;
    let mut cells: Vec<[i32; 3]> = range(0)
        .flat_map(|x| range(1).flat_map(move |y| range(2).map(move |z| [x, y, z])))
        .collect();
    cells.sort_by_key(|cell| cell.iter().map(|n| n.abs()).sum::<i32>());
    for cell in cells {
        for grain in &scene.grains {
            let mut copy = grain.clone();
            for (k, images) in cell.iter().enumerate() {
                copy.position[k] += f64::from(*images) * (scene.high[k] - scene.low[k]);
            }
            copy.velocity = flow.velocity(scene, copy.position);
            grains.push(copy);
        }
    }
    Scene::open(1.0, grains)
}

/// The same affine motion twice: carried by the box, and by the grains' own velocities.
#[test]
fn both_versions_what_the_box_carries_is_as_good_as_a_velocity() {
    let engine = Engine::from_environment();
    let scene = at_rest();
    for (k, flow) in FLOWS.iter().enumerate() {
        let name = format!("box_none_{k}");
        let own = run(&engine, &name, &without_box(&scene, flow), &deck(STEPS), 1);
        let count = scene.grains.len();
        let own = Frame {
            step: STEPS,
            states: own.last().states[..count].to_vec(),
        };
        for (ranks, newton) in [(1, true), (4, true), (2, false)] {
            // the box carries the grains at the end of a step: forces see it one step later
            let mut carried = deck(STEPS + 1);
            carried.newton = newton;
            carried.fixes.splice(
                0..0,
                [
                    "change_box all triclinic".to_string(),
                    format!("fix box all deform 1 {} remap x", flow.words),
                ],
            );
            let name = format!("box_carries_{k}_{ranks}");
            let carried = run(&engine, &name, &scene, &carried, ranks);
            let carried = carried.last();
            let force = apart(carried, &own, |s| s.force) / largest(&own, |s| s.force);
            let torque = apart(carried, &own, |s| s.torque) / largest(&own, |s| s.torque);
            println!(
                "{}, {ranks} ranks: forces apart by {force:.1e}, torques by {torque:.1e}",
                flow.words
            );
            // displacements of a step have lost so many digits of the positions that they are differences of
            assert!(force < 1e-9 && torque < 1e-9, "{}", flow.words);
        }
    }
}

/// A box that carries the grains on at the end of a step leaves their images where they are until the next one: `compute pair/local` shows the
/// forces that acted all the same.
#[test]
fn both_versions_pair_local_has_the_forces_of_the_step() {
    let engine = Engine::from_environment();
    let scene = at_rest();
    for words in [
        "deform 1 x erate -10 remap x",
        "press/berendsen x 1e9 1e9 0.8 modulus 1e9",
    ] {
        for (ranks, newton) in [(1, true), (2, true), (2, false)] {
            let mut changing = deck(20);
            changing.newton = newton;
            changing.fixes.extend([
                format!("fix box all {words}"),
                "compute ends all property/local patom1 patom2".to_string(),
                "compute forces all pair/local p21 p22 p23".to_string(),
                "dump pairs all local 20 pairs index c_ends[*] c_forces[*]".to_string(),
                "dump_modify pairs format float %.17g".to_string(),
            ]);
            let outcome = run(&engine, "box_pair_local", &scene, &changing, ranks);
            let text = std::fs::read_to_string(outcome.directory.join("pairs")).unwrap();
            let last = text.rsplit("ITEM: TIMESTEP").next().unwrap();
            let mut sums = vec![[0.0f64; 3]; scene.grains.len()];
            for line in last
                .lines()
                .skip_while(|l| !l.starts_with("ITEM: ENTRIES"))
                .skip(1)
            {
                let v: Vec<f64> = line
                    .split_whitespace()
                    .map(|w| w.parse().unwrap())
                    .collect();
                for k in 0..3 {
                    sums[v[1] as usize - 1][k] += v[3 + k];
                    sums[v[2] as usize - 1][k] -= v[3 + k];
                }
            }
            let frame = outcome.last();
            let largest = largest(frame, |s| s.force);
            let apart = frame
                .states
                .iter()
                .zip(&sums)
                .map(|(s, sum)| length(sub(s.force, *sum)))
                .fold(0.0, f64::max);
            println!("{words}, {ranks} ranks: apart by {:.1e}", apart / largest);
            assert!(apart < 1e-9 * largest, "{words}, {ranks} ranks");
        }
    }
}

/// With `newton off` the energies of contacts across the boundaries of a box that moves are wrong, and a warning says so.
#[test]
fn both_versions_energies_that_need_newton_are_warned_of() {
    let engine = Engine::from_environment();
    let scene = at_rest();
    let box_changes = "fix box all press/berendsen x 1e9 1e9 0.8 modulus 1e9";
    let energies = "compute energies all pair gran/ellipsoid";
    for (newton, fixes, warned) in [
        (false, &[box_changes, energies][..], true),
        (true, &[box_changes, energies][..], false),
        (false, &[box_changes][..], false),
        (false, &[energies][..], false),
    ] {
        let mut changing = deck(10);
        changing.newton = newton;
        changing.fixes.extend(fixes.iter().map(|f| f.to_string()));
        let outcome = run(&engine, "box_newton", &scene, &changing, 1);
        let words: Vec<&str> = outcome.output.split_whitespace().collect();
        let says = words
            .join(" ")
            .contains("across its periodic boundaries dissipate are wrong");
        assert_eq!(says, warned, "newton {newton}, {fixes:?}");
    }
}

/// Two spheres in touch within the box, or across its boundary, whose line of centres is oblique to the axis of the change.
fn touching(across: bool) -> Scene {
    let radius = 1e-2;
    let (cosine, sine) = (0.8, 0.6);
    let along = [
        0.995 * 2.0 * radius * cosine,
        0.995 * 2.0 * radius * sine,
        0.0,
    ];
    let first: Vector = if across {
        [0.094, 0.05, 0.05]
    } else {
        [0.04, 0.05, 0.05]
    };
    let mut second: Vector = std::array::from_fn(|k| first[k] + along[k]);
    if across {
        second[0] -= 0.1;
    }
    let grains = [first, second].map(|at| Grain::new([radius; 3], at));
    Scene::periodic([0.0; 3], [0.1; 3], grains.to_vec())
}

/// Friction that never slides and a memory of the displacement itself: it must be what the grains, or one of them and the image of
/// the other, were carried past each other.
#[test]
fn both_versions_the_tangential_displacement_is_that_of_the_box() {
    let engine = Engine::from_environment();
    const MODULUS: f64 = 1e9;
    // what changes the length along x, whether the grains go with it
    let changes = [
        ("fix box all deform 1 x erate -0.5 remap x", "", true),
        ("fix box all deform 1 x erate -0.5 remap none", "", false),
        (
            "fix box all press/berendsen x 1e9 1e9 0.8 modulus 1e9",
            "",
            true,
        ),
        (
            "",
            "nph/asphere x 3e6 3e6 0.1 ptemp 1e26 fixedpoint 0.05 0.05 0.05",
            true,
        ),
    ];
    for (change, integrator, carries) in changes {
        for across in [false, true] {
            let mut deck = Deck::new(&format!(
                "hertz {MODULUS:e} 0.3 tangential mindlin 1e6 displacement total"
            ));
            deck.integrate = false;
            deck.fixes = if integrator.is_empty() {
                vec!["fix move all nve/noforce".into(), change.into()]
            } else {
                // the barostat moves the box, and nothing else moves
                vec![
                    format!("fix move all {integrator}"),
                    "fix still all freeze".into(),
                ]
            };
            deck.fixes.extend([
                "compute slip all pair/local p20".into(),
                "compute slips all reduce sum c_slip inputs local".into(),
            ]);
            deck.thermo_columns = "step lx c_slips".into();
            deck.thermo_every = 400;
            (deck.time_step, deck.steps, deck.skin) = (TIME_STEP, 400, 5e-3);
            let outcome = run(&engine, "box_slip", &touching(across), &deck, 1);
            let rows = outcome.thermo();
            let (first, last) = (&rows[0], &rows[rows.len() - 1]);
            let (before, now) = (first["Lx"], last["Lx"]);
            let way = if carries {
                0.995 * 2e-2 * 0.8 * (now / before - 1.0)
            } else if across {
                now - before
            } else {
                0.0
            };
            let expected = (0.6 * way).abs();
            let found = last["c_slips"];
            println!(
                "{change}{integrator}, across {across}: box by {:.1e}, {found:.4e} m, expected {expected:.4e}",
                now / before - 1.0
            );
            assert!((now / before - 1.0).abs() > 1e-4, "the box stays");
            // the line of centres turns by as much as the box changes
            let allowed = 10.0 * (now / before - 1.0).abs() * expected + 1e-12;
            assert!((found - expected).abs() < allowed, "{change}{integrator}");
        }
    }
}

/// With `timestep 0` the box changes and no time passes: forces are those in the changed box, and no velocity is found.
#[test]
fn both_versions_a_box_that_changes_in_no_time_has_no_velocity() {
    let engine = Engine::from_environment();
    let scene = at_rest();
    for (ranks, newton) in [(1, true), (2, false)] {
        let forces = |name: &str, commands: &[&str], motion: &str| {
            let mut deck = deck(11);
            deck.newton = newton;
            deck.time_step = 0.0;
            deck.fixes = vec![format!("fix move all {motion}")];
            deck.runs = commands.iter().map(|c| c.to_string()).collect();
            let outcome = run(&engine, name, &scene, &deck, ranks);
            outcome.last().clone()
        };
        for (remap, motion) in [
            ("x", "nve/noforce"),
            ("none", "nve/noforce"),
            ("x", "nve/ellipsoid"),
            ("x", "move linear 1 0 0"),
        ] {
            let deformed = [
                &format!("fix box all deform 1 x scale 0.99 remap {remap}"),
                "run 10",
                "unfix box",
                "run 1",
            ];
            let changed = match remap {
                "x" => "change_box all x scale 0.99 remap",
                _ => "change_box all x scale 0.99",
            };
            let deformed = forces("box_no_time", &deformed, motion);
            let own = forces("box_changed", &[changed, "run 11"], motion);
            let largest = largest(&own, |s| s.force);
            let force = apart(&deformed, &own, |s| s.force) / largest;
            println!("remap {remap}, {motion}, {ranks} ranks: forces apart by {force:.1e}");
            assert!(largest > 0.0 && force < 1e-9, "{remap}, {motion}");
        }
    }
}

/// `fix deform` moves grains and images at the end of a step: `compute contact/ellipsoid/atom` takes the lever arms that the forces had. Both
/// sums are over the same contacts; only the order in which they are added differs.
#[test]
fn both_versions_grain_stresses_are_those_before_the_box_was_changed() {
    let engine = Engine::from_environment();
    let scene = at_rest();
    for remap in ["x", "none"] {
        for (ranks, newton) in [(1, true), (1, false), (2, true)] {
            let deck = Deck {
                newton,
                time_step: TIME_STEP,
                steps: STEPS,
                thermo_every: STEPS / 2,
                fixes: vec![
                    format!("fix flow all deform {} x erate -10 remap {remap}", STEPS / 2),
                    "compute stress all stress/atom NULL pair".into(),
                    "compute grains all contact/ellipsoid/atom".into(),
                    "compute sum all reduce sum c_stress[1] c_stress[2] c_stress[3] c_grains[9] c_grains[10] c_grains[11]".into(),
                ],
                thermo_columns: "step c_sum[*]".into(),
                ..Deck::new(LAW)
            };
            let outcome = run(&engine, "grain_stress", &scene, &deck, ranks);
            let mut worst = 0.0f64;
            for row in outcome.thermo() {
                let of = |first: usize| [0, 1, 2].map(|k| row[&format!("c_sum[{}]", first + k)]);
                worst = worst.max(length(sub(of(1), of(4))) / length(of(1)));
            }
            println!("remap {remap}, {ranks} ranks, newton {newton}: off by {worst:.1e}");
            assert!(worst < 1e-10, "{worst:.1e}");
        }
    }
}
