// SPDX-License-Identifier: MIT OR Apache-2.0
//! Several measurements of one thing.

/// A median, and how far the measurements spread around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    pub median: f64,
    /// Half the distance between the smallest and the largest.
    pub spread: f64,
}

impl Measured {
    /// Of at least one number.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (sorted.first()?, sorted.last()?);
        let middle = sorted.len() / 2;
        let median = if sorted.len() % 2 == 1 {
            sorted[middle]
        } else {
            0.5 * (sorted[middle - 1] + sorted[middle])
        };
        Some(Measured {
            median,
            spread: 0.5 * (last - first),
        })
    }

    pub fn scaled(self, factor: f64) -> Self {
        Measured {
            median: self.median * factor,
            spread: self.spread * factor,
        }
    }

    /// Of one run nothing is known of its scatter.
    pub fn show(&self) -> String {
        if self.spread == 0.0 {
            return short(self.median);
        }
        format!("{} ± {}", short(self.median), short(self.spread))
    }
}

/// Three digits, and no more than needed.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size >= 99.95 {
        format!("{value:.0}")
    } else if size >= 9.995 {
        format!("{value:.1}")
    } else if size > 0.0 {
        format!("{value:.2}")
    } else {
        "0".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_does_not_mind_an_outlier() {
        let m = Measured::of(&[3.0, 100.0, 1.0]).unwrap();
        assert_eq!(m.median, 3.0);
        assert_eq!(m.spread, 49.5);
        assert_eq!(Measured::of(&[1.0, 2.0]).unwrap().median, 1.5);
        assert_eq!(Measured::of(&[]), None);
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!(short(1234.5), "1234");
        assert_eq!(short(99.99), "100");
        assert_eq!(short(12.345), "12.3");
        assert_eq!(short(0.1234), "0.12");
    }
}
