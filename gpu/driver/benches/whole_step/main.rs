// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole steps of packings on a GPU: what each part of a step takes, and how many grains a second.
//!
//! `cargo xtask gpu --bench` makes the packings and starts this. The grains of a packing are copied side by side, and stand in a layer
//! of grains that do not move: no rank has to tell another anything, and each grain has all its neighbours.

#![allow(unsafe_code)]
// Each block calls functions of the interface with pointers to locals that outlive the call.
#![allow(clippy::undocumented_unsafe_blocks)]

mod neighbours;
mod packing;
#[path = "../../tests/support/mod.rs"]
mod support;

use clap::Parser;
use ellgran::c_api::particles::EllgranStep;
use ellgran_gpu::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuMotion,
    ELLGRAN_GPU_ANY_SHAPES, ELLGRAN_GPU_DOUBLE, ELLGRAN_GPU_MIXED,
};
use ellgran_gpu::c_api::gpu::ellgran_gpu_free;
use ellgran_gpu::c_api::scene::{
    ellgran_gpu_check, ellgran_gpu_counts, ellgran_gpu_histories, ellgran_gpu_new_list,
    ellgran_gpu_scene_free, ellgran_gpu_scene_new, ellgran_gpu_scene_set_precision,
};
use ellgran_gpu::c_api::step::{
    ellgran_gpu_compute_pairs, ellgran_gpu_finish_step, ellgran_gpu_prepare, ellgran_gpu_start_step,
};
use packing::Grains;
use std::path::PathBuf;
use support::{new, succeed, Engine};

#[derive(Parser)]
#[command(
    about = "Times whole steps of packings on a GPU; prints a table of comma-separated values"
)]
struct Options {
    /// Data files of LAMMPS with atom_style ellipsoid
    #[arg(required = true)]
    packings: Vec<PathBuf>,
    /// Copies in each direction, one run each
    #[arg(long, value_delimiter = ',', default_value = "2,3,6")]
    copies: Vec<usize>,
    /// Law of all pairs
    #[arg(long, default_value = "nfd 1e7 0.3 50 50 tangential tfd 0.5")]
    law: String,
    /// Steps that are timed
    #[arg(long, default_value_t = 100)]
    steps: usize,
    /// Steps before these
    #[arg(long, default_value_t = 20)]
    warm: usize,
    /// Time step, s
    #[arg(long, default_value_t = 4e-6)]
    time_step: f64,
    /// What the neighbour list has more than the sum of the largest semi-axes, m
    #[arg(long, default_value_t = 0.2e-3)]
    skin: f64,
    /// Of the candidates, in parts of the smallest semi-axis of the packing
    #[arg(long, default_value_t = 0.02)]
    margin: f64,
    /// Forces with the velocities of the half step, as an engine's own integrator hands them over
    #[arg(long)]
    half: bool,
    /// Contacts in mixed precision, and how far loads are from those in double precision
    #[arg(long)]
    mixed: bool,
    /// `cargo bench` says so
    #[arg(long, hide = true)]
    bench: bool,
}

/// The calls of a step, in their order.
const PARTS: [&str; 4] = ["start", "prepare", "pairs", "finish"];

fn main() {
    let options = Options::parse();
    let engine = Engine::new();
    let gpu = support::open();
    println!(
        "# {}: {}, {} steps, velocities of the {}{}",
        engine.name(),
        options.law,
        options.steps,
        if options.half { "half step" } else { "step" },
        if options.mixed {
            ", mixed precision"
        } else {
            ""
        }
    );
    println!(
        "packing,margin,grains,pairs_listed_per_grain,contacts_per_grain,selections,start_ms,prepare_ms,pairs_ms,finish_ms,step_ms,\
         step_spread_percent,grain_steps_per_second,bytes_per_grain,largest_difference_of_loads"
    );
    for file in &options.packings {
        let unit = packing::read(file);
        for &copies in &options.copies {
            let name = file.file_stem().unwrap_or_default().to_string_lossy();
            time(&options, &engine, gpu, &name, &unit, copies);
        }
    }
    unsafe { ellgran_gpu_free(gpu) };
}

fn time(
    options: &Options,
    engine: &Engine,
    gpu: *mut ellgran_gpu::c_api::gpu::EllgranGpu,
    name: &str,
    unit: &Grains,
    copies: usize,
) {
    let (grains, owned) = unit.copied(copies, options.skin);
    let (starts, neighbours) = neighbours::full_list(&grains, owned, options.skin);
    let count = grains.positions.len();
    let (dt, stream) = (options.time_step, engine.stream);
    let mut scene = core::ptr::null_mut();
    let laws = support::laws(&options.law);
    unsafe {
        succeed(ellgran_gpu_scene_new(
            gpu,
            laws,
            ELLGRAN_GPU_ANY_SHAPES,
            &mut scene,
        ));
        ellgran::c_api::law::ellgran_laws_free(laws);
    }
    let identifiers: Vec<i32> = (1..=count as i32).collect();
    let positions = engine.put(&grains.positions);
    let velocities = engine.put(&grains.velocities);
    let momenta = engine.put(&grains.angular_momenta);
    let quaternions = engine.put(&grains.quaternions);
    let semi_axes = engine.put(&grains.semi_axes);
    let masses = engine.put(&grains.masses);
    let types = engine.put(&vec![1i32; count]);
    let identifiers = engine.put(&identifiers);
    let changes = engine.put(&vec![[0.0f64; 6]; count]);
    let loads_before = engine.put(&vec![[0.0f64; 6]; owned]);
    let loads = engine.put(&vec![[0.0f64; 6]; owned]);
    let starts = engine.put(&starts);
    let pairs = neighbours.len();
    let neighbours = engine.put(&neighbours);
    let on_device = EllgranGpuGrains {
        owned_count: owned,
        count,
        positions: positions.vectors(),
        velocities: velocities.vectors(),
        angular_momenta: momenta.vectors(),
        velocity_changes: if options.half {
            core::ptr::null()
        } else {
            changes.pointer()
        },
        masses: masses.pointer(),
        semi_axes: semi_axes.vectors(),
        quaternions: quaternions.vectors(),
        types: types.pointer(),
        identifiers: identifiers.pointer(),
        ..new()
    };
    let motion = EllgranGpuMotion {
        count: owned,
        positions: positions.vectors(),
        velocities: velocities.vectors(),
        angular_momenta: momenta.vectors(),
        quaternions: quaternions.vectors(),
        semi_axes: semi_axes.vectors(),
        masses: masses.pointer(),
        forces: loads.loads().forces,
        torques: loads.loads().torques,
        velocity_changes: if options.half {
            core::ptr::null_mut()
        } else {
            changes.pointer()
        },
        loads_before: loads_before.pointer(),
        ..new()
    };
    let smallest = grains.semi_axes.iter().flatten().copied();
    let smallest = smallest.fold(f64::INFINITY, f64::min);
    let list = EllgranGpuList {
        starts: starts.pointer(),
        neighbours: neighbours.pointer(),
        margin: options.margin * smallest,
        ..new()
    };
    let step = EllgranStep {
        advance_history: 1,
        time_step: dt,
        ..new()
    };
    let in_precision = |precision: i32| {
        succeed(unsafe { ellgran_gpu_scene_set_precision(scene, precision) });
    };
    if options.mixed {
        in_precision(ELLGRAN_GPU_MIXED);
    }
    succeed(unsafe { ellgran_gpu_new_list(scene, &on_device, &list, stream) });
    let compute = || {
        succeed(unsafe {
            ellgran_gpu_compute_pairs(scene, &on_device, &step, &loads.loads(), stream)
        });
    };
    compute();
    let selections = || {
        let mut counts = new::<EllgranGpuCounts>();
        succeed(unsafe { ellgran_gpu_counts(scene, stream, &mut counts) });
        counts
    };
    let events: Vec<_> = (0..=PARTS.len() * options.steps)
        .map(|_| engine.event())
        .collect();
    let one_step = |mark: &mut dyn FnMut()| unsafe {
        succeed(ellgran_gpu_start_step(scene, &motion, dt, stream));
        mark();
        succeed(ellgran_gpu_prepare(scene, &on_device, stream));
        mark();
        compute();
        mark();
        succeed(ellgran_gpu_finish_step(scene, &motion, dt, stream));
        mark();
    };
    for _ in 0..options.warm {
        one_step(&mut || {});
    }
    succeed(unsafe { ellgran_gpu_check(scene, &on_device, stream) });
    let before = selections().selections;
    engine.record(&events[0]);
    let mut next = 1;
    for _ in 0..options.steps {
        one_step(&mut || {
            engine.record(&events[next]);
            next += 1;
        });
    }
    succeed(unsafe { ellgran_gpu_check(scene, &on_device, stream) });
    let counts = selections();
    let between = |from: usize, to: usize| engine.milliseconds(&events[from], &events[to]);
    let part = |k: usize| -> f64 {
        let steps = 0..options.steps;
        let sum: f64 = steps
            .map(|s| between(PARTS.len() * s + k, PARTS.len() * s + k + 1))
            .sum();
        sum / options.steps as f64
    };
    let mut whole: Vec<f64> = (0..options.steps)
        .map(|s| between(PARTS.len() * s, PARTS.len() * (s + 1)))
        .collect();
    whole.sort_by(f64::total_cmp);
    let mean = between(0, PARTS.len() * options.steps) / options.steps as f64;
    let spread = 100.0 * (whole[whole.len() * 3 / 4] - whole[whole.len() / 4]) / mean;
    let mut histories = new::<EllgranGpuHistories>();
    succeed(unsafe { ellgran_gpu_histories(scene, -1, &mut histories) });
    let touching = engine.read_at::<u32>(histories.touching.addr() as u64, pairs);
    let touching = touching.iter().filter(|&&state| state & 1 != 0).count();
    let forces = engine.read(&loads);
    assert!(forces.iter().flatten().all(|x| x.is_finite()));
    // Once more without time passing, in each precision: from the same histories.
    let of = |precision: i32| {
        in_precision(precision);
        let step = EllgranStep {
            advance_history: 0,
            ..step
        };
        succeed(unsafe {
            ellgran_gpu_compute_pairs(scene, &on_device, &step, &loads.loads(), stream)
        });
        engine.read(&loads)
    };
    let difference = if options.mixed {
        largest_difference(&of(ELLGRAN_GPU_MIXED), &of(ELLGRAN_GPU_DOUBLE))
    } else {
        0.0
    };
    let n = owned as f64;
    println!(
        "{name},{},{owned},{:.2},{:.3},{},{:.4},{:.4},{:.4},{:.4},{mean:.4},{spread:.1},{:.3e},{},{difference:.1e}",
        options.margin,
        pairs as f64 / n,
        touching as f64 / n,
        counts.selections - before,
        part(0),
        part(1),
        part(2),
        part(3),
        1e3 * n / mean,
        counts.bytes / owned as u64,
    );
    unsafe { ellgran_gpu_scene_free(scene) };
}

/// Of two sets of loads: of forces as a share of the largest force, of torques of the largest torque.
fn largest_difference(a: &[[f64; 6]], b: &[[f64; 6]]) -> f64 {
    let of = |part: core::ops::Range<usize>| {
        let numbers = |loads: &[[f64; 6]]| -> Vec<f64> {
            let parts = loads.iter().map(|load| &load[part.clone()]);
            parts.flatten().copied().collect()
        };
        let (a, b) = (numbers(a), numbers(b));
        let largest = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max) / largest.max(f64::MIN_POSITIVE)
    };
    of(0..3).max(of(3..6))
}
