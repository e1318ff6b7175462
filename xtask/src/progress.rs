// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a person waiting sees: a bar on a terminal, a line every few seconds anywhere else. Always on standard
//! error, because standard output carries results only.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// How often a log that is not a terminal hears from a long step.
const LOG_INTERVAL: Duration = Duration::from_secs(10);
/// How often a terminal is redrawn.
const TERMINAL_INTERVAL: Duration = Duration::from_millis(100);
const BAR_WIDTH: usize = 30;

/// One remark on standard error.
pub fn say(message: impl AsRef<str>) {
    eprintln!("xtask: {}", message.as_ref());
}

/// One long step: announced when made, closed with its time when finished.
pub struct Progress {
    title: String,
    started: Instant,
    shown: Instant,
    terminal: bool,
}

impl Progress {
    pub fn start(title: impl Into<String>) -> Self {
        let title = title.into();
        say(format!("{title} ..."));
        let now = Instant::now();
        Progress {
            title,
            started: now,
            shown: now,
            terminal: std::io::stderr().is_terminal(),
        }
    }

    /// `fraction` in 0..=1 when it is known; `note` says the same in the step's own units.
    pub fn update(&mut self, fraction: Option<f64>, note: &str) {
        let interval = if self.terminal {
            TERMINAL_INTERVAL
        } else {
            LOG_INTERVAL
        };
        if self.shown.elapsed() < interval {
            return;
        }
        self.shown = Instant::now();
        let elapsed = human_time(self.started.elapsed());
        if self.terminal {
            let bar = fraction.map(bar).unwrap_or_default();
            eprint!("\r\x1b[K  {bar} {note} {elapsed}");
            let _ = std::io::stderr().flush();
        } else {
            let percent = fraction.map_or(String::new(), |f| format!("{:3.0} % ", 100.0 * f));
            say(format!("  {}: {percent}{note} after {elapsed}", self.title));
        }
    }

    pub fn finish(self) {
        self.clear();
        say(format!(
            "{} done in {}",
            self.title,
            human_time(self.started.elapsed())
        ));
    }

    /// Leaves the line free, for an error message to come.
    pub fn clear(&self) {
        if self.terminal {
            eprint!("\r\x1b[K");
        }
    }
}

fn bar(fraction: f64) -> String {
    let full = (fraction.clamp(0.0, 1.0) * BAR_WIDTH as f64).round() as usize;
    format!("[{}{}]", "#".repeat(full), "-".repeat(BAR_WIDTH - full))
}

pub fn human_time(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else {
        format!("{} min {:02} s", seconds as u64 / 60, seconds as u64 % 60)
    }
}

/// ninja's `[done/total] what` status line.
pub fn ninja_progress(line: &str) -> Option<(u64, u64)> {
    let (status, _) = line.strip_prefix('[')?.split_once(']')?;
    let (done, total) = status.split_once('/')?;
    Some((done.trim().parse().ok()?, total.trim().parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ninja_status_lines_are_read() {
        assert_eq!(
            ninja_progress("[12/934] Building CXX object CMakeFiles/lammps.dir/atom.cpp.o"),
            Some((12, 934))
        );
        assert_eq!(ninja_progress("[934/934] Linking"), Some((934, 934)));
        assert_eq!(ninja_progress("[note] not a status"), None);
        assert_eq!(ninja_progress("warning: array[3/4]"), None);
    }

    #[test]
    fn times_read_like_times() {
        assert_eq!(human_time(Duration::from_millis(1250)), "1.2 s");
        assert_eq!(human_time(Duration::from_secs(187)), "3 min 07 s");
    }

    #[test]
    fn the_bar_keeps_its_width() {
        for fraction in [-1.0, 0.0, 0.33, 1.0, 2.0] {
            assert_eq!(bar(fraction).len(), BAR_WIDTH + 2);
        }
    }
}
