// SPDX-License-Identifier: MIT OR Apache-2.0
//! The neighbour-list path by law and instruction set, and its parts.
//!
//! With ELLGRAN_BENCH_FACTS set to a file name, what the times are to be divided by is written there, one line a
//! benchmark: `name,bytes of history per pair,particles,pairs,touching pairs,bytes per particle`.

mod cases;
mod clock;
mod layer;
mod packing;
mod scene;
mod walls;

use std::cell::LazyCell;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Duration;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};
use ellgran::contact::{one_contact, Laws, Step};
use ellgran::force::hertz_factors;
use ellgran::force::syntax::parse;
use ellgran::list::Accumulators;
use ellgran::list::{compute_pairs, Workspace};
use ellgran::simd::InstructionSet;
use ellgran::tallies::Tallies;

use cases::{Case, CASES, LATER};
use clock::{since, Clock};
use packing::{Random, APART, DENSE, TIME_STEP};
use scene::{Rows, Scene};

const STEP: Step = Step {
    time_step: TIME_STEP,
    advance_history: true,
};
/// Steps before anything is timed: the contacts are those of a run that goes on.
const WARM_UP_STEPS: usize = 32;

/// One line of the facts.
struct Fact {
    name: String,
    history_bytes: usize,
    particles: usize,
    pairs: usize,
    touching: usize,
    particle_bytes: usize,
}

fn instruction_sets() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL
        .into_iter()
        .filter(|set| set.is_available())
}

/// One scene under one law on one instruction set, step after step.
struct Run<'a> {
    scene: &'a Scene,
    laws: &'a Laws,
    rows: Rows<'a>,
    workspace: Workspace,
    forces: Vec<[f64; 3]>,
    torques: Vec<[f64; 3]>,
    energies: Option<(Vec<f64>, Vec<[f64; 6]>)>,
    step: usize,
    /// Whether nothing is remembered from step to step.
    cold: bool,
}

impl<'a> Run<'a> {
    fn new(scene: &'a Scene, laws: &'a Laws, energies: bool, set: InstructionSet) -> Self {
        let count = scene.count();
        let mut run = Run {
            scene,
            laws,
            rows: scene.rows(laws),
            workspace: Workspace::new(set),
            forces: vec![[0.0; 3]; count],
            torques: vec![[0.0; 3]; count],
            energies: energies.then(|| (vec![0.0; count], vec![[0.0; 6]; count])),
            step: 0,
            cold: false,
        };
        run.workspace.keeps_history = true;
        for _ in 0..WARM_UP_STEPS {
            run.advance();
        }
        run
    }

    /// One step; the time of the pairs alone.
    fn advance(&mut self) -> Duration {
        let unchanged = self.step > 0 && !self.cold;
        self.scene
            .prepare(self.laws, &mut self.workspace, self.step, unchanged);
        self.step += 1;
        let mut tallies = self.energies.as_mut().map(|(energies, virials)| Tallies {
            particle_energies: Some(energies),
            particle_virials: Some(virials),
            ..Tallies::default()
        });
        let count = self.scene.count();
        let started = Clock::now();
        let result = compute_pairs(
            self.laws,
            &mut self.workspace,
            &mut self.rows,
            &STEP,
            &mut Accumulators {
                forces: &mut self.forces,
                torques: &mut self.torques,
                reaction_below: count,
                owned: count,
            },
            tallies.as_mut(),
        );
        let time = since(&started);
        black_box(result).expect("no law of the table can break");
        time
    }

    fn touching(&mut self) -> usize {
        let mut tallies = Tallies::default();
        let count = self.scene.count();
        compute_pairs(
            self.laws,
            &mut self.workspace,
            &mut self.rows,
            &STEP,
            &mut Accumulators {
                forces: &mut self.forces,
                torques: &mut self.torques,
                reaction_below: count,
                owned: count,
            },
            Some(&mut tallies),
        )
        .expect("no law of the table can break");
        tallies.touching as usize
    }

    fn fact(&mut self, name: String) -> Fact {
        Fact {
            name,
            history_bytes: self.laws.layout().length * size_of::<f64>(),
            particles: self.scene.count(),
            pairs: self.scene.pairs(),
            touching: self.touching(),
            particle_bytes: self.workspace.bytes() / self.scene.count(),
        }
    }
}

fn timed(steps: u64, mut step: impl FnMut() -> Duration) -> Duration {
    (0..steps).map(|_| step()).sum()
}

fn laws_of(case: &Case) -> Laws {
    let words = case.words();
    let types = words.len();
    let mut table = vec![None; types * types];
    for (k, words) in words.iter().enumerate() {
        let words: Vec<&str> = words.split(' ').collect();
        table[k * (types + 1)] = Some(parse(&words).expect("a law of the table").0);
    }
    Laws::new(types, &table, case.normals_are_kept()).expect("a law of the table")
}

/// The whole list, by law and instruction set.
fn laws(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    for case in CASES.iter().chain(LATER) {
        let scene = LazyCell::new(|| Scene::new(case.semi_axes, DENSE, case.words().len()));
        let laws = laws_of(case);
        let mut group = criterion.benchmark_group(format!("pairs, {}", case.name));
        for set in instruction_sets() {
            // Made when it is timed: a filter on the command line leaves the others alone.
            let mut run = None;
            group.bench_function(BenchmarkId::from_parameter(set.name()), |b| {
                let run = run.get_or_insert_with(|| Run::new(&scene, &laws, case.energies, set));
                b.iter_custom(|steps| timed(steps, || run.advance()));
            });
            facts.extend(
                run.map(|mut run| run.fact(format!("pairs, {}/{}", case.name, set.name()))),
            );
        }
    }
}

/// Pairs that do not touch: all those in reach, with and without a normal from the last step.
fn searches(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    let full: &Case = &CASES[0];
    let laws = laws_of(full);
    for (name, spacing, cold) in [
        ("rejected, cached normal", APART, false),
        ("rejected, cold start", APART, true),
        ("dense, cold start", DENSE, true),
    ] {
        let scene = LazyCell::new(|| Scene::new(full.semi_axes, spacing, 1));
        let mut group = criterion.benchmark_group(name);
        for set in instruction_sets() {
            let mut run = None;
            group.bench_function(BenchmarkId::from_parameter(set.name()), |b| {
                let run = run.get_or_insert_with(|| Run::new(&scene, &laws, false, set));
                b.iter_custom(|steps| {
                    timed(steps, || {
                        if cold {
                            run.rows.forget();
                            run.cold = true;
                        }
                        run.advance()
                    })
                });
            });
            facts.extend(run.map(|mut run| run.fact(format!("{name}/{}", set.name()))));
        }
    }
}

/// What is made of every particle once a step.
fn preparation(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    let full: &Case = &CASES[0];
    let laws = laws_of(full);
    let scene = Scene::new(full.semi_axes, DENSE, 1);
    let mut run = Run::new(&scene, &laws, false, InstructionSet::widest());
    facts.push(run.fact("preparation of particles".into()));
    let mut workspace = run.workspace;
    let mut step = 0;
    criterion.bench_function("preparation of particles", |b| {
        b.iter_custom(|steps| {
            let started = Clock::now();
            for _ in 0..steps {
                step += 1;
                scene.prepare(&laws, &mut workspace, step, true);
                black_box(workspace.bytes());
            }
            since(&started)
        });
    });
}

/// One contact at a time, for the touching pairs of the packing.
fn one_by_one(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    let full: &Case = &CASES[0];
    let laws = laws_of(full);
    let scene = Scene::new(full.semi_axes, DENSE, 1);
    let mut run = Run::new(&scene, &laws, false, InstructionSet::Scalar);
    let mut fact = run.fact("one contact at a time".into());
    let length = laws.layout().length;
    let mut contacts: Vec<(usize, usize, Vec<f64>)> = run
        .rows
        .all_pairs()
        .into_iter()
        .enumerate()
        .filter(|(k, _)| run.rows.touching[*k] != 0)
        .map(|(k, (i, j))| {
            (
                i,
                j,
                run.rows.history[k * length..(k + 1) * length].to_vec(),
            )
        })
        .collect();
    fact.pairs = contacts.len();
    facts.push(fact);
    let mut step = run.step;
    criterion.bench_function("one contact at a time", |b| {
        b.iter_custom(|steps| {
            timed(steps, || {
                step += 1;
                scene.prepare(&laws, &mut run.workspace, step, true);
                let particles = run.workspace.particles();
                let started = Clock::now();
                for (i, j, history) in &mut contacts {
                    let mut touching = true;
                    let found = one_contact(
                        &laws,
                        &particles[*i],
                        &particles[*j],
                        &STEP,
                        &mut touching,
                        history,
                    );
                    let _ = black_box(found);
                }
                since(&started)
            })
        });
    });
}

/// Grains on walls, and far from them.
fn grains_and_walls(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    let full: &Case = &CASES[0];
    let laws = laws_of(full);
    for case in layer::CASES {
        let mut run = None;
        criterion.bench_function(case.name, |b| {
            let run =
                run.get_or_insert_with(|| walls::Run::new(case, full.semi_axes, &laws, &STEP));
            b.iter_custom(|steps| timed(steps, || run.advance()));
        });
        facts.extend(run.map(|run| Fact {
            name: case.name.into(),
            history_bytes: run.history_bytes(),
            particles: run.particles(),
            pairs: run.particles(),
            touching: run.contacts,
            particle_bytes: 0,
        }));
    }
}

/// Hertz factors of a thousand curvature ratios from 1 to 10^4.
fn factors(criterion: &mut Criterion, facts: &mut Vec<Fact>) {
    const COUNT: usize = 1000;
    let mut random = Random::new(7);
    let ratios: Vec<f64> = (0..COUNT).map(|_| 1e4f64.powf(random.unit())).collect();
    let mut group = criterion.benchmark_group("Hertz factors");
    type Factor = fn(f64) -> f64;
    // A + B and A B for A = 1.
    let forms: [(&str, Factor); 3] = [
        ("fit", |ratio| {
            let f = hertz_factors::exact(1.0 + ratio, ratio, true);
            f.phi + f.sigma
        }),
        ("Hale", |ratio| {
            hertz_factors::hale(1.0 + ratio, ratio, false).map_or(0.0, |f| f.phi)
        }),
        ("iteration", |ratio| {
            hertz_factors::contact_ellipse(ratio).f2
        }),
    ];
    for (name, factor) in forms {
        facts.push(Fact {
            name: format!("Hertz factors/{name}"),
            history_bytes: 0,
            particles: COUNT,
            pairs: COUNT,
            touching: COUNT,
            particle_bytes: 0,
        });
        group.bench_function(name, |b| {
            b.iter_custom(|steps| {
                let started = Clock::now();
                for _ in 0..steps {
                    for &ratio in &ratios {
                        black_box(factor(black_box(ratio)));
                    }
                }
                since(&started)
            });
        });
    }
}

fn write_facts(facts: &[Fact]) {
    let Some(path) = std::env::var_os("ELLGRAN_BENCH_FACTS") else {
        return;
    };
    let mut text = String::new();
    for f in facts {
        writeln!(
            text,
            "\"{}\",{},{},{},{},{}",
            f.name, f.history_bytes, f.particles, f.pairs, f.touching, f.particle_bytes
        )
        .expect("a string takes all that is written");
    }
    std::fs::write(path, text).expect("ELLGRAN_BENCH_FACTS names a file that can be written");
}

fn all(criterion: &mut Criterion) {
    let mut facts = Vec::new();
    laws(criterion, &mut facts);
    searches(criterion, &mut facts);
    preparation(criterion, &mut facts);
    one_by_one(criterion, &mut facts);
    grains_and_walls(criterion, &mut facts);
    factors(criterion, &mut facts);
    write_facts(&facts);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500));
    targets = all
}
criterion_main!(benches);
