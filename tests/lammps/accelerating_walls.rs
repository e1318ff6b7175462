// SPDX-License-Identifier: MIT OR Apache-2.0
//! With `fix nve/ellipsoid` beside walls whose velocity changes: are the motion under viscous laws and the balance of energies of second
//! order in the time step?

use crate::harness::{run, Deck, Engine, Grain, Outcome, Scene, State};
use crate::shapes::{length, sub};

/// Viscous and frictional, and smooth: the grain neither leaves the wall nor slides.
const LAW: &str = "lsd 2e4 3 tangential linear 1.5e4 2 20";
const TIME: f64 = 8e-3;

/// A wall below the grain, by its name, with the commands that make it.
const WALLS: [(&str, &[&str]); 4] = [
    (
        "wiggle",
        &["fix wall all wall/gran/ellipsoid LAW zplane 0 NULL wiggle z 5e-5 5e-3"],
    ),
    (
        "variables",
        &[
            "variable lift equal 0.06*sin(1257*step*dt)",
            "variable sway equal 0.05*sin(900*step*dt)",
            "variable spin equal 3*sin(1100*step*dt)",
            "fix wall all wall/gran/ellipsoid LAW shape plane point 0 0 0 side inside velocity v_sway 0 v_lift omega 0.02 0 0 0 0 1 v_spin",
        ],
    ),
    (
        "cylinder_that_turns",
        &[
            "variable spin equal 3*sin(1100*step*dt)",
            "fix wall all wall/gran/ellipsoid LAW shape cylinder point 0 0 0.02 axis 0 1 0 radius 0.02 side inside omega 0 0 0.02 0 1 0 v_spin",
        ],
    ),
    (
        "region",
        &[
            "variable rise equal 5e-5*(1-cos(1257*step*dt))",
            "variable turn equal 2e-3*(1-cos(1100*step*dt))",
            "region floor plane 0 0 0 0 0 1 move NULL NULL v_rise rotate v_turn 0.02 0 0 0 0 1",
            "fix wall all wall/gran/ellipsoid LAW region floor",
        ],
    ),
];

/// A grain that weight presses into the wall, as deep as the springs need to carry it.
fn scene() -> Scene {
    let grain = Grain {
        density: 2500.0,
        ..Grain::new([1e-2, 8e-3, 7e-3], [0.0, 0.0, 7e-3])
    };
    let mut scene = Scene::open(0.1, vec![grain]);
    let depth = scene.grains[0].mass() * WEIGHT / 2e4;
    scene.grains[0].position[2] -= depth;
    scene
}

const WEIGHT: f64 = 200.0;

fn deck(wall: &[&str], velocities: &str, steps: u64) -> Deck {
    let mut fixes = vec![
        "compute balance all energy/ellipsoid".into(),
        format!("fix weight all gravity {WEIGHT} vector 0 0 -1"),
    ];
    fixes.extend(wall.iter().map(|line| line.replace("LAW", LAW)));
    fixes.push(format!(
        "fix move all nve/ellipsoid velocities {velocities}"
    ));
    Deck {
        fixes,
        integrate: false,
        time_step: TIME / steps as f64,
        steps,
        skin: 1e-3,
        thermo_every: steps / 40,
        thermo_columns: "step c_balance[6] c_balance[7] c_balance[11] f_wall[10]".into(),
        ..Deck::new(LAW)
    }
}

/// The largest departure from closure, over what is dissipated.
fn left_over(outcome: &Outcome) -> f64 {
    let rows = outcome.thermo();
    let most = rows.iter().map(|row| row["c_balance[11]"].abs());
    let last = rows.last().expect("output");
    most.fold(0.0, f64::max) / (last["c_balance[6]"].abs() + last["c_balance[7]"].abs())
}

/// By which power of the step numbers fall that belong to halved steps.
fn orders(numbers: &[f64]) -> Vec<f64> {
    numbers.windows(2).map(|w| (w[0] / w[1]).log2()).collect()
}

fn shown(numbers: &[f64]) -> String {
    let all: Vec<String> = numbers.iter().map(|x| format!("{x:.1e}")).collect();
    format!("{} of orders {:.2?}", all.join(" "), orders(numbers))
}

const STEPS: [u64; 3] = [400, 800, 1600];

#[test]
fn both_versions_motion_and_balance_are_of_second_order_beside_walls_that_accelerate() {
    let engine = Engine::from_environment();
    for (name, wall) in WALLS {
        let after = |velocities: &str, steps: u64| {
            let deck = deck(wall, velocities, steps);
            let outcome = run(&engine, &format!("accelerating_{name}"), &scene(), &deck, 1);
            for row in outcome.thermo() {
                assert_eq!(row["f_wall[10]"], 1.0, "{name}: the grain left the wall");
            }
            (outcome.last().states[0].clone(), left_over(&outcome))
        };
        let (exact, _) = after("step", 32 * STEPS[0]);
        let apart = |state: &State| {
            let turned = sub(state.velocity, exact.velocity);
            length(sub(state.position, exact.position)) + TIME * length(turned)
        };
        let all = STEPS.map(|steps| after("step", steps));
        let errors = [0, 1, 2].map(|k| apart(&all[k].0));
        let balance = [0, 1, 2].map(|k| all[k].1);
        let half = STEPS.map(|steps| apart(&after("half", steps).0));
        println!(
            "{name}: errors {}; left over {}; errors with velocities half {}",
            shown(&errors),
            shown(&balance),
            shown(&half)
        );
        let least = |numbers: &[f64]| orders(numbers).into_iter().fold(f64::INFINITY, f64::min);
        assert!(least(&errors) > 1.6, "{name}: {errors:?}");
        assert!(errors[2] < 0.1 * half[2], "{name}: {errors:?} {half:?}");
        assert!(least(&balance) > 1.6, "{name}: {balance:?}");
    }
}

/// A plate that a servo presses on a grain: its velocity is chosen for a step each, and the balance of energies knows which one a force meets.
#[test]
fn both_versions_the_balance_is_of_second_order_beside_a_servo() {
    let engine = Engine::from_environment();
    let balance = STEPS.map(|steps| {
        let wall = [
            "fix floor all wall/gran/ellipsoid LAW zplane 0 NULL",
            "fix wall all wall/gran/ellipsoid LAW zplane NULL 1.39e-2 servo 0 0 -1 3 1",
        ];
        let deck = deck(&wall, "step", steps);
        let outcome = run(&engine, "accelerating_servo", &scene(), &deck, 1);
        left_over(&outcome)
    });
    println!("left over {}", shown(&balance));
    assert!(orders(&balance).iter().all(|o| *o > 1.6), "{balance:?}");
}

/// A wall whose velocity a variable chooses from the force on it, so strongly that with the velocity at the step alone each swing would be
/// followed by a larger one. It settles: where its velocity swings forces see the mean over the step.
#[test]
fn both_versions_a_wall_that_follows_its_force_settles() {
    let engine = Engine::from_environment();
    let law = "lsd 2e3 3";
    let (target, answer) = (0.24, 0.5);
    let grain = Grain {
        density: 2.5e6,
        ..Grain::new([1e-2, 8e-3, 7e-3], [0.0, 0.0, 6.9e-3])
    };
    let swing = |velocities: &str| {
        let deck = Deck {
            fixes: vec![
                format!("variable follow equal {answer}*({target}+f_wall[16])"),
                format!("fix wall all wall/gran/ellipsoid {law} shape plane point 0 0 0 side inside velocity 0 0 v_follow"),
                format!("fix move all nve/ellipsoid velocities {velocities}"),
            ],
            integrate: false,
            time_step: 1e-6,
            steps: 200,
            skin: 1e-3,
            thermo_every: 1,
            thermo_columns: "step f_wall[16]".into(),
            ..Deck::new(law)
        };
        let outcome = run(
            &engine,
            "follows",
            &Scene::open(0.1, vec![grain.clone()]),
            &deck,
            1,
        );
        let forces: Vec<f64> = outcome.thermo().iter().map(|r| -r["f_wall[16]"]).collect();
        let swings = forces.windows(2).map(|f| (f[1] - f[0]).abs());
        let all: Vec<f64> = swings.collect();
        let most = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        [most(&all[..10]), most(&all[190..])]
    };
    for velocities in ["half", "step"] {
        let [begin, end] = swing(velocities);
        println!(
            "velocities {velocities}: the force swings by {begin:.1e}, and by {end:.1e} at the end"
        );
        assert!(
            begin > 0.5 * target && end < 1e-3 * begin,
            "{velocities}: {begin:e} {end:e}"
        );
    }
}
