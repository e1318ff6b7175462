// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do LAMMPS' styles for a GPU give the trajectories of those for the host, and refuse what they cannot do? Without a GPU: the arrays of
//! KOKKOS are on the host, and the stand-in for NVIDIA's driver runs the kernels (`tests/lammps_on_gpu/plugin`).

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::process;
use crate::harness::{
    attempt, attempt_in, between_walls, crowd, last_lines, run, Deck, Engine, Frame, Outcome,
    Scene, State,
};
use crate::mesh_walls::in_mesh;

const LAW: &str = "nfd 1e7 0.3 200 300 tangential tfd 0.5";

/// Of each of the runs of a deck.
const STEPS: u64 = 120;

/// Of the largest number of a kind in a frame: positions, velocities, angular momenta, quaternions, forces, torques. The kernels add the
/// forces of a grain in another order than lists of the host, which is rounding, 1e-16 of the largest; collisions multiply it.
/// What an adapter does wrong, a velocity of an earlier step or an image without one, is above 1e-6.
const BOUND: f64 = 1e-10;

fn path_from(variable: &str) -> PathBuf {
    process::from_environment(
        variable,
        "these tests drive a LAMMPS with KOKKOS; run them with `cargo xtask test --filter kokkos`",
    )
}

fn with_the_stand_in() -> Engine {
    Engine {
        lammps: path_from("ELLGRAN_TEST_LAMMPS_KOKKOS"),
        words: vec!["-nocite", "-k", "on", "t", "1", "-sf", "kk"],
        plugin: path_from("ELLGRAN_TEST_LAMMPS_GPU_PLUGIN"),
        ..Engine::from_environment()
    }
}

/// Grains that collide under friction and gravity in a periodic box. LAMMPS sorts them now and then.
fn deck(motion: &str) -> Deck {
    Deck {
        newton: false,
        before_data: vec!["atom_modify sort 50 0.0".into()],
        time_step: 1e-5,
        dump_every: STEPS / 2,
        thermo_every: STEPS / 2,
        thermo_columns: "step ke".into(),
        skin: 2e-3,
        integrate: false,
        fixes: vec![
            format!("fix move all nve/ellipsoid {motion}"),
            "fix gravity all gravity 9.81 vector 0.2 0 -1".into(),
        ],
        ..Deck::new(LAW)
    }
}

/// One that goes on without set-up, and one with another time step.
fn three_runs() -> Vec<String> {
    vec![
        format!("run {STEPS}"),
        format!("run {STEPS} pre no"),
        "timestep 0.8e-5".into(),
        format!("run {STEPS}"),
    ]
}

/// The numbers of a kind, of all grains.
type Kind = (&'static str, fn(&State) -> Vec<f64>);
const KINDS: [Kind; 6] = [
    ("positions", |s| s.position.to_vec()),
    ("velocities", |s| s.velocity.to_vec()),
    ("angular momenta", |s| s.angular_momentum.to_vec()),
    ("quaternions", |s| s.quaternion.to_vec()),
    ("forces", |s| s.force.to_vec()),
    ("torques", |s| s.torque.to_vec()),
];

/// The largest difference of the numbers of a kind, over the largest of them.
fn apart(kind: &Kind, a: &Frame, b: &Frame) -> f64 {
    assert_eq!((a.step, a.states.len()), (b.step, b.states.len()));
    let numbers = |frame: &Frame| frame.states.iter().flat_map(kind.1).collect::<Vec<_>>();
    let (a, b) = (numbers(a), numbers(b));
    assert!(a.iter().chain(&b).all(|x| x.is_finite()), "{}", kind.0);
    let largest = b.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(largest > 0.0, "all {} are 0", kind.0);
    let differences = a.iter().zip(&b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, f64::max) / largest
}

/// A test in which little touches, or with one neighbour list, sees little.
fn require_action(outcome: &Outcome) {
    let builds: f64 = outcome
        .output
        .lines()
        .filter_map(|line| line.strip_prefix("Neighbor list builds = "))
        .map(|number| number.trim().parse::<f64>().unwrap())
        .sum();
    let states = &outcome.last().states;
    let pushed = states.iter().filter(|s| s.torque.iter().any(|x| *x != 0.0));
    let touching = pushed.count();
    println!(
        "{touching} of {} grains touch, {builds} neighbour lists",
        states.len()
    );
    assert!(8 * touching > states.len(), "{touching}");
    assert!(builds >= 3.0, "{builds}");
}

/// These styles, not those of KOKKOS for the host.
fn require_the_gpu(outcome: &Outcome) {
    for words in ["kokkos_device", "pair gran/ellipsoid/kk, perpetual"] {
        assert!(
            outcome.output.contains(words),
            "{}",
            last_lines(&outcome.output)
        );
    }
}

/// Frame by frame, and number by number of the columns of the thermo output.
fn require_same(name: &str, host: &Outcome, gpu: &Outcome) {
    assert_eq!(host.frames.len(), gpu.frames.len());
    let mut far = vec![];
    let mut compared = |what: &str, most: f64| {
        println!("{name}: {what} differ by {most:.1e}");
        if most.is_nan() || most >= BOUND {
            far.push(format!("{what} by {most:.1e}"));
        }
    };
    for kind in &KINDS {
        let frames = host.frames.iter().zip(&gpu.frames);
        let most = frames.map(|(a, b)| apart(kind, b, a)).fold(0.0, f64::max);
        compared(kind.0, most);
    }
    let (rows, others) = (host.thermo(), gpu.thermo());
    assert!(!rows.is_empty() && rows.len() == others.len());
    for column in rows[0].keys() {
        let scale = rows.iter().map(|r| r[column].abs()).fold(1e-30, f64::max);
        let both = rows.iter().zip(&others);
        let most = both.map(|(a, b)| (a[column] - b[column]).abs() / scale);
        compared(column, most.fold(0.0, f64::max));
    }
    assert!(far.is_empty(), "{name}: {}", far.join(", "));
}

fn same_trajectories(name: &str, scene: &Scene, deck: &Deck) {
    same_on_ranks(name, scene, deck, 1);
}

fn same_on_ranks(name: &str, scene: &Scene, deck: &Deck, ranks: usize) {
    same_with_files(name, &[], scene, deck, ranks);
}

/// The same with files in the directory of each run.
fn same_with_files(
    name: &str,
    files: &[(&str, Vec<u8>)],
    scene: &Scene,
    deck: &Deck,
    ranks: usize,
) {
    let on = |engine: &Engine, name: &str, ranks: usize| {
        in_mesh(engine, name, files, scene, deck, ranks)
    };
    let host = on(&Engine::from_environment(), &format!("host_{name}"), 1);
    let gpu = on(&with_the_stand_in(), &format!("gpu_{name}"), ranks);
    require_the_gpu(&gpu);
    assert!(
        gpu.output
            .contains("images have the velocities of their grains on the GPU"),
        "{}",
        last_lines(&gpu.output)
    );
    require_action(&host);
    require_same(name, &host, &gpu);
}

/// Over neighbour lists, a sort, a run without set-up and another time step; across periodic boundaries.
#[test]
fn the_trajectories_of_a_periodic_box_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        same_trajectories(&motion.replace(' ', "_"), &crowd(216), &deck);
    }
}

/// Planes that wiggle, slide and stand.
#[test]
fn the_trajectories_between_moving_planes_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let mut deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        deck.fixes.extend([
            format!("fix x all wall/gran/ellipsoid {LAW} xplane 0.0 0.096 shear y 0.5"),
            format!("fix low all wall/gran/ellipsoid {LAW} zplane 0.0 NULL wiggle z 1e-3 0.002"),
            "fix high all wall/gran/ellipsoid nfd 2e7 0.3 80 80 tangential tfd 0.3 zplane NULL 0.096".to_string(),
        ]);
        same_trajectories(&motion.replace(' ', "_"), &between_walls(), &deck);
    }
}

/// Of each part of the tests of what is kept from run to run.
const LONG: u64 = 1000;

fn long(motion: &str) -> Deck {
    Deck {
        dump_every: LONG / 4,
        thermo_every: LONG / 4,
        ..deck(motion)
    }
}

/// LAMMPS gives all others new IDs, and puts the last atom in the place of one that it deletes.
#[test]
fn contacts_go_on_where_atoms_are_deleted_between_runs() {
    for compress in ["yes", "no"] {
        let runs = vec![
            format!("run {LONG}"),
            "group gone id 3 17 40 41 90 215".into(),
            format!("delete_atoms group gone compress {compress}"),
            format!("run {LONG}"),
        ];
        let deck = Deck {
            runs,
            ..long("velocities step")
        };
        same_trajectories(&format!("deleted_{compress}"), &crowd(216), &deck);
    }
}

/// What contacts remember goes with grains that pass from rank to rank, as with the next run, and with other laws of the same length.
#[test]
fn the_trajectories_on_two_ranks_are_those_of_one_on_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let deck = Deck {
            thermo_columns: "step ke pe pxx pxy".into(),
            runs: vec![
                format!("run {LONG}"),
                "balance 1.0 shift x 5 1.0".into(),
                "pair_coeff * * nfd 1.2e7 0.3 200 300 tangential tfd 0.4".into(),
                format!("run {LONG}"),
                format!("run {} pre no", LONG / 2),
            ],
            ..long(motion)
        };
        let name = format!("ranks_{}", motion.replace(' ', "_"));
        same_on_ranks(&name, &crowd(216), &deck, 2);
    }
}

/// As LAMMPS sends them where MPI reads the memory of the host alone.
#[test]
fn the_trajectories_with_messages_by_way_of_the_host_are_the_same() {
    for motion in ["velocities step", "velocities half"] {
        let scene = crowd(216);
        let deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        let on = |engine: &Engine, name: &str, ranks: usize| {
            let name = format!("{name}_{}", motion.replace(' ', "_"));
            run(engine, &name, &scene, &deck, ranks)
        };
        let host = on(&Engine::from_environment(), "host_messages", 1);
        let mut engine = with_the_stand_in();
        engine
            .words
            .extend(["-pk", "kokkos", "comm/pair/forward", "no"]);
        let gpu = on(&engine, "gpu_messages", 2);
        require_the_gpu(&gpu);
        require_action(&host);
        require_same(motion, &host, &gpu);
    }
}

/// All grains are on one of two ranks.
#[test]
fn a_rank_may_have_no_grains() {
    let mut scene = crowd(27);
    scene.high[0] *= 4.0;
    let deck = Deck {
        thermo_columns: "step ke pe press".into(),
        runs: vec![format!("run {STEPS}"), format!("run {STEPS}")],
        ..deck("velocities step")
    };
    let host = run(
        &Engine::from_environment(),
        "host_empty_rank",
        &scene,
        &deck,
        1,
    );
    let gpu = run(&with_the_stand_in(), "gpu_empty_rank", &scene, &deck, 2);
    require_the_gpu(&gpu);
    require_same("empty_rank", &host, &gpu);
}

/// The GPU sums them up; by atom the host computes them, of what the GPU has.
#[test]
fn energies_and_stresses_are_those_of_the_host() {
    let sums = "step ke pe press pxx pyy pzz pxy pxz pyz";
    let of_all = Deck {
        thermo_columns: sums.into(),
        runs: three_runs(),
        ..deck("velocities step")
    };
    same_trajectories("sums", &crowd(216), &of_all);
    same_on_ranks("sums_on_ranks", &crowd(216), &of_all, 2);
    let mut deck = Deck {
        thermo_columns: format!("{sums} c_energy c_stress"),
        ..of_all
    };
    deck.fixes.extend([
        "compute energies all pe/atom".to_string(),
        "compute stresses all stress/atom NULL".to_string(),
        "compute energy all reduce sumsq c_energies".to_string(),
        "compute stress all reduce sumsq c_stresses[4]".to_string(),
    ]);
    same_trajectories("energies", &crowd(216), &deck);
}

/// A run to the middle, or a file that is written while it goes on, and a run from that file; of an engine and a number of ranks each.
fn through_a_file(
    name: &str,
    (scene, long): (&Scene, &Deck),
    [first, second]: [(&Engine, usize); 2],
) -> Outcome {
    let to_the_middle = Deck {
        runs: vec![
            format!("restart {} middle.restart other.restart", LONG - 10),
            format!("run {LONG}"),
            "group gone id 7".into(),
            "delete_atoms group gone compress no".into(),
            "write_restart end.restart".into(),
        ],
        ..long.clone()
    };
    let outcome = run(first.0, name, scene, &to_the_middle, first.1);
    // A file from a run on a GPU has 'comm_modify vel no'.
    let from = |file: &str| {
        vec![
            format!("read_restart {file}.restart"),
            "comm_modify vel yes".into(),
        ]
    };
    let from_the_end = Deck {
        pair: vec![],
        source: from("end"),
        runs: vec![format!("run {LONG}"), format!("run {LONG}")],
        ..long.clone()
    };
    let go_on =
        |directory, deck: &Deck| attempt_in(second.0, directory, scene, deck, second.1).succeeded();
    let mut outcome = go_on(outcome.directory, &from_the_end);
    let from_the_middle = Deck {
        source: from("middle"),
        runs: vec![format!("run {}", LONG / 2)],
        dump_every: LONG / 4 - 10,
        ..from_the_end
    };
    let middle = go_on(outcome.directory.clone(), &from_the_middle);
    outcome.frames.extend(middle.frames);
    outcome
}

/// With and without a GPU on either side, and other numbers of ranks.
fn goes_on_from_files(name: &str, scene: &Scene, long: &Deck) {
    let (host, gpu) = (Engine::from_environment(), with_the_stand_in());
    let reference = through_a_file(name, (scene, long), [(&host, 1), (&host, 1)]);
    require_action(&reference);
    for (way, sides) in [
        ("both", [(&gpu, 1), (&gpu, 1)]),
        ("to_gpu", [(&host, 1), (&gpu, 1)]),
        ("from_gpu", [(&gpu, 1), (&host, 1)]),
        ("ranks", [(&gpu, 2), (&gpu, 1)]),
        ("more_ranks", [(&host, 1), (&gpu, 2)]),
    ] {
        let name = format!("{name}_{way}");
        let outcome = through_a_file(&name, (scene, long), sides);
        require_same(&name, &reference, &outcome);
    }
}

#[test]
fn restart_files_go_on_with_and_without_a_gpu() {
    for motion in ["velocities step", "velocities half"] {
        let name = format!("file_{}", &motion[11..]);
        goes_on_from_files(&name, &crowd(216), &long(motion));
    }
}

/// A scene with friction at two planes that slide, one that wiggles, and a drum that turns, of which a grain may touch two.
fn among_walls() -> (Scene, Deck) {
    let mut deck = long("velocities step");
    // Forces on the planes and the walls, their torques, powers and motions.
    let of_x = "f_x[1] f_x[2] f_x[4] f_x[14] f_x[17] f_x[20]";
    let of_drum = "f_drum[1] f_drum[14] f_drum[16] f_drum[18] f_drum[20]";
    let of_low = "f_low[3] f_low[16] f_low[17] f_low[20] f_low[23] f_low[26]";
    deck.thermo_columns = format!("step ke {of_x} {of_drum} {of_low}");
    deck.fixes.extend([
        format!("fix x all wall/gran/ellipsoid {LAW} xplane 0.0 0.096 shear y 0.5"),
        format!("fix low all wall/gran/ellipsoid {LAW} zplane 0.0 NULL wiggle z 1e-3 0.004"),
        "fix drum all wall/gran/ellipsoid nfd 2e7 0.3 80 80 tangential tfd 0.3 displacement rescaled shape cylinder \
             point 0.048 0.048 0.048 axis 0 1 0 radius 0.063 bounds -0.048 0.048 ends closed closed side inside \
             omega 0.048 0.048 0.048 0 1 0 20"
            .to_string(),
    ]);
    let mut scene = between_walls();
    scene.boundary = "f f f".into();
    scene.low[1] -= 0.03;
    scene.high[1] += 0.03;
    (scene, deck)
}

/// Also that the walls are where they were, and as far in their motion.
#[test]
fn restart_files_have_what_walls_remember() {
    let (scene, deck) = among_walls();
    goes_on_from_files("file_walls", &scene, &deck);
}

/// Where atoms are deleted, go to other ranks, and where there are other laws and other walls in a later run.
#[test]
fn what_walls_remember_goes_with_the_grains() {
    let (scene, deck) = among_walls();
    // On two ranks LAMMPS gives other new IDs than on one.
    for (ranks, compress) in [(1, "yes"), (2, "no")] {
        let runs = vec![
            format!("run {}", LONG / 2),
            "group gone id 3 17 40".into(),
            format!("delete_atoms group gone compress {compress}"),
            "pair_coeff * * nfd 1.2e7 0.3 200 300 tangential tfd 0.4".into(),
            format!("run {}", LONG / 2),
            format!("fix high all wall/gran/ellipsoid {LAW} zplane NULL 0.096"),
            "balance 1.0 shift z 5 1.0".into(),
            format!("run {}", LONG / 2),
            "unfix x".into(),
            format!("fix x all wall/gran/ellipsoid {LAW} xplane -0.001 0.097"),
            format!("run {}", LONG / 2),
            format!("run {} pre no", LONG / 4),
        ];
        let deck = Deck {
            runs,
            ..deck.clone()
        };
        same_on_ranks(&format!("walls_{ranks}"), &scene, &deck, ranks);
    }
}

/// One that no atom of a restart file belongs to gets some before the first step.
#[test]
fn a_rank_may_get_its_first_grains_after_a_restart() {
    let mut scene = crowd(64);
    scene.high[0] *= 4.0;
    let mut deck = long("velocities step");
    deck.fixes.push(format!(
        "fix low all wall/gran/ellipsoid {LAW} zplane 0.0 0.096"
    ));
    scene.boundary = "p p f".into();
    let file = Deck {
        runs: vec![format!("run {LONG}"), "write_restart end.restart".into()],
        ..deck.clone()
    };
    let (host, gpu) = (Engine::from_environment(), with_the_stand_in());
    let go_on = |engine: &Engine, name: &str, ranks: usize| {
        let outcome = run(&host, name, &scene, &file, 1);
        let from_the_file = Deck {
            pair: vec![],
            source: vec![
                "read_restart end.restart".into(),
                "comm_modify vel yes".into(),
                "balance 1.0 shift x 10 1.0".into(),
            ],
            runs: vec![format!("run {LONG}")],
            ..deck.clone()
        };
        attempt_in(engine, outcome.directory, &scene, &from_the_file, ranks).succeeded()
    };
    let reference = go_on(&host, "first_grains_host", 1);
    let outcome = go_on(&gpu, "first_grains_gpu", 2);
    require_same("first_grains", &reference, &outcome);
}

/// LAMMPS computes no forces when such a run starts, and its images hear of nothing before the next neighbour list.
#[test]
fn what_set_has_changed_counts_in_a_run_without_set_up() {
    for command in [
        "set group some density 3500",
        "set group some shape 0.02 0.016 0.016",
    ] {
        let runs = |more: &str| {
            vec![
                format!("run {STEPS}"),
                "group some id 5:100".into(),
                command.into(),
                more.into(),
                format!("run {STEPS} pre no"),
            ]
        };
        let deck = Deck {
            runs: runs(""),
            ..deck("velocities step")
        };
        let name = command.split(' ').nth(3).unwrap();
        same_trajectories(&format!("set_{name}"), &crowd(216), &deck);
        // With a new list in each step.
        let with_lists = Deck {
            runs: runs("neigh_modify check no"),
            ..deck.clone()
        };
        let engine = Engine::from_environment();
        let old_list = run(&engine, &format!("old_list_{name}"), &crowd(216), &deck, 1);
        let new_lists = run(
            &engine,
            &format!("new_lists_{name}"),
            &crowd(216),
            &with_lists,
            1,
        );
        require_same(&format!("lists_{name}"), &new_lists, &old_list);
    }
}

/// LAMMPS puts grains back into the box for these, and has other images then: how many there are may be as before.
#[test]
fn a_run_without_set_up_is_refused_after_a_file_was_written() {
    for (engine, ranks) in [
        (Engine::from_environment(), 1),
        (with_the_stand_in(), 1),
        (with_the_stand_in(), 2),
    ] {
        for command in ["write_restart file", "write_data file"] {
            let mut deck = deck("velocities step");
            deck.runs = vec!["run 2".into(), command.into(), "run 2 pre no".into()];
            let outcome = attempt(&engine, "written", &crowd(64), &deck, ranks);
            let refused = !outcome.success && outcome.output.contains("leave out 'pre no'");
            assert!(refused, "{ranks}: {}", last_lines(&outcome.output));
        }
    }
}

/// Commands and settings that the page says are right on the GPU.
#[test]
fn other_commands_give_what_they_give_on_the_host() {
    let kinds = ["group a id 1:60", "group b id 61:140"];
    for (name, commands, between) in [
        (
            "exclude",
            vec![kinds[0], kinds[1], "neigh_modify exclude group a b"],
            vec![],
        ),
        (
            "asphere",
            vec!["unfix move", kinds[0], "fix move a nve/asphere"],
            vec![],
        ),
        (
            "viscous",
            vec![
                "fix drag all viscous 0.01",
                "fix push all addforce 0.001 0 0",
            ],
            vec![],
        ),
        ("hold", vec![kinds[0], "fix hold a setforce 0 0 0"], vec![]),
        (
            "triclinic",
            vec![
                "box tilt large",
                "change_box all triclinic",
                "change_box all xy final 0.02 yz final -0.01 remap",
            ],
            vec![],
        ),
        (
            "change_box",
            vec![],
            vec!["change_box all x scale 1.05 remap"],
        ),
        (
            "displace",
            vec![],
            vec!["displace_atoms all move 0.003 0.1 0.2"],
        ),
        ("velocity", vec![], vec!["velocity all zero linear"]),
        (
            "refix",
            vec![],
            vec!["unfix move", "fix move all nve/ellipsoid velocities half"],
        ),
    ] {
        let mut deck = deck("velocities step");
        deck.fixes.extend(commands.into_iter().map(String::from));
        deck.runs = vec![format!("run {STEPS}")];
        deck.runs.extend(between.into_iter().map(String::from));
        deck.runs.push(format!("run {STEPS}"));
        same_trajectories(name, &crowd(216), &deck);
    }
}

/// Cylinders, cones, spheres and regions of them, that turn, move and stand, with their ends; a plane that turns.
#[test]
fn the_trajectories_in_curved_walls_are_those_of_the_host() {
    for motion in ["velocities step", "velocities half"] {
        let mut deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        let wall =
            |name: &str, words: &str| format!("fix {name} all wall/gran/ellipsoid {LAW} {words}");
        deck.fixes.extend([
            wall(
                "drum",
                "shape cylinder point 0.048 0.048 0.048 axis 0 1 0 radius 0.063 bounds -0.048 0.048 ends closed closed side inside \
                 omega 0.048 0.048 0.048 0 1 0 20",
            ),
            wall(
                "ball",
                "shape sphere point 0.036 0.036 -0.021 radius 0.022 side outside velocity 0 0 1",
            ),
            wall(
                "cone",
                "shape cone point -0.03 0.036 0.036 axis 1 0 0 radii 0.02 0 bounds 0 0.038 ends closed closed side outside",
            ),
            format!(
                "region hull sphere 0.048 0.048 0.048 0.074\n{}",
                wall("hull", "region hull wiggle z 1e-3 0.002")
            ),
            wall("floor", "zplane 0.0 NULL omega 0.048 0.048 0 0 0 1 -20"),
        ]);
        let mut scene = between_walls();
        scene.boundary = "f f f".into();
        scene.low[1] -= 0.03;
        scene.high[1] += 0.03;
        same_trajectories(&motion.replace(' ', "_"), &scene, &deck);
    }
}

/// Files of the examples: a drum with lifters that turns about its axis, a paddle that turns in it; and the outer sides of a block that
/// wiggles.
#[test]
fn the_trajectories_in_meshes_are_those_of_the_host() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/lammps");
    let files =
        ["lifters.stl", "paddle.stl"].map(|name| (name, fs::read(examples.join(name)).unwrap()));
    for motion in ["velocities step", "velocities half"] {
        let mut deck = Deck {
            runs: three_runs(),
            ..deck(motion)
        };
        let wall =
            |name: &str, words: &str| format!("fix {name} all wall/gran/ellipsoid {LAW} {words}");
        deck.fixes.extend([
            wall(
                "drum",
                "mesh lifters.stl scale 0.0024 move 0.048 0.048 0.048 rotate 0.048 0.048 0.048 1 0 0 0.1",
            ),
            wall(
                "paddle",
                "mesh paddle.stl scale 0.0015 move 0.048 0.048 0.048 rotate 0.048 0.048 0.048 0 0 1 0.02",
            ),
            format!(
                "region block block 0.03 0.066 0.03 0.066 -0.02 0.004 side out\n{}",
                wall("block", "region block wiggle z 1e-3 0.002")
            ),
            // At rest, cut by the drum.
            wall("still", "mesh paddle.stl scale 0.004 move 0.048 0.03 0.02"),
        ]);
        let mut scene = between_walls();
        scene.boundary = "f f f".into();
        scene.low[1] -= 0.03;
        scene.high[1] += 0.03;
        same_with_files(&format!("mesh_{}", &motion[11..]), &files, &scene, &deck, 1);
    }
}

/// What docs/kokkos.md lists as refused, each with a word of the message.
#[test]
fn what_is_not_on_the_gpu_is_refused() {
    let engine = with_the_stand_in();
    let wrong = RefCell::new(vec![]);
    let refused_on = |ranks: usize, name: &str, deck: Deck, message: &str| {
        let scene = if name.starts_with("wall") {
            between_walls()
        } else {
            crowd(64)
        };
        let outcome = attempt(&engine, name, &scene, &deck, ranks);
        if outcome.success || !outcome.output.contains(message) {
            let said = last_lines(&outcome.output);
            wrong
                .borrow_mut()
                .push(format!("{name}, in place of '{message}':\n{said}"));
        }
    };
    let refused = |name: &str, deck: Deck, message: &str| refused_on(1, name, deck, message);
    let plain = || deck("velocities step");
    let with = |command: &str| {
        let mut deck = plain();
        deck.fixes.push(command.into());
        deck
    };
    let after_a_run = |commands: &[&str]| {
        let mut deck = plain();
        deck.runs = vec!["run 1".into()];
        deck.runs.extend(commands.iter().map(|&c| c.into()));
        deck
    };
    let wall = |words: &str| with(&format!("fix w all wall/gran/ellipsoid {LAW} {words}"));

    let pour = "region top block 0 0.096 0 0.096 0.05 0.096\n\
                fix pour all pour/ellipsoid 60 1 99 region top shape one 0.004 0.003 0.002 dens 2500 2500";
    refused("pour", with(pour), "fix pour/ellipsoid is not on the GPU");
    refused_on(
        2,
        "tiled",
        after_a_run(&["comm_style tiled", "balance 1.0 rcb", "run 1"]),
        "comm_style tiled with several ranks is not on the GPU",
    );
    let mut other_masses = after_a_run(&["set atom 5*60 density 3000", "run 1 pre no"]);
    other_masses.runs[0] = "run 5".into();
    refused_on(2, "set_ranks", other_masses, "leave out 'pre no'");

    refused(
        "wall_servo",
        wall("zplane -0.01 NULL servo 0 0 1 1.0 0.1"),
        "'servo' is not on the GPU",
    );
    let mut energy = with(&format!(
        "fix w all wall/gran/ellipsoid {LAW} zplane -0.01 NULL"
    ));
    energy.thermo_columns = "step f_w[3] f_w[7]".into();
    refused(
        "wall_energy",
        energy,
        "f_w[7], an energy or a count, is not on the GPU",
    );
    let turning =
        format!("fix w all wall/gran/ellipsoid {LAW} zplane -0.01 0.11 omega 0 0 0 0 0 1 1");
    let mut one_of_two = with(&turning);
    one_of_two.thermo_columns = "step f_w[16] f_w[3]".into();
    refused(
        "wall_of_two",
        one_of_two,
        "f_w[3], the force on one of two planes that turn",
    );
    refused(
        "wall_contacts",
        wall("zplane -0.01 NULL contacts"),
        "'contacts' is not on the GPU",
    );

    for style in [
        "contact/ellipsoid/atom",
        "energy/ellipsoid",
        "timestep/ellipsoid",
    ] {
        let message = format!("compute {style} is not on the GPU");
        refused(
            &style.replace('/', "_"),
            with(&format!("compute c all {style}")),
            &message,
        );
    }
    refused(
        "pair_local",
        with("compute c all pair/local eng\ndump c all local 1 c c_c"),
        "Pair style does not support compute pair/local",
    );
    for (name, law, message) in [
        (
            "rolling",
            format!("{LAW} rolling sds 2e3 0.1 0.3"),
            "rolling",
        ),
        (
            "twisting",
            format!("{LAW} twisting sds 2e3 0.1 0.3"),
            "twisting",
        ),
    ] {
        let mut deck = plain();
        deck.pair[1] = format!("pair_coeff * * {law}");
        refused(name, deck, message);
    }

    let motion = "prescribed motion of grains and changes of the box are not on the GPU";
    refused("move", with("fix m all move linear 0 0 0"), motion);
    refused("deform", with("fix d all deform 1 x erate 1.0"), motion);
    let mut group = plain();
    group.before_data.push("suffix kk".into());
    group.fixes[0] = "group some id 1:10\nfix move some nve/ellipsoid".into();
    refused("group", group, "its group must be 'all'");
    let mut without_suffix = plain();
    without_suffix.fixes[0] = "suffix off\nfix move all nve/ellipsoid\nsuffix on".into();
    refused(
        "no_suffix",
        without_suffix,
        "fix nve/ellipsoid without the suffix is not on the GPU",
    );

    refused(
        "rerun",
        after_a_run(&[
            "dump states all custom 1 states id type x y z",
            "run 1",
            "undump states",
            "rerun states dump x y z",
        ]),
        "'rerun' is not on the GPU",
    );
    refused(
        "other_images",
        after_a_run(&["group some id 1", "delete_atoms group some", "run 1 pre no"]),
        "leave out 'pre no'",
    );

    let mut narrow = plain();
    narrow.skin = 0.02;
    refused("narrow", narrow, "twice the cutoff of the neighbour list");

    let wrong = wrong.into_inner();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
