// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every operation of every instruction set of this machine against single numbers.

use super::*;
use crate::real::Real;
use crate::simd::portable::Portable;
use crate::simd::{InstructionSet, Lanes, Stage};

fn sixteen(numbers: [f64; 8]) -> [f64; MOST_LANES] {
    // The upper eight in another order.
    core::array::from_fn(|k| numbers[if k < 8 { k } else { 3 * k % 8 }])
}

/// Everything that a register does, against single numbers.
struct Check;

impl Stage for Check {
    fn run<S: Registers>(self, registers: S) {
        let a = sixteen([1.5, 3e-7, 12.25, 7e99, 1.0, 2.0, 1e-120, 0.3]);
        let b = sixteen([-2.0, 4e-7, 12.25, 5e98, 3.0, -7.0, 2e-120, 0.2]);
        let c = sixteen([0.5, -1e-13, 2.0, 1e99, 1e-3, 4.0, 1e-200, 0.1]);
        let [x, y, z] = [&a, &b, &c].map(|numbers| Lanes::load(registers, numbers));
        let check = |what: &str, found: Lanes<S>, expected: &dyn Fn(f64, f64, f64) -> f64| {
            let mut line = [0.0; MOST_LANES];
            found.store(&mut line);
            for k in 0..S::LANES {
                let wanted = expected(a[k], b[k], c[k]);
                assert!(
                    (line[k] - wanted).abs() <= 8e-16 * wanted.abs(),
                    "{what}: {} and {wanted}",
                    line[k]
                );
            }
        };
        check("sum", x + y, &|x, y, _| x + y);
        check("difference", x - z, &|x, _, z| x - z);
        check("product", x * y, &|x, y, _| x * y);
        check("quotient", x / y, &|x, y, _| x / y);
        check("negative", -x, &|x, _, _| -x);
        check("root", x.sqrt(), &|x, _, _| x.sqrt());
        check("root of zero", x.constant(0.0).sqrt(), &|_, _, _| 0.0);
        check("inverse", y.reciprocal(), &|_, y, _| 1.0 / y);
        check("inverse root", x.reciprocal_sqrt(), &|x, _, _| {
            1.0 / x.sqrt()
        });
        check("larger", Real::max(x, y), &|x, y, _| f64::max(x, y));
        check("smaller", Real::min(x, y), &|x, y, _| f64::min(x, y));
        check(
            "number for NaN",
            Real::max(x.constant(f64::NAN), y),
            &|_, y, _| y,
        );
        let not_a_number = Real::max(y, y.constant(f64::NAN));
        assert_eq!(
            registers.bits(not_a_number.less(y.constant(f64::INFINITY))),
            0,
            "NaN for NaN"
        );
        // With or without a rounding in between.
        let tolerant =
            |what: &str, found: Lanes<S>, expected: &dyn Fn(f64, f64, f64) -> (f64, f64)| {
                let mut line = [0.0; MOST_LANES];
                found.store(&mut line);
                for k in 0..S::LANES {
                    let (wanted, scale) = expected(a[k], b[k], c[k]);
                    assert!((line[k] - wanted).abs() <= 4e-16 * scale, "{what}");
                }
            };
        let size = |x: f64, y: f64, z: f64| (x * y).abs() + z.abs();
        tolerant("x y + z", x.multiply_add(y, z), &|x, y, z| {
            (x * y + z, size(x, y, z))
        });
        tolerant("x y - z", x.multiply_subtract(y, z), &|x, y, z| {
            (x * y - z, size(x, y, z))
        });
        tolerant("z - x y", x.negative_multiply_add(y, z), &|x, y, z| {
            (z - x * y, size(x, y, z))
        });
        let above_one = Real::max(x, x.constant(1.0));
        tolerant("logarithm", above_one.ln(), &|x, _, _| {
            (x.max(1.0).ln(), x.max(1.0).ln().abs() + 1e-300)
        });

        let less = x.less(y);
        check("choice", Lanes::select(less, x, z), &|x, y, z| {
            if x < y {
                x
            } else {
                z
            }
        });
        let other = z.less(x);
        let bits = |k: fn(bool, bool) -> bool| {
            (0..S::LANES).fold(0u32, |bits, lane| {
                let (p, q) = (a[lane] < b[lane], c[lane] < a[lane]);
                bits | u32::from(k(p, q)) << lane
            })
        };
        assert_eq!(
            registers.bits(registers.and(less, other)),
            bits(|p, q| p & q)
        );
        assert_eq!(
            registers.bits(registers.or(less, other)),
            bits(|p, q| p | q)
        );
        assert_eq!(
            registers.bits(registers.and_not(less, other)),
            bits(|p, q| p & !q)
        );

        let mut lines = [Line::ZERO; MOST_LANES];
        for (k, line) in lines.iter_mut().enumerate() {
            line.0 = core::array::from_fn(|entry| (10 * k + entry) as f64);
        }
        let refs: [&Line; MOST_LANES] = core::array::from_fn(|k| &lines[k]);
        let columns = registers.columns(&refs);
        for (entry, column) in columns.into_iter().enumerate() {
            let mut line = [0.0; MOST_LANES];
            registers.store(column, &mut line);
            for (lane, number) in line[..S::LANES].iter().enumerate() {
                assert_eq!(*number, (10 * lane + entry) as f64);
            }
        }
        let mut others = [Line::ZERO; MOST_LANES];
        for (k, line) in others.iter_mut().enumerate() {
            line.0 = core::array::from_fn(|entry| ((k + 3) * (entry + 7)) as f64);
        }
        let other_refs: [&Line; MOST_LANES] = core::array::from_fn(|k| &others[k]);
        let differences = registers.column_differences(&refs, &other_refs);
        for (entry, column) in differences.into_iter().take(6).enumerate() {
            let mut line = [0.0; MOST_LANES];
            registers.store(column, &mut line);
            for lane in 0..S::LANES {
                assert_eq!(line[lane], lines[lane].0[entry] - others[lane].0[entry]);
            }
        }
        let mut back = [Line::ZERO; MOST_LANES];
        registers.lines(columns, &mut back);
        assert_eq!(back[..S::LANES], lines[..S::LANES]);

        let at_a = [3, 1, 3, 0, 2, 5, 5, 5, 1, 1, 1, 0, 4, 4, 2, 2];
        let at_b = [0, 3, 3, 2, 1, 1, 4, 5, 5, 1, 2, 3, 4, 2, 2, 0];
        let mut sums = [Line([0.5; 8]); 6];
        let mut expected = sums;
        let twice = columns.map(|c| registers.add(c, c));
        registers.add_to_lines(columns, &at_a, twice, &at_b, &mut sums);
        for lane in 0..S::LANES {
            for entry in 0..8 {
                expected[at_a[lane] as usize].0[entry] += lines[lane].0[entry];
                expected[at_b[lane] as usize].0[entry] += 2.0 * lines[lane].0[entry];
            }
        }
        assert_eq!(sums, expected);

        let rows: [[f64; 3]; MOST_LANES + 1] =
            core::array::from_fn(|lane| [0, 1, 2].map(|k| (10 * lane + k) as f64));
        let components = registers.components(&rows);
        for (k, component) in components.into_iter().enumerate() {
            let mut line = [0.0; MOST_LANES];
            registers.store(component, &mut line);
            for (lane, number) in line[..S::LANES].iter().enumerate() {
                assert_eq!(*number, rows[lane][k]);
            }
        }
        let mut back = [[-1.0; 3]; MOST_LANES + 1];
        registers.put_components(components, &mut back);
        assert_eq!(back[..S::LANES], rows[..S::LANES]);
        assert!(back[S::LANES..].iter().all(|row| *row == [-1.0; 3]));

        let numbers: [f64; 2 * MOST_LANES] = core::array::from_fn(|k| k as f64);
        let halves = [&numbers[..], &numbers[S::LANES..]].map(|n| registers.load(n));
        let apart = registers.alternate(halves[0], halves[1]);
        for (odd, half) in apart.into_iter().enumerate() {
            let mut line = [0.0; MOST_LANES];
            registers.store(half, &mut line);
            for (lane, number) in line[..S::LANES].iter().enumerate() {
                assert_eq!(*number, (2 * lane + odd) as f64);
            }
        }
        let mut together = [0.0; 2 * MOST_LANES];
        let [low, high] = registers.in_turns(apart[0], apart[1]);
        registers.store(low, &mut together);
        registers.store(high, &mut together[S::LANES..]);
        assert_eq!(together[..2 * S::LANES], numbers[..2 * S::LANES]);

        for bits in 0..1 << S::LANES {
            assert_eq!(registers.bits(registers.mask(bits)), bits);
        }
        let numbers: Vec<f64> = (0..=MOST_LANES as i32).map(f64::from).collect();
        let mut copy = [-1.0; MOST_LANES + 1];
        registers.store(registers.load(&numbers[1..]), &mut copy[1..]);
        assert_eq!(copy[1..=S::LANES], numbers[1..=S::LANES]);
        assert!(copy[S::LANES + 1..].iter().all(|n| *n == -1.0));
    }
}

#[test]
fn registers_do_what_numbers_do() {
    Check.run(Portable);
    for set in InstructionSet::ALL {
        if set.is_available() {
            set.run(Check);
        }
    }
}
