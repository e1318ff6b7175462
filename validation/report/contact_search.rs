// SPDX-License-Identifier: MIT OR Apache-2.0
//! Overlap and normal of two ellipsoids: the error of three searches and their nanoseconds.
//!
//! The pairs are made from their contact: the common normal and the overlap are chosen, the centres follow. So the minimal
//! overlap is known without a search.

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;

use ellgran::geometry::{search, Ellipsoid, Outcome as Found};
use ellgran::vector::Vector3;

use crate::numbers::{Errors, Random};
use crate::perram_wertheim::Symmetric3;
use crate::timing::{nanoseconds, Nanoseconds};
use crate::{midway_point, perram_wertheim, support_newton, Effort, Outcome};

/// Two bodies, the first about the origin.
#[derive(Clone, Copy)]
pub struct Pair {
    pub i: Ellipsoid,
    pub j: Ellipsoid,
    /// From centre to centre.
    pub d: Vector3,
    /// What the other searches prepare per grain: `S`, its inverse, the radius of the sphere of the same volume.
    pub shape_i: Symmetric3,
    pub shape_j: Symmetric3,
    pub inverse_i: Symmetric3,
    pub inverse_j: Symmetric3,
    pub volume_radius_i: f64,
    pub volume_radius_j: f64,
}

impl Pair {
    fn new(i: Ellipsoid, j: Ellipsoid, d: Vector3) -> Pair {
        let volume_radius = |b: &Ellipsoid| (b.semi_axes.x * b.semi_axes.y * b.semi_axes.z).cbrt();
        Pair {
            shape_i: shape(&i, 2),
            shape_j: shape(&j, 2),
            inverse_i: shape(&i, -2),
            inverse_j: shape(&j, -2),
            volume_radius_i: volume_radius(&i),
            volume_radius_j: volume_radius(&j),
            i,
            j,
            d,
        }
    }
}

/// `R diag(a^power) R^T`.
fn shape(body: &Ellipsoid, power: i32) -> Symmetric3 {
    let mut m = [0.0; 6];
    for (axis, a) in body.axes.iter().zip(body.semi_axes.to_array()) {
        let w = a.powi(power);
        let e = axis.to_array();
        for (entry, (r, c)) in m
            .iter_mut()
            .zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)])
        {
            *entry += w * e[r] * e[c];
        }
    }
    m
}

/// A pair, its contact, and the same pair one time step earlier.
struct Case {
    now: Pair,
    before: Pair,
    normal: Vector3,
    overlap: f64,
}

/// How far things move in a step: in small semi-axes and in radians.
const MOTION: f64 = 1e-3;

fn cases(aspect: f64, count: usize) -> Vec<Case> {
    let mut random = Random(7 + aspect as u64);
    let mut cases = Vec::with_capacity(count);
    while cases.len() < count {
        let axes = [aspect, 1.0, 1.0];
        let mut turn = || -> [f64; 4] { random.on_sphere() };
        let (qi, qj) = (turn(), turn());
        let body = |q: [f64; 4]| Ellipsoid::new(axes, q).expect("a good shape");
        let (i, j) = (body(qi), body(qj));
        let n = Vector3::from_array(random.on_sphere());
        // From a ten thousandth to a hundredth of the small semi-axis.
        let overlap = 10f64.powf(random.between(-4.0, -2.0));
        let (si, sj) = (i.support(n), j.support(n));
        let d = si.point + sj.point - n * overlap;
        let now = Pair::new(i, j, d);
        // Where the chosen contact is a minimum, but not the least.
        match search(&i, &j, d, None) {
            Found::Touching(found) if (found.penetration - overlap).abs() < 1e-10 => {}
            _ => continue,
        }
        let mut moved = |q: [f64; 4]| {
            let r: [f64; 3] = random.on_sphere();
            let small = 0.5 * MOTION;
            // q + (0, r) q/2
            body([
                q[0] - small * (r[0] * q[1] + r[1] * q[2] + r[2] * q[3]),
                q[1] + small * (r[0] * q[0] + r[1] * q[3] - r[2] * q[2]),
                q[2] + small * (r[1] * q[0] + r[2] * q[1] - r[0] * q[3]),
                q[3] + small * (r[2] * q[0] + r[0] * q[2] - r[1] * q[1]),
            ])
        };
        let (i, j) = (moved(qi), moved(qj));
        let before = Pair::new(i, j, d + Vector3::from_array(random.on_sphere()) * MOTION);
        cases.push(Case {
            now,
            before,
            normal: n,
            overlap,
        });
    }
    cases
}

/// What a search finds, by a tolerance.
pub type Finding = Option<(Vector3, f64)>;

struct Row {
    method: &'static str,
    start: &'static str,
    tolerance: f64,
    time: Nanoseconds,
    found: Vec<Finding>,
}

const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-11];

pub fn run(directory: &Path, effort: &Effort) -> Outcome {
    let mut table = String::from(
        "aspect_ratio,method,start,tolerance,ns,ns_spread,failed,overlap_error_rms,overlap_error_largest,normal_error_rms,normal_error_largest,overlap_own_rms,normal_own_rms\n",
    );
    for aspect in [2.0, 10.0] {
        let cases = cases(aspect, if effort.quick { 96 } else { 1200 });
        let rows = rows(effort, &cases);
        for row in &rows {
            // Its own converged value: by the tightest tolerance, warm and cold alike.
            let own = rows
                .iter()
                .filter(|other| other.method == family(row.method) && other.start == "warm")
                .min_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
            let nothing = f64::NAN;
            let apart = |found: &Finding, n: Vector3, overlap: f64, least: f64| match found {
                // The angle by the tangent part, which keeps its digits.
                Some((m, f)) => (((f - overlap) / least).abs(), m.cross(n).norm()),
                None => (nothing, nothing),
            };
            let model: Vec<(f64, f64)> = row
                .found
                .iter()
                .zip(&cases)
                .map(|(found, case)| apart(found, case.normal, case.overlap, case.overlap))
                .collect();
            let iteration: Vec<(f64, f64)> = match own {
                Some(own) => row
                    .found
                    .iter()
                    .zip(&own.found)
                    .zip(&cases)
                    .map(|((found, own), case)| match own {
                        Some((n, f)) => apart(found, *n, *f, case.overlap),
                        None => (nothing, nothing),
                    })
                    .collect(),
                None => Vec::new(),
            };
            let (overlap, normal) = (
                Errors::of(model.iter().map(|e| e.0)),
                Errors::of(model.iter().map(|e| e.1)),
            );
            let own_overlap = Errors::of(iteration.iter().map(|e| e.0));
            let own_normal = Errors::of(iteration.iter().map(|e| e.1));
            writeln!(
                table,
                "{aspect},{},{},{:e},{:.2},{:.2},{:.4},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e}",
                row.method,
                row.start,
                row.tolerance,
                row.time.median,
                row.time.spread,
                overlap.failed,
                overlap.rms,
                overlap.largest,
                normal.rms,
                normal.largest,
                own_overlap.rms,
                own_normal.rms
            )?;
        }
    }
    std::fs::write(directory.join("contact-search.csv"), table)?;
    Ok(())
}

/// Whose converged value a method has: the library and the lanes search as `support_newton` does.
fn family(method: &str) -> &str {
    match method {
        "perram-wertheim" | "midway" => method,
        _ => "support",
    }
}

fn rows(effort: &Effort, cases: &[Case]) -> Vec<Row> {
    let mut rows = Vec::new();
    macro_rules! row {
        ($method:expr, $start:expr, $tolerance:expr, $starts:expr, $of:expr) => {{
            let starts: Vec<_> = $starts;
            let of = $of;
            let mut found: Vec<Finding> = vec![None; cases.len()];
            let time = nanoseconds(effort, cases.len(), || {
                for ((found, case), start) in found.iter_mut().zip(black_box(cases)).zip(&starts) {
                    *found = of(&case.now, start);
                }
                black_box(&mut found);
            });
            rows.push(Row {
                method: $method,
                start: $start,
                tolerance: $tolerance,
                time,
                found,
            });
        }};
    }
    let tight = 1e-13;
    let last_normal = |case: &Case| {
        let start = support_newton::cold_start(&case.before);
        support_newton::search(&case.before, start, tight).map_or(case.normal, |found| found.0)
    };
    let last_parameter =
        |case: &Case| perram_wertheim::search(&case.before, 0.5, tight).map_or(0.5, |f| f.2);
    let last_point = |case: &Case| {
        let start = midway_point::cold_start(&case.before);
        midway_point::search(&case.before, start, 1e-11).map_or(start, |f| f.2)
    };
    let nothing = || vec![(); cases.len()];
    for tolerance in TOLERANCES {
        row!(
            "support",
            "warm",
            tolerance,
            cases.iter().map(last_normal).collect(),
            |pair: &Pair, start: &Vector3| support_newton::search(pair, *start, tolerance)
        );
        row!(
            "support",
            "cold",
            tolerance,
            nothing(),
            |pair: &Pair, _: &()| {
                support_newton::search(pair, support_newton::cold_start(pair), tolerance)
            }
        );
        row!(
            "perram-wertheim",
            "warm",
            tolerance,
            cases.iter().map(last_parameter).collect(),
            |pair: &Pair, start: &f64| {
                perram_wertheim::search(pair, *start, tolerance).map(|f| (f.0, f.1))
            }
        );
        row!(
            "perram-wertheim",
            "cold",
            tolerance,
            nothing(),
            |pair: &Pair, _: &()| {
                perram_wertheim::search(pair, 0.5, tolerance).map(|f| (f.0, f.1))
            }
        );
        row!(
            "midway",
            "warm",
            tolerance,
            cases.iter().map(last_point).collect(),
            |pair: &Pair, start: &midway_point::Point| {
                midway_point::search(pair, *start, tolerance).map(|f| (f.0, f.1))
            }
        );
        row!(
            "midway",
            "cold",
            tolerance,
            nothing(),
            |pair: &Pair, _: &()| {
                midway_point::search(pair, midway_point::cold_start(pair), tolerance)
                    .map(|f| (f.0, f.1))
            }
        );
    }
    let touching = |found: Found| match found {
        Found::Touching(found) => Some((found.normal, found.penetration)),
        Found::Separated(_) => None,
    };
    row!(
        "library",
        "warm",
        0.0,
        cases.iter().map(last_normal).collect(),
        |pair: &Pair, start: &Vector3| touching(search(&pair.i, &pair.j, pair.d, Some(*start)))
    );
    row!("library", "cold", 0.0, nothing(), |pair: &Pair, _: &()| {
        touching(search(&pair.i, &pair.j, pair.d, None))
    });
    let pairs: Vec<(Pair, Vector3)> = cases
        .iter()
        .map(|case| (case.now, last_normal(case)))
        .collect();
    crate::search_lanes::each(effort, &pairs, |method, steps, time, found| {
        rows.push(Row {
            method,
            start: "warm",
            tolerance: steps as f64,
            time,
            found,
        });
    });
    rows
}
