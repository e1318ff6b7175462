// SPDX-License-Identifier: MIT OR Apache-2.0
//! Processor time of this thread: what other programs take on a busy machine does not count.

use std::time::Duration;

pub struct Clock(Duration);

#[cfg(unix)]
impl Clock {
    pub fn now() -> Self {
        let mut time = libc::timespec {
            tv_sec: 0,
            tv_nsec: 0,
        };
        // SAFETY: the pointer is to a local that outlives the call.
        let status = unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &raw mut time) };
        assert_eq!(status, 0, "the system has no clock of a thread's time");
        Clock(Duration::new(time.tv_sec as u64, time.tv_nsec as u32))
    }
}

#[cfg(not(unix))]
impl Clock {
    pub fn now() -> Self {
        use std::sync::OnceLock;
        use std::time::Instant;
        static START: OnceLock<Instant> = OnceLock::new();
        Clock(START.get_or_init(Instant::now).elapsed())
    }
}

pub fn since(start: &Clock) -> Duration {
    Clock::now().0.saturating_sub(start.0)
}
