// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an instruction set can do: the few operations that the contact law and the search are made of. Each set has a file of
//! its own.
//!
//! Intrinsics are called directly where they are safe to call: on a proof of the instruction set that `pulp` hands out,
//! or where the target always has them. Macros, not closures: a closure is not always inlined into the code of the
//! chosen instruction set, and then costs a call and a trip through memory.

/// The most lanes of any instruction set here: two registers of AVX-512.
pub const MOST_LANES: usize = 16;

/// Eight doubles, one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Line(pub [f64; 8]);

impl Line {
    /// All zero.
    pub const ZERO: Line = Line([0.0; 8]);
}

#[cfg(all(feature = "std", any(target_arch = "x86_64", target_arch = "aarch64")))]
#[cold]
#[inline(never)]
pub(super) fn too_short() -> ! {
    panic!("fewer numbers than lanes")
}

/// An instruction set: `self`, of size zero, is the proof that the machine has it.
pub trait Registers: Copy {
    /// Numbers in a register.
    const LANES: usize;
    /// Binary digits of a number.
    const DIGITS: u32 = f64::MANTISSA_DIGITS;
    /// A register.
    type Vector: Copy;
    /// The truth of a comparison, one per lane.
    type Mask: Copy;

    /// `value` in every lane.
    fn splat(self, value: f64) -> Self::Vector;
    /// The first numbers, as many as there are lanes.
    fn load(self, numbers: &[f64]) -> Self::Vector;
    /// The reverse of `load`.
    fn store(self, a: Self::Vector, numbers: &mut [f64]);
    /// `a + b`.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a - b`.
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a * b`.
    fn multiply(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a * b + c`.
    fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `a * b - c`.
    fn multiply_subtract(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `c - a * b`.
    fn negative_multiply_add(
        self,
        a: Self::Vector,
        b: Self::Vector,
        c: Self::Vector,
    ) -> Self::Vector;
    /// `1/a` of a normal number whose inverse is one too; error at most one rounding.
    fn reciprocal(self, a: Self::Vector) -> Self::Vector;
    /// `a/b`, with `b` as in `reciprocal`.
    fn divide(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `1/sqrt(a)` of a positive normal number; error at most two roundings.
    fn reciprocal_sqrt(self, a: Self::Vector) -> Self::Vector;
    /// `sqrt(a)` of zero or a positive normal number above 1e-300.
    fn sqrt(self, a: Self::Vector) -> Self::Vector;
    /// The larger; where `a` is NaN, `b`.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The smaller; where `a` is NaN, `b`.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a < b`.
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask;
    /// `a` where the mask holds, else `b`.
    fn select(self, mask: Self::Mask, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Both.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Either.
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `a` and not `b`.
    fn and_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// One bit per lane, the first lane lowest.
    fn bits(self, mask: Self::Mask) -> u32;
    /// Mantissa from 1 up to 2 and exponent of positive normal numbers.
    fn mantissa_and_exponent(self, a: Self::Vector) -> (Self::Vector, Self::Vector);
    /// Entry `k` of the first lines, for `k` from 0 to 7.
    fn columns(self, lines: &[&Line]) -> [Self::Vector; 8];
    /// Entry `k` of the first lines less that of the first `others`, for `k` from 0 to 5; the last two are nothing to rely on.
    #[inline(always)]
    fn column_differences(self, lines: &[&Line], others: &[&Line]) -> [Self::Vector; 8] {
        let (a, b) = (self.columns(lines), self.columns(others));
        [
            self.subtract(a[0], b[0]),
            self.subtract(a[1], b[1]),
            self.subtract(a[2], b[2]),
            self.subtract(a[3], b[3]),
            self.subtract(a[4], b[4]),
            self.subtract(a[5], b[5]),
            a[6],
            a[7],
        ]
    }
    /// Brings the cache line of a number closer, if the machine can be told so.
    fn prefetch(self, number: &f64);
    /// The reverse: entry `k` of the first lines is register `k`.
    fn lines(self, columns: [Self::Vector; 8], lines: &mut [Line]);
    /// Adds lane `l` of the registers `a`, as a line, to line `at_a[l]`, and that of `b` to line `at_b[l]`; lane after lane,
    /// so that a line that is named twice gets both.
    fn add_to_lines(
        self,
        a: [Self::Vector; 8],
        at_a: &[u32],
        b: [Self::Vector; 8],
        at_b: &[u32],
        lines: &mut [Line],
    );
    /// Component `k` of the first rows, as many as there are lanes, for `k` from 0 to 2. At least as many rows.
    #[inline(always)]
    fn components(self, rows: &[[f64; 3]]) -> [Self::Vector; 3] {
        let mut numbers = [[0.0; MOST_LANES]; 3];
        for (lane, row) in rows[..Self::LANES].iter().enumerate() {
            numbers[0][lane] = row[0];
            numbers[1][lane] = row[1];
            numbers[2][lane] = row[2];
        }
        [
            self.load(&numbers[0]),
            self.load(&numbers[1]),
            self.load(&numbers[2]),
        ]
    }
    /// The reverse of `components`.
    #[inline(always)]
    fn put_components(self, components: [Self::Vector; 3], rows: &mut [[f64; 3]]) {
        let mut numbers = [[0.0; MOST_LANES]; 3];
        self.store(components[0], &mut numbers[0]);
        self.store(components[1], &mut numbers[1]);
        self.store(components[2], &mut numbers[2]);
        for (lane, row) in rows[..Self::LANES].iter_mut().enumerate() {
            *row = [numbers[0][lane], numbers[1][lane], numbers[2][lane]];
        }
    }
    /// Of the numbers of `a`, then those of `b`: the first, third, and so on, and the others.
    #[inline(always)]
    fn alternate(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let mut numbers = [0.0; 2 * MOST_LANES];
        self.store(a, &mut numbers);
        self.store(b, &mut numbers[Self::LANES..]);
        let mut apart = [[0.0; MOST_LANES]; 2];
        for lane in 0..Self::LANES {
            apart[0][lane] = numbers[2 * lane];
            apart[1][lane] = numbers[2 * lane + 1];
        }
        [self.load(&apart[0]), self.load(&apart[1])]
    }
    /// The reverse of `alternate`: `a` and `b` in turns.
    #[inline(always)]
    fn in_turns(self, a: Self::Vector, b: Self::Vector) -> [Self::Vector; 2] {
        let mut apart = [[0.0; MOST_LANES]; 2];
        self.store(a, &mut apart[0]);
        self.store(b, &mut apart[1]);
        let mut numbers = [0.0; 2 * MOST_LANES];
        for lane in 0..Self::LANES {
            numbers[2 * lane] = apart[0][lane];
            numbers[2 * lane + 1] = apart[1][lane];
        }
        [self.load(&numbers), self.load(&numbers[Self::LANES..])]
    }
    /// The reverse of `bits`.
    fn mask(self, bits: u32) -> Self::Mask;
    /// No lane.
    #[inline(always)]
    fn no_lane(self) -> Self::Mask {
        self.less(self.splat(1.0), self.splat(0.0))
    }
    /// The lanes that the mask does not hold for.
    #[inline(always)]
    fn not(self, mask: Self::Mask) -> Self::Mask {
        self.and_not(self.less(self.splat(0.0), self.splat(1.0)), mask)
    }
    /// Whether a mask holds for every lane.
    #[inline(always)]
    fn all(self, mask: Self::Mask) -> bool {
        self.bits(mask) == (1 << Self::LANES) - 1
    }
    /// Whether a mask holds for a lane.
    #[inline(always)]
    fn any(self, mask: Self::Mask) -> bool {
        self.bits(mask) != 0
    }
    /// Whether a mask holds for no lane.
    #[inline(always)]
    fn none(self, mask: Self::Mask) -> bool {
        self.bits(mask) == 0
    }
}

/// Bits of the mantissa of a double.
pub(super) const MANTISSA: i64 = 0x000f_ffff_ffff_ffff;
/// Bits of 1.
pub(super) const ONE: i64 = 0x3ff0_0000_0000_0000;
/// Bits of 2^52.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
pub(super) const TWO_TO_52: i64 = 0x4330_0000_0000_0000;

/// The operations that are one instruction, from a table.
macro_rules! vectors {
    ($($name:ident($($arg:ident),*) = $part:ident.$intrinsic:ident($($given:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::Vector),*) -> Self::Vector {
            self.$part.$intrinsic($($given),*)
        }
    )*};
}

/// The same of masks.
macro_rules! masks {
    ($($name:ident($($arg:ident),*) = $part:ident.$intrinsic:ident($($given:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self::Mask),*) -> Self::Mask {
            self.$part.$intrinsic($($given),*)
        }
    )*};
}

/// Products and sums apart: a fused operation is a library call on a machine that may not have it.
#[allow(unused_macros)] // AArch64 has it, and its library none of the sets that use this.
macro_rules! two_roundings {
    () => {
        #[inline(always)]
        fn multiply_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.add(self.multiply(a, b), c)
        }
        #[inline(always)]
        fn multiply_subtract(
            self,
            a: Self::Vector,
            b: Self::Vector,
            c: Self::Vector,
        ) -> Self::Vector {
            self.subtract(self.multiply(a, b), c)
        }
        #[inline(always)]
        fn negative_multiply_add(
            self,
            a: Self::Vector,
            b: Self::Vector,
            c: Self::Vector,
        ) -> Self::Vector {
            self.subtract(c, self.multiply(a, b))
        }
    };
}

#[allow(unused_imports)] // Not every machine needs all of them.
pub(super) use {masks, two_roundings, vectors};
