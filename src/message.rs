// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a number is written in a message.

use core::fmt::{Display, Formatter, Result};

/// A number in the shorter of the two usual forms: `0.25` and `-3`, but `1e-200` and not its two hundred zeros.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let size = self.0.abs();
        if size == 0.0 || !size.is_finite() || (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// Several numbers in brackets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers<'a>(pub &'a [f64]);

impl Display for Numbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (k, x) in self.0.iter().enumerate() {
            write!(f, "{}{}", if k == 0 { "(" } else { " " }, Number(*x))?;
        }
        write!(f, ")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back() {
        for (x, text) in [
            (0.0, "0"),
            (-2.5, "-2.5"),
            (10000.0, "10000"),
            (1e-200, "1e-200"),
            (-1.25e200, "-1.25e200"),
            (f64::MAX, "1.7976931348623157e308"),
            (5e-324, "5e-324"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Number(x).to_string(), text);
            let read: f64 = text.parse().unwrap();
            assert!(read == x || x.is_nan());
        }
        let vector = [1.0, -1e300, 1.0 / 3.0];
        assert_eq!(
            Numbers(&vector).to_string(),
            "(1 -1e300 0.3333333333333333)"
        );
    }
}
