// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two registers of any instruction set as one: their instructions are interleaved, which hides latency.

use super::registers::{Line, Registers};

/// Two registers side by side.
#[derive(Clone, Copy, Debug)]
pub struct Twice<S>(pub S);

/// The registers of one side.
macro_rules! side {
    ($v:ident, $k:literal) => {
        [
            $v[0][$k], $v[1][$k], $v[2][$k], $v[3][$k], $v[4][$k], $v[5][$k], $v[6][$k], $v[7][$k],
        ]
    };
}
macro_rules! twice {
    ($($name:ident($($arg:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::Vector),*) -> Self::Vector {
            [self.0.$name($($arg[0]),*), self.0.$name($($arg[1]),*)]
        }
    )*};
}

impl<S: Registers> Registers for Twice<S> {
    const LANES: usize = 2 * S::LANES;
    const DIGITS: u32 = S::DIGITS;
    type Vector = [S::Vector; 2];
    type Mask = [S::Mask; 2];

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        [self.0.splat(value); 2]
    }
    twice! {
        add(a, b);
        subtract(a, b);
        multiply(a, b);
        multiply_add(a, b, c);
        multiply_subtract(a, b, c);
        negative_multiply_add(a, b, c);
        reciprocal(a);
        divide(a, b);
        reciprocal_sqrt(a);
        sqrt(a);
        max(a, b);
        min(a, b);
    }
    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask {
        [self.0.less(a[0], b[0]), self.0.less(a[1], b[1])]
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        [
            self.0.select(mask[0], a[0], b[0]),
            self.0.select(mask[1], a[1], b[1]),
        ]
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.and(a[0], b[0]), self.0.and(a[1], b[1])]
    }
    #[inline(always)]
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.or(a[0], b[0]), self.0.or(a[1], b[1])]
    }
    #[inline(always)]
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.and_not(a[0], b[0]), self.0.and_not(a[1], b[1])]
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        self.0.bits(mask[0]) | self.0.bits(mask[1]) << S::LANES
    }
    #[inline(always)]
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector) {
        let (m0, e0) = self.0.mantissa_and_exponent(a[0]);
        let (m1, e1) = self.0.mantissa_and_exponent(a[1]);
        ([m0, m1], [e0, e1])
    }
    #[inline(always)]
    fn prefetch(self, number: &f64) {
        self.0.prefetch(number);
    }
    #[inline(always)]
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8] {
        let (a, b) = (self.0.columns(lines), self.0.columns(&lines[S::LANES..]));
        [
            [a[0], b[0]],
            [a[1], b[1]],
            [a[2], b[2]],
            [a[3], b[3]],
            [a[4], b[4]],
            [a[5], b[5]],
            [a[6], b[6]],
            [a[7], b[7]],
        ]
    }
    #[inline(always)]
    fn column_differences(self, lines: &[&Line], others: &[&Line]) -> [Self::Vector; 8] {
        let a = self.0.column_differences(lines, others);
        let b = self
            .0
            .column_differences(&lines[S::LANES..], &others[S::LANES..]);
        [
            [a[0], b[0]],
            [a[1], b[1]],
            [a[2], b[2]],
            [a[3], b[3]],
            [a[4], b[4]],
            [a[5], b[5]],
            [a[6], b[6]],
            [a[7], b[7]],
        ]
    }
    #[inline(always)]
    fn lines(self, c: [Self::Vector; 8], lines: &mut [Line]) {
        self.0.lines(side!(c, 0), lines);
        self.0.lines(side!(c, 1), &mut lines[S::LANES..]);
    }
    #[inline(always)]
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    ) {
        self.0
            .add_to_lines(side!(a, 0), at_a, side!(b, 0), at_b, lines);
        let (at_a, at_b) = (&at_a[S::LANES..], &at_b[S::LANES..]);
        self.0
            .add_to_lines(side!(a, 1), at_a, side!(b, 1), at_b, lines);
    }
    #[inline(always)]
    fn load(self, numbers: &[f64]) -> Self::Vector {
        [self.0.load(numbers), self.0.load(&numbers[S::LANES..])]
    }
    #[inline(always)]
    fn store(self, a: Self::Vector, numbers: &mut [f64]) {
        self.0.store(a[0], numbers);
        self.0.store(a[1], &mut numbers[S::LANES..]);
    }
    #[inline(always)]
    fn components(self, rows: &[[f64; 3]]) -> [Self::Vector; 3] {
        let [a, b] = [
            self.0.components(rows),
            self.0.components(&rows[S::LANES..]),
        ];
        [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]]]
    }
    #[inline(always)]
    fn put_components(self, [x, y, z]: [Self::Vector; 3], rows: &mut [[f64; 3]]) {
        self.0.put_components([x[0], y[0], z[0]], rows);
        let rows = &mut rows[S::LANES..];
        self.0.put_components([x[1], y[1], z[1]], rows);
    }
    #[inline(always)]
    fn alternate(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let (a, b) = (self.0.alternate(a[0], a[1]), self.0.alternate(b[0], b[1]));
        [[a[0], b[0]], [a[1], b[1]]]
    }
    #[inline(always)]
    fn in_turns(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        [self.0.in_turns(a[0], b[0]), self.0.in_turns(a[1], b[1])]
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::Mask {
        [
            self.0.mask(bits & ((1 << S::LANES) - 1)),
            self.0.mask(bits >> S::LANES),
        ]
    }
}
