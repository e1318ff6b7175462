// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run: blocks of all families in turn, on so many threads, until so many pairs are done or the time is over.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::block::{Block, Name, PAIRS};
use super::counts::{Counts, State};
use super::families::Family;
use super::refusals::Refusals;

/// When a run ends.
#[derive(Clone, Copy, Debug)]
pub enum Length {
    /// So many pairs, those of earlier parts of the run among them.
    Pairs(u64),
    /// So long from now.
    Time(Duration),
}

/// Blocks of each family between two looks at the clock.
const ROUND: u64 = 4;

/// Goes on from where `state` stands; `said` hears of it about every five seconds.
pub fn go_on(
    state: &mut State,
    length: Length,
    threads: usize,
    file: Option<&Path>,
    mut said: impl FnMut(&State, f64),
) -> Result<(), Box<dyn std::error::Error>> {
    let started = Instant::now();
    let mut last_said = started;
    let (before, processor) = (state.seconds, processor_seconds());
    if state.refusals.tried == 0 {
        state.refusals = Refusals::run(state.seed);
    }
    loop {
        let share = match length {
            Length::Pairs(pairs) => state.pairs() as f64 / pairs as f64,
            Length::Time(time) => started.elapsed().as_secs_f64() / time.as_secs_f64(),
        };
        state.seconds = before + processor_seconds() - processor;
        if share >= 1.0 {
            break;
        }
        let round = match length {
            // Not much more than was asked for.
            Length::Pairs(pairs) => {
                let left = pairs - state.pairs();
                let blocks = left.div_ceil((PAIRS * Family::ALL.len()) as u64);
                blocks.min(ROUND)
            }
            Length::Time(_) => ROUND,
        };
        let jobs: Vec<Name> = Family::ALL
            .iter()
            .flat_map(|family| {
                let counts = state.families.entry(family.name().into()).or_default();
                let first = counts.blocks;
                counts.blocks += round;
                (first..first + round).map(|number| Name {
                    seed: state.seed,
                    family: *family,
                    number,
                })
            })
            .collect();
        let done = state.pairs();
        let families = &mut state.families;
        for (family, part) in run_all(&jobs, threads) {
            let whole = families.entry(family.name().into()).or_default();
            whole.add(part);
        }
        state.count_for_each_set(state.pairs() - done);
        if last_said.elapsed() > Duration::from_secs(5) {
            last_said = Instant::now();
            said(state, share);
            if let Some(file) = file {
                state.write(file)?;
            }
        }
    }
    if let Some(file) = file {
        state.write(file)?;
    }
    Ok(())
}

/// Time that this process has had processors, all threads together: on a machine that others use it is not the time that passed.
fn processor_seconds() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: writes to the struct that it is given, which outlives the call.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// What came out of each of these blocks, in their order.
fn run_all(jobs: &[Name], threads: usize) -> Vec<(Family, Counts)> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    let work = || loop {
        let k = next.fetch_add(1, Ordering::Relaxed);
        let Some(name) = jobs.get(k) else { return };
        let mut counts = Counts::default();
        Block::draw(*name).run(&mut counts);
        let mut done = done.lock().expect("no thread fails");
        done.push((k, name.family, counts));
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    let mut done = done.into_inner().expect("no thread fails");
    done.sort_by_key(|(k, ..)| *k);
    done.into_iter().map(|(_, f, c)| (f, c)).collect()
}
