// SPDX-License-Identifier: MIT OR Apache-2.0
//! Messages belong to a thread; laws may be shared by threads.

use std::ffi::CStr;
use std::ptr::null_mut;
use std::sync::mpsc;
use std::thread;

use ellgran::c_api::contact::*;
use ellgran::c_api::law::*;
use ellgran::c_api::status::*;
use ellgran::c_api::version::*;

use crate::scene::*;

#[test]
fn each_thread_has_its_own_message() {
    let wrong = |word: &str| {
        let deck = format!("hertz 1e4 0.3 {word}");
        let mut out = Untouched::sized();
        fails(
            parse_status(&deck, null_mut(), out.pointer()),
            ELLGRAN_ERROR_LAW,
            &[word],
        );
    };
    thread::spawn(move || {
        assert_eq!(message(), "", "a new thread has none");
        wrong("first");
        let (ready, wait) = mpsc::channel();
        thread::spawn(move || {
            wrong("second");
            ready.send(()).unwrap();
        });
        wait.recv().unwrap();
        assert!(message().contains("first"));
        // A call that succeeds leaves it.
        parse("hertz 1e4 0.3");
        assert!(message().contains("first"));
    })
    .join()
    .unwrap();
}

#[test]
fn a_long_message_is_cut_at_a_character() {
    let word = "ä".repeat(3000);
    let mut out = Untouched::sized();
    let status = parse_status(&format!("hertz 1e4 0.3 {word}"), null_mut(), out.pointer());
    fails(status, ELLGRAN_ERROR_LAW, &["ää"]);
    assert!(message().len() < 1024);
    out.check();
}

struct Shared(*const EllgranLaws);
// SAFETY: laws are immutable.
unsafe impl Sync for Shared {}

#[test]
fn threads_share_laws() {
    let laws = Laws::new(&["nfd 1e4 0.3 10 10", "nfd 3e4 0.2 20 30"]);
    let shared = Shared(laws.0);
    let bodies = random_bodies(1);
    let all = || {
        let shared = &shared;
        let mut sum = [0.0; 3];
        for i in &bodies {
            for j in &bodies {
                let (mut touching, mut history) = (0, [0.0; 3]);
                let mut force = Untouched::<EllgranContactForce>::sized();
                if i.identifier < j.identifier {
                    // SAFETY: all pointers are valid.
                    let f = unsafe {
                        ok(ellgran_contact(
                            shared.0,
                            i,
                            j,
                            &STEP,
                            &mut touching,
                            history.as_mut_ptr(),
                            null_mut(),
                            force.pointer(),
                        ));
                        (*force.pointer()).force
                    };
                    sum = [0, 1, 2].map(|k| sum[k] + f[k]);
                }
            }
        }
        sum
    };
    let expected = all();
    assert!(expected.iter().all(|x| *x != 0.0));
    thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(all)).collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), expected);
        }
    });
}

#[test]
fn versions() {
    assert_eq!(ellgran_abi_version(), ELLGRAN_ABI_VERSION);
    // SAFETY: static and ends with NUL.
    let text = unsafe { CStr::from_ptr(ellgran_version()) };
    assert_eq!(text.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}
