// SPDX-License-Identifier: MIT OR Apache-2.0
//! The factor of an elliptical contact in Hertz' force: its error and its nanoseconds.

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use ellgran::force::elliptic_integrals::ellipse_integrals;
use ellgran::force::hertz_factors;
use ellgran::simd::InstructionSet;
use ellgran::simd::Stage;
use ellgran::simd::{Registers, MOST_LANES};

use crate::literature;
use crate::numbers::Errors;
use crate::timing::{nanoseconds, Nanoseconds};
use crate::{Effort, Outcome};

/// One relative curvature and what the force factor is there.
#[derive(Clone, Copy)]
struct Point {
    axis_ratio: f64,
    ratio: f64,
    /// Of the curvature matrix.
    trace: f64,
    determinant: f64,
    exact: f64,
}

/// From a circle to `b/a = 1e-3`, evenly in the logarithm.
fn points(count: usize) -> Vec<Point> {
    (0..count)
        .map(|n| {
            let axis_ratio = 10f64.powf(-3.0 * (n as f64 + 0.5) / count as f64);
            // Carlson's integrals: B/A and F2 free of cancellation (docs/theory.md, section 2).
            let e = ellipse_integrals(axis_ratio);
            let ratio = e.bl / (axis_ratio * axis_ratio * e.d);
            let f1 = (4.0 / std::f64::consts::PI * (axis_ratio * e.bl * e.d).sqrt()).cbrt();
            let f2 = std::f64::consts::FRAC_2_PI * axis_ratio.sqrt() * e.k / f1;
            Point {
                axis_ratio,
                ratio,
                trace: 1.0 + ratio,
                determinant: ratio,
                exact: f2.powf(-1.5),
            }
        })
        .collect()
}

/// The library's fitted function in the lanes of an instruction set.
struct Lanes<'a> {
    points: &'a [Point],
    values: &'a mut [f64],
}

impl Stage for Lanes<'_> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        use ellgran::simd::Lanes as Register;
        let mut trace = [1.0; MOST_LANES];
        let mut determinant = [1.0; MOST_LANES];
        let mut value = [0.0; MOST_LANES];
        for (points, values) in self
            .points
            .chunks_exact(S::LANES)
            .zip(self.values.chunks_exact_mut(S::LANES))
        {
            for (lane, point) in points.iter().enumerate() {
                trace[lane] = point.trace;
                determinant[lane] = point.determinant;
            }
            let w = hertz_factors::fit_variable(
                Register::load(registers, &trace),
                Register::load(registers, &determinant),
            );
            hertz_factors::fitted(w, false).phi.store(&mut value);
            values.copy_from_slice(&value[..S::LANES]);
        }
    }
}

struct Method {
    name: String,
    /// Steps of an iteration, else 0.
    steps: usize,
    values: Vec<f64>,
    time: Nanoseconds,
}

pub fn run(directory: &Path, effort: &Effort) -> Outcome {
    // A multiple of all lanes.
    let points = points(480);
    let mut methods = Vec::new();
    macro_rules! method {
        ($name:expr, $steps:expr, $of:expr) => {{
            let of = $of;
            let mut values = vec![0.0; points.len()];
            let time = nanoseconds(effort, points.len(), || {
                for (value, point) in values.iter_mut().zip(black_box(&points)) {
                    *value = of(point);
                }
                black_box(&mut values);
            });
            methods.push(Method {
                name: $name.to_string(),
                steps: $steps,
                values,
                time,
            });
        }};
    }
    method!("Hale", 0, |p: &Point| literature::hale(p.ratio));
    method!("Brewe-Hamrock 1977", 0, |p: &Point| {
        literature::brewe_hamrock(p.ratio)
    });
    method!("Hamrock-Brewe 1983", 0, |p: &Point| {
        literature::hamrock_brewe(p.ratio)
    });
    method!("Antoine", 0, |p: &Point| literature::antoine(p.ratio));
    for steps in 0..=4 {
        method!("iteration", steps, |p: &Point| literature::iterated(
            p.ratio, steps
        ));
    }
    method!("ours, scalar", 0, |p: &Point| hertz_factors::exact(
        p.trace,
        p.determinant,
        false
    )
    .phi);
    let lanes = |name: &str, vectorise: &dyn Fn(Lanes)| {
        let mut values = vec![0.0; points.len()];
        let time = nanoseconds(effort, points.len(), || {
            vectorise(Lanes {
                points: black_box(&points),
                values: &mut values,
            });
            black_box(&mut values);
        });
        Method {
            name: name.to_string(),
            steps: 0,
            values,
            time,
        }
    };
    for (set, name) in [
        (InstructionSet::Avx2, "ours, avx2"),
        (InstructionSet::Avx512, "ours, avx512"),
    ] {
        if set.is_available() {
            methods.push(lanes(name, &|work| set.run(work)));
        }
    }
    write(directory, &points, &methods)
}

/// Ranges of `b/a`, down to the number.
const RANGES: [f64; 2] = [0.1, 1e-3];

fn write(directory: &Path, points: &[Point], methods: &[Method]) -> Outcome {
    let mut table = String::from(
        "method,steps,smallest_axis_ratio,largest_error,rms_error,share_without_value,ns,ns_spread\n",
    );
    let mut curves = String::from("method,steps,axis_ratio,curvature_ratio,error\n");
    for method in methods {
        let errors: Vec<f64> = method
            .values
            .iter()
            .zip(points)
            .map(|(value, point)| value / point.exact - 1.0)
            .collect();
        for smallest in RANGES {
            let within = errors
                .iter()
                .zip(points)
                .filter(|(_, point)| point.axis_ratio >= smallest)
                .map(|(error, _)| *error);
            let e = Errors::of(within);
            writeln!(
                table,
                "{},{},{smallest},{:.3e},{:.3e},{:.4},{:.3},{:.3}",
                csv_word(&method.name),
                method.steps,
                e.largest,
                e.rms,
                e.failed,
                method.time.median,
                method.time.spread
            )?;
        }
        // A method may have no value at some.
        let finite = errors.iter().zip(points).filter(|(e, _)| e.is_finite());
        for (error, point) in finite.step_by(4) {
            writeln!(
                curves,
                "{},{},{:.5e},{:.5e},{:.3e}",
                csv_word(&method.name),
                method.steps,
                point.axis_ratio,
                point.ratio,
                error.abs()
            )?;
        }
    }
    std::fs::write(directory.join("hertz-factors.csv"), table)?;
    std::fs::write(directory.join("hertz-factors-curves.csv"), curves)?;
    Ok(())
}

/// A name may hold a comma.
fn csv_word(name: &str) -> String {
    name.replace(", ", " ")
}
