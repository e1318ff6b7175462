// SPDX-License-Identifier: MIT OR Apache-2.0
//! A register of numbers: the contact law's [`Real`] in the lanes of the chosen instruction set.

use super::registers::{Line, Registers, MOST_LANES};
use crate::real::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// One register. `registers` is of size zero: the proof that the instruction set is there.
#[derive(Clone, Copy)]
pub struct Lanes<S: Registers> {
    registers: S,
    /// What is in it.
    pub value: S::Vector,
}

impl<S: Registers> Lanes<S> {
    /// A register.
    #[inline(always)]
    pub fn new(registers: S, value: S::Vector) -> Self {
        Lanes { registers, value }
    }
    /// Registers as numbers.
    #[inline(always)]
    pub fn all(registers: S, v: [S::Vector; 8]) -> [Self; 8] {
        macro_rules! lane {
            ($k:literal) => {
                Lanes {
                    registers,
                    value: v[$k],
                }
            };
        }
        [
            lane!(0),
            lane!(1),
            lane!(2),
            lane!(3),
            lane!(4),
            lane!(5),
            lane!(6),
            lane!(7),
        ]
    }
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(registers: S, value: f64) -> Self {
        Lanes {
            registers,
            value: registers.splat(value),
        }
    }
    /// The first numbers.
    #[inline(always)]
    pub fn load(registers: S, numbers: &[f64]) -> Self {
        Lanes {
            registers,
            value: registers.load(numbers),
        }
    }
    /// Writes the first numbers.
    #[inline(always)]
    pub fn store(self, numbers: &mut [f64]) {
        self.registers.store(self.value, numbers);
    }
}

macro_rules! operation {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Registers> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Lanes {
                    registers: self.registers,
                    value: self.registers.$function(self.value, other.value),
                }
            }
        }
    };
}
operation!(Add, add, add);
operation!(Sub, sub, subtract);
operation!(Mul, mul, multiply);
operation!(Div, div, divide);

macro_rules! operation_with_constant {
    ($trait:ident, $method:ident) => {
        impl<S: Registers> $trait<f64> for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                $trait::$method(self, Lanes::splat(self.registers, other))
            }
        }
    };
}
operation_with_constant!(Add, add);
operation_with_constant!(Sub, sub);
operation_with_constant!(Mul, mul);

impl<S: Registers> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes::splat(self.registers, -0.0) - self
    }
}

macro_rules! unary {
    ($($name:ident),*) => {$(
        #[inline(always)]
        fn $name(self) -> Self {
            Lanes {
                registers: self.registers,
                value: self.registers.$name(self.value),
            }
        }
    )*};
}
macro_rules! binary {
    ($($name:ident),*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            Lanes {
                registers: self.registers,
                value: self.registers.$name(self.value, other.value),
            }
        }
    )*};
}
macro_rules! ternary {
    ($($name:ident),*) => {$(
        #[inline(always)]
        fn $name(self, a: Self, b: Self) -> Self {
            Lanes {
                registers: self.registers,
                value: self.registers.$name(self.value, a.value, b.value),
            }
        }
    )*};
}

impl<S: Registers> Real for Lanes<S> {
    type Mask = S::Mask;

    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Lanes::splat(self.registers, value)
    }
    unary!(sqrt, reciprocal, reciprocal_sqrt);
    binary!(max, min);
    ternary!(multiply_add, multiply_subtract, negative_multiply_add);
    #[inline(always)]
    fn less(self, other: Self) -> S::Mask {
        self.registers.less(self.value, other.value)
    }
    #[inline(always)]
    fn select(mask: S::Mask, if_true: Self, if_false: Self) -> Self {
        Lanes {
            registers: if_true.registers,
            value: if_true
                .registers
                .select(mask, if_true.value, if_false.value),
        }
    }
    #[inline(always)]
    fn any(self, mask: S::Mask) -> bool {
        self.registers.any(mask)
    }
    /// Relative error 4e-16 for arguments from 1 to 1e300: exponent and mantissa apart, then the series of the inverse
    /// hyperbolic tangent.
    #[inline(always)]
    fn ln(self) -> Self {
        let registers = self.registers;
        let (mantissa, exponent) = registers.mantissa_and_exponent(self.value);
        let (mantissa, exponent) = (
            Lanes::new(registers, mantissa),
            Lanes::new(registers, exponent),
        );
        let high = mantissa.constant(core::f64::consts::SQRT_2).less(mantissa);
        let mantissa = Self::select(high, mantissa * 0.5, mantissa);
        let exponent = Self::select(high, exponent + 1.0, exponent);
        let s = (mantissa - 1.0) / (mantissa + 1.0);
        let z = s * s;
        let mut series = z.constant(1.0 / 23.0);
        for k in (1..11).rev() {
            series = series.multiply_add(z, z.constant(1.0 / (2 * k + 1) as f64));
        }
        let tail = s * z * series;
        exponent.multiply_add(exponent.constant(core::f64::consts::LN_2), (tail + s) * 2.0)
    }
}

/// The registers of eight numbers.
#[inline(always)]
pub(crate) fn values<S: Registers>(v: [Lanes<S>; 8]) -> [S::Vector; 8] {
    [
        v[0].value, v[1].value, v[2].value, v[3].value, v[4].value, v[5].value, v[6].value,
        v[7].value,
    ]
}

/// Writes eight numbers a lane, a line per lane.
#[inline(always)]
pub(crate) fn put<S: Registers>(registers: S, v: [Lanes<S>; 8], lines: &mut [Line; MOST_LANES]) {
    registers.lines(values(v), lines);
}

/// References, one by one: a closure is not always inlined.
macro_rules! lines {
    ($records:expr $(, $field:ident)?) => {{
        let r = $records;
        [
            &r[0]$(.$field)?,
            &r[1]$(.$field)?,
            &r[2]$(.$field)?,
            &r[3]$(.$field)?,
            &r[4]$(.$field)?,
            &r[5]$(.$field)?,
            &r[6]$(.$field)?,
            &r[7]$(.$field)?,
            &r[8]$(.$field)?,
            &r[9]$(.$field)?,
            &r[10]$(.$field)?,
            &r[11]$(.$field)?,
            &r[12]$(.$field)?,
            &r[13]$(.$field)?,
            &r[14]$(.$field)?,
            &r[15]$(.$field)?,
        ]
    }};
}

pub(crate) use lines;
