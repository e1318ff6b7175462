// SPDX-License-Identifier: MIT OR Apache-2.0
//! Nanoseconds of one item: processor time of this thread, median of several rounds.

use crate::clock::{since, Clock};
use crate::Effort;

#[derive(Clone, Copy, Debug)]
pub struct Nanoseconds {
    pub median: f64,
    /// Half the distance between the quartiles.
    pub spread: f64,
}

/// `run` goes through `items` of them.
pub fn nanoseconds(effort: &Effort, items: usize, mut run: impl FnMut()) -> Nanoseconds {
    let mut time_of = |repetitions: usize| {
        let start = Clock::now();
        for _ in 0..repetitions {
            run();
        }
        since(&start).as_secs_f64()
    };
    // Once to warm up, then as many as fill a round.
    time_of(1);
    let mut repetitions = 1;
    loop {
        let time = time_of(repetitions);
        if time >= effort.seconds || repetitions > 1 << 24 {
            break;
        }
        let wanted = effort.seconds / time.max(1e-9) * repetitions as f64;
        repetitions = (wanted * 1.1).ceil().max(repetitions as f64 + 1.0) as usize;
    }
    let mut rounds: Vec<f64> = (0..effort.rounds)
        .map(|_| 1e9 * time_of(repetitions) / (repetitions * items) as f64)
        .collect();
    rounds.sort_by(f64::total_cmp);
    Nanoseconds {
        median: rounds[rounds.len() / 2],
        spread: 0.5 * (rounds[rounds.len() * 3 / 4] - rounds[rounds.len() / 4]),
    }
}
