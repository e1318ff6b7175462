// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's arrays of three or six numbers a particle, a register for each of the numbers.
//!
//! Where an array ends within the lanes, the others have copies of the first row, and nothing of theirs is written.

use super::{Lanes, Registers, MOST_LANES};

/// The first numbers.
#[inline(always)]
pub(crate) fn first_numbers<S: Registers>(registers: S, numbers: &[f64], count: usize) -> Lanes<S> {
    if count == S::LANES {
        return Lanes::load(registers, numbers);
    }
    let mut padded = [numbers[0]; MOST_LANES];
    padded[..count].copy_from_slice(&numbers[..count]);
    Lanes::load(registers, &padded)
}

/// The numbers of the first `count` rows, at most as many as there are lanes.
#[inline(always)]
pub(crate) fn components<S: Registers>(
    registers: S,
    rows: &[[f64; 3]],
    count: usize,
) -> [Lanes<S>; 3] {
    if count == S::LANES {
        return three(registers, registers.components(rows));
    }
    let mut padded = [rows[0]; MOST_LANES];
    padded[..count].copy_from_slice(&rows[..count]);
    three(registers, registers.components(&padded))
}

/// The reverse of [`components`].
#[inline(always)]
pub(crate) fn put_components<S: Registers>(
    registers: S,
    [x, y, z]: [Lanes<S>; 3],
    rows: &mut [[f64; 3]],
    count: usize,
) {
    let values = [x.value, y.value, z.value];
    if count == S::LANES {
        return registers.put_components(values, rows);
    }
    let mut padded = [[0.0; 3]; MOST_LANES];
    registers.put_components(values, &mut padded);
    rows[..count].copy_from_slice(&padded[..count]);
}

/// The numbers of the first `count` rows: three, and the other three.
#[inline(always)]
pub(crate) fn double_components<S: Registers>(
    registers: S,
    rows: &[[f64; 6]],
    count: usize,
) -> [[Lanes<S>; 3]; 2] {
    if count == S::LANES {
        return halves(registers, rows.as_flattened().as_chunks().0);
    }
    let mut padded = [rows[0]; MOST_LANES];
    padded[..count].copy_from_slice(&rows[..count]);
    halves(registers, padded.as_flattened().as_chunks().0)
}

/// The reverse of [`double_components`].
#[inline(always)]
pub(crate) fn put_double_components<S: Registers>(
    registers: S,
    numbers: [[Lanes<S>; 3]; 2],
    rows: &mut [[f64; 6]],
    count: usize,
) {
    if count == S::LANES {
        let halves = rows.as_flattened_mut().as_chunks_mut().0;
        return put_halves(registers, numbers, halves);
    }
    let mut padded = [[0.0; 6]; MOST_LANES];
    let halves = padded.as_flattened_mut().as_chunks_mut().0;
    put_halves(registers, numbers, halves);
    rows[..count].copy_from_slice(&padded[..count]);
}

#[inline(always)]
fn three<S: Registers>(registers: S, [x, y, z]: [S::Vector; 3]) -> [Lanes<S>; 3] {
    [
        Lanes::new(registers, x),
        Lanes::new(registers, y),
        Lanes::new(registers, z),
    ]
}

/// Of rows that belong together by twos.
#[inline(always)]
fn halves<S: Registers>(registers: S, halves: &[[f64; 3]]) -> [[Lanes<S>; 3]; 2] {
    let low = registers.components(halves);
    let high = registers.components(&halves[S::LANES..]);
    let x = registers.alternate(low[0], high[0]);
    let y = registers.alternate(low[1], high[1]);
    let z = registers.alternate(low[2], high[2]);
    [
        three(registers, [x[0], y[0], z[0]]),
        three(registers, [x[1], y[1], z[1]]),
    ]
}

/// The reverse of [`halves`].
#[inline(always)]
fn put_halves<S: Registers>(registers: S, [a, b]: [[Lanes<S>; 3]; 2], halves: &mut [[f64; 3]]) {
    let x = registers.in_turns(a[0].value, b[0].value);
    let y = registers.in_turns(a[1].value, b[1].value);
    let z = registers.in_turns(a[2].value, b[2].value);
    registers.put_components([x[0], y[0], z[0]], halves);
    registers.put_components([x[1], y[1], z[1]], &mut halves[S::LANES..]);
}
