// SPDX-License-Identifier: MIT OR Apache-2.0
//! With `fix nve/ellipsoid`: do forces see velocities of the step at which they are computed, and does a run that is split or
//! restarted go on as one that is not, under viscous laws too?

use crate::harness::{
    attempt_in, between_walls, largest_difference, last_lines, run, Deck, Engine, Grain, Outcome,
    Scene,
};

const HALF: u64 = 120;

/// Every normal law and damping, every tangential law and form of its displacement, what resists rolling and twisting, and the keywords.
const LAWS: [&str; 23] = [
    "nfd 1e8 0.3 2e3 2e3",
    VISCOUS,
    "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5 displacement total",
    "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5 displacement incremental",
    "nfd 1e8 0.3 2e3 3e3 closure surface unloading first_order tangential mindlin 0.5 displacement total",
    "nfd 1e8 0.3 2e3 3e3 closure brilliantov limit_force yes tangential tfd 0.5",
    "nfd 1e8 0.3 2e3 2e3 unloading first_order limit_force yes",
    "nfd 1e8 0.3 2e3 2e3 unloading ting limit_force yes conservative no",
    "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5 factors hale conservative no",
    "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5 rolling sds 1e5 0.1 0.1 twisting marshall",
    "hertz 1e8 0.3",
    "hertz 1e8 0.3 tangential tfd 0.5",
    "hertz 1e8 0.3 tangential mindlin 0.5 displacement incremental conservative no",
    "hertz 1e8 0.3 damping relaxation 1e-5 tangential tfd 0.5",
    "hertz 1e8 0.3 damping relaxation 1e-5 unloading first_order limit_force yes tangential mindlin 0.5",
    "hertz 1e8 0.3 damping restitution 0.6 tangential mindlin 0.5",
    "hertz 1e8 0.3 damping restitution 0.6 limit_force yes tangential tfd 0.5 displacement incremental",
    "hertz 1e8 0.3 damping restitution 0.6 tangential mindlin 0.5 rolling sds 1e5 0.1 0.1 twisting sds 1 1e-4 1e-3",
    "hertz 1e8 0.3 tangential mindlin 0.5 displacement total twisting marshall",
    "lsd 2e4 3",
    "lsd 2e4 3 tangential linear 1.6e4 2 0.5",
    "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5 displacement hysteretic rolling sds 1e5 0.1 0.1 twisting lubkin",
    "lsd 2e4 3 limit_force yes tangential linear 1.6e4 2 0.5 rolling sds 1e4 0.1 0.1 twisting marshall",
];

const VISCOUS: &str = "nfd 1e8 0.3 2e3 2e3 tangential tfd 0.5";

fn deck(law: &str) -> Deck {
    Deck {
        time_step: 1e-5,
        steps: HALF,
        skin: 2e-3,
        integrate: false,
        // One wall before the integrator and one behind: when a run starts both compute their forces anew.
        fixes: vec![
            format!("fix left all wall/gran/ellipsoid {law} xplane -3e-3 0.099"),
            "fix move all nve/ellipsoid".into(),
            format!("fix floor all wall/gran/ellipsoid {law} zplane -3e-3 0.099"),
        ],
        ..Deck::new(law)
    }
}

fn apart(what: &str, a: &Outcome, b: &Outcome) -> f64 {
    assert_eq!(a.last().step, b.last().step);
    let (positions, velocities) = largest_difference(a.last(), b.last());
    println!("{what}: positions {positions:.1e}, velocities {velocities:.1e}");
    positions.max(velocities)
}

/// A run on one rank, one that is split on four, and restarts from one rank to four and from four to one are the same.
fn goes_on(engine: &Engine, name: &str, scene: &Scene, deck: &Deck) {
    let half = deck.steps;
    let whole = Deck {
        steps: 2 * half,
        ..deck.clone()
    };
    let whole = run(engine, "step_velocities_whole", scene, &whole, 1);
    let mut outcomes = vec![];
    for ranks in [[1, 4], [4, 1]] {
        let mut first = deck.clone();
        first.runs = vec![format!("run {half}"), "write_restart middle.restart".into()];
        let first = run(engine, "step_velocities_first", scene, &first, ranks[0]);
        let felt = |s: &&crate::harness::State| s.force != [0.0; 3];
        let touching = first.last().states.iter().filter(felt).count();
        assert!(touching >= 6, "{name}: only {touching} grains touch");
        let second = Deck {
            pair: vec![],
            source: vec!["read_restart middle.restart".into()],
            ..deck.clone()
        };
        let restarted = attempt_in(engine, first.directory, scene, &second, ranks[1]);
        assert!(restarted.success, "{}", last_lines(&restarted.output));
        outcomes.push((format!("restarted on {ranks:?} ranks"), restarted));
    }
    for ranks in [1, 4] {
        let mut two = deck.clone();
        two.runs = vec![
            format!("run {}", half - 30),
            "run 0".into(),
            "run 30".into(),
            format!("run {half} every 70 NULL"),
        ];
        let two = run(engine, "step_velocities_split", scene, &two, ranks);
        outcomes.push((format!("split on {ranks} ranks"), two));
    }
    for (what, outcome) in outcomes {
        let gap = apart(&format!("{name}, {what}"), &outcome, &whole);
        assert!(gap < 1e-12, "{name}, {what}: {gap:e}");
    }
}

#[test]
fn both_versions_split_and_restarted_runs_go_on_under_every_law() {
    let engine = Engine::from_environment();
    for law in LAWS {
        goes_on(&engine, law, &between_walls(), &deck(law));
    }
}

/// Two kinds of grains whose pairs are mixed, beside walls with a material of their own.
#[test]
fn both_versions_split_and_restarted_runs_of_two_materials_go_on() {
    let engine = Engine::from_environment();
    let mut scene = between_walls();
    scene.kinds = 2;
    for (k, grain) in scene.grains.iter_mut().enumerate() {
        grain.kind = 1 + k % 2;
    }
    for laws in [
        [VISCOUS, "nfd 3e8 0.2 4e3 1e3 tangential tfd 0.2"],
        [
            "hertz 1e8 0.3 damping restitution 0.6 tangential mindlin 0.5 rolling sds 1e5 0.1 0.1",
            "hertz 3e8 0.2 damping restitution 0.9 tangential mindlin 0.2 rolling sds 3e5 0 0.05",
        ],
    ] {
        let mut deck = deck(laws[0]);
        deck.pair = vec![
            "pair_style gran/ellipsoid".into(),
            format!("pair_coeff 1 1 {}", laws[0]),
            format!("pair_coeff 2 2 {}", laws[1]),
        ];
        deck.fixes[0] = deck.fixes[0].replace("xplane", "material rigid xplane");
        goes_on(&engine, &format!("{laws:?}"), &scene, &deck);
    }
}

/// Two grains of a scene without contacts in a viscous medium, LAMMPS' own: the velocity after a time, less the exact one.
#[test]
fn both_versions_other_forces_see_velocities_of_the_step_too() {
    let engine = Engine::from_environment();
    let grain = |x: f64| Grain::new([0.3, 0.2, 0.2], [x, 0.0, 0.0]).moving([0.0, 1.0, -2.0]);
    let scene = Scene::open(8.0, vec![grain(-3.0), grain(3.0)]);
    let rate = 0.7;
    let drag = rate * scene.grains[0].mass();
    let error = |velocities: &str, steps: u64| {
        let deck = Deck {
            integrate: false,
            fixes: vec![
                format!("fix drag all viscous {drag:e}"),
                format!("fix move all nve/ellipsoid velocities {velocities}"),
            ],
            time_step: 1.0 / steps as f64,
            steps,
            ..Deck::new("hertz 1e7 0.3")
        };
        let name = format!("drag_{velocities}_{steps}");
        let outcome = run(&engine, &name, &scene, &deck, 1);
        let exact = -2.0 * f64::exp(-rate);
        (outcome.last().states[0].velocity[2] - exact).abs()
    };
    for (velocities, order) in [("half", 1.0), ("step", 2.0)] {
        let [coarse, fine] = [50, 200].map(|steps| error(velocities, steps));
        let found = (coarse / fine).ln() / 4f64.ln();
        println!("velocities {velocities}: {coarse:.1e} in 50 steps, {fine:.1e} in 200, order {found:.2}");
        assert!((found - order).abs() < 0.1);
    }
}

/// Without viscosity and friction the motion is that of `velocities half`, and so are the dumps and the numbers of the screen in the
/// middle of a run: what forces see has left nothing in the velocities when LAMMPS writes them.
#[test]
fn both_versions_outputs_have_the_velocities_as_integrated() {
    let engine = Engine::from_environment();
    let [step, half] = ["step", "half"].map(|velocities| {
        let law = "hertz 1e8 0.3 conservative yes";
        let deck = Deck {
            steps: 2 * HALF,
            dump_every: 7,
            thermo_every: 7,
            thermo_columns: "step ke c_spin c_fastest[1] c_fastest[3]".into(),
            fixes: vec![
                format!("fix move all nve/ellipsoid velocities {velocities}"),
                "compute spin all erotate/asphere".into(),
                "compute fastest all reduce max vx vy vz".into(),
            ],
            ..deck(law)
        };
        run(
            &engine,
            &format!("outputs_{velocities}"),
            &between_walls(),
            &deck,
            1,
        )
    });
    assert_eq!(step.frames.len(), half.frames.len());
    assert!(step.frames.len() > 30);
    for (a, b) in step.frames.iter().zip(&half.frames) {
        let (positions, velocities) = largest_difference(a, b);
        assert!(positions.max(velocities) < 1e-12, "step {}", a.step);
    }
    let (rows, expected) = (step.thermo(), half.thermo());
    assert!(rows.len() > 30 && rows.len() == expected.len());
    for (row, expected) in rows.iter().zip(&expected) {
        for (column, value) in expected {
            let apart = (row[column] - value).abs() / value.abs().max(1e-300);
            assert!(
                apart < 1e-12 || row[column] == *value,
                "{column}: {apart:e}"
            );
        }
    }
}

/// Without viscosity and friction the motion is the same to rounding; and two fixes for two groups are one for both.
#[test]
fn both_versions_elastic_motion_is_that_of_the_half_step() {
    let engine = Engine::from_environment();
    let moved = |name: &str, law: &str, fixes: &[&str], ranks: usize| {
        let deck = Deck {
            steps: 2 * HALF,
            fixes: fixes.iter().map(|f| f.to_string()).collect(),
            ..deck(law)
        };
        run(&engine, name, &between_walls(), &deck, ranks)
    };
    let elastic = "hertz 1e8 0.3 conservative yes";
    let half = moved(
        "elastic_half",
        elastic,
        &["fix move all nve/ellipsoid velocities half"],
        1,
    );
    let step = moved(
        "elastic_step",
        elastic,
        &["fix move all nve/ellipsoid velocities step"],
        1,
    );
    let gap = apart("elastic", &step, &half);
    assert!(gap < 1e-12, "{gap:e}");

    let viscous = VISCOUS;
    let one = moved("groups_one", viscous, &["fix move all nve/ellipsoid"], 1);
    let groups = ["group a id 1:30", "group b subtract all a"];
    let of_two = [
        groups[0],
        groups[1],
        "fix a a nve/ellipsoid",
        "fix b b nve/ellipsoid",
    ];
    let two = moved("groups_two", viscous, &of_two, 4);
    let gap = apart("two groups", &two, &one);
    assert!(gap < 1e-11, "{gap:e}");
    let half = moved(
        "groups_half",
        viscous,
        &["fix move all nve/ellipsoid velocities half"],
        1,
    );
    let gap = apart("against velocities of the half step", &half, &one);
    assert!(gap > 1e-9, "the word changes nothing: {gap:e}");
}
