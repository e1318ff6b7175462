// SPDX-License-Identifier: MIT OR Apache-2.0
//! Histories that no call has written, as from a broken restart file: through one contact, a list and a wall. Each is refused, or its
//! contact is finite.

use ellgran::c_api::law::ellgran_history_swap;

use super::scene::*;
use super::{neighbour_list, one_contact, walls};

pub fn run(bytes: &[u8]) {
    let _ = read(&mut Bytes::new(bytes));
}

fn read(u: &mut Bytes) -> arbitrary::Result<()> {
    let Some(laws) = Laws::read(u)? else {
        return Ok(());
    };
    match u.int_in_range(0..=2)? {
        0 => {
            let bodies = [body(u, laws.types)?, body(u, laws.types)?];
            let step = step(u)?;
            let mut history = numbers(u, laws.length)?;
            swapped_twice(&laws, &history);
            let mut touching = 1;
            one_contact::contact(&laws, &bodies, &step, &mut touching, &mut history);
            Ok(())
        }
        1 => neighbour_list::calls(u, &laws, true),
        _ => walls::calls(u, &laws, true),
    }
}

pub fn numbers(u: &mut Bytes, count: usize) -> arbitrary::Result<Vec<f64>> {
    (0..count).map(|_| number(u)).collect()
}

/// To exchange the bodies twice changes nothing but the sign of zero.
fn swapped_twice(laws: &Laws, history: &[f64]) {
    let mut once = vec![0.0; history.len()];
    let mut twice = once.clone();
    // SAFETY: all arrays are as long as a history of these laws, and no two overlap.
    unsafe {
        assert!(succeeded(ellgran_history_swap(
            laws.pointer,
            history.as_ptr(),
            once.as_mut_ptr()
        )));
        assert!(succeeded(ellgran_history_swap(
            laws.pointer,
            once.as_ptr(),
            twice.as_mut_ptr()
        )));
    }
    for (x, y) in history.iter().zip(&twice) {
        assert!(x == y || (x.is_nan() && y.is_nan()), "{x} {y}");
    }
}
