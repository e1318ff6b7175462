// SPDX-License-Identifier: MIT OR Apache-2.0
//! `displacement hysteretic`: a bed of springs with Coulomb's limit (docs/theory.md, section 4.1). First loading against Cattaneo's and
//! Mindlin's curve, unloading and reloading against Masing's, Mindlin's and Deresiewicz' loss of a cycle, and what no history may do.

use crate::support::held_contact::{HeldContact, NONE};
use crate::support::random::Stream;
use crate::support::scene::pair_law;
use ellgran::force::syntax::parse;
use ellgran::force::{force_of_springs, TangentialForce};
use ellgran::vector::{Symmetric2, Vector2};

const DEPTH: f64 = 2e-3;
const FRICTION: f64 = 0.4;
const NU: f64 = 0.3;

/// One contact, moved by hand.
struct Moved(HeldContact);

impl Moved {
    fn new(words: &str, curvature: Symmetric2) -> Moved {
        let words = format!("{words} tangential tfd {FRICTION} displacement hysteretic");
        Moved(HeldContact::new(&words, curvature))
    }

    fn evaluate(
        &mut self,
        depth: f64,
        by: Vector2,
        velocity: Vector2,
        passes: bool,
    ) -> TangentialForce {
        let c = &mut self.0;
        let (normal, factors) = (c.normal_force(depth), c.factors());
        force_of_springs(
            &c.law.kinds.tangential,
            &c.law.constants.tangential,
            normal,
            &factors,
            c.curvature,
            depth,
            &mut c.springs,
            c.memory,
            c.energy,
            passes,
            by,
            velocity,
        )
    }

    fn by(&mut self, depth: f64, by: Vector2) -> TangentialForce {
        let t = self.evaluate(depth, by, NONE, true);
        let c = &mut self.0;
        c.work -= 0.5 * (c.force + t.force).dot(by);
        (c.memory, c.energy, c.force) = (t.memory, t.elastic_energy, t.force);
        t
    }
}

/// Force over Coulomb's limit by displacement over that of sliding.
fn cattaneo_mindlin(s: f64) -> f64 {
    1.0 - (1.0 - s.clamp(0.0, 1.0)).powf(1.5)
}

/// The limit of the force and the displacement at which a circular contact of equal spheres slides.
fn scales(moved: &Moved) -> (f64, f64) {
    let sliding = FRICTION * (2.0 - NU) / (2.0 * (1.0 - NU)) * DEPTH;
    (FRICTION * moved.0.normal_force(DEPTH).0, sliding)
}

/// The contact came to its depth from first touch at any depth: where its grid is best, where it is worst, and between.
fn touched_at() -> impl Iterator<Item = f64> {
    (0..8).map(|k| DEPTH / 2f64.powf(k as f64 / 6.0))
}

#[test]
fn first_loading_is_the_curve_of_cattaneo_and_mindlin() {
    let mut worst: f64 = 0.0;
    for first in touched_at() {
        let mut moved = Moved::new("hertz 1e6 0.3", Symmetric2::new(1.0, 0.0, 1.0));
        let (limit, sliding) = scales(&moved);
        moved.by(first, NONE);
        moved.by(DEPTH, NONE);
        let steps = 200;
        for k in 1..=steps {
            let t = moved.by(
                DEPTH,
                Vector2::new(0.6, 0.8) * (1.5 * sliding / steps as f64),
            );
            let s = 1.5 * k as f64 / steps as f64;
            let got = -(t.force.dot(Vector2::new(0.6, 0.8))) / limit;
            worst = worst.max((got - cattaneo_mindlin(s)).abs());
            assert!(got <= 1.0 + 1e-14);
            if s > 1.0 + 1e-6 {
                assert!((got - 1.0).abs() < 1e-13, "{s}: {got}");
            }
        }
    }
    println!("first loading off by {worst:.4} of the limit");
    assert!(worst < 0.011 && worst > 1e-4, "{worst}");
}

/// Out, back and out again below sliding: each branch is twice the curve of first loading at half the way.
#[test]
fn a_cycle_has_the_loop_of_mindlin_and_deresiewicz() {
    let mut worst: f64 = 0.0;
    for first in touched_at() {
        for amplitude in [0.3, 0.6, 0.9] {
            let mut moved = Moved::new("hertz 1e6 0.3", Symmetric2::new(1.0, 0.0, 1.0));
            let (limit, sliding) = scales(&moved);
            moved.by(first, NONE);
            moved.by(DEPTH, NONE);
            let steps = 400;
            let direction = Vector2::new(-0.8, 0.6);
            let mut go = |from: f64, to: f64, branch: &dyn Fn(f64) -> f64| {
                let before = moved.0.work;
                for k in 1..=steps {
                    let s = from + (to - from) * k as f64 / steps as f64;
                    let step = direction * ((to - from) * sliding / steps as f64);
                    let got = -(moved.by(DEPTH, step).force.dot(direction)) / limit;
                    worst = worst.max((got - branch(s)).abs());
                }
                moved.0.work - before
            };
            let a = amplitude;
            let top = cattaneo_mindlin(a);
            go(0.0, a, &cattaneo_mindlin);
            let down = |s: f64| top - 2.0 * cattaneo_mindlin(0.5 * (a - s));
            let up = |s: f64| -top + 2.0 * cattaneo_mindlin(0.5 * (a + s));
            let lost = go(a, -a, &down) + go(-a, a, &up);
            let integral = |of: &dyn Fn(f64) -> f64| {
                (0..4000)
                    .map(|k| of(-a + 2.0 * a * (k as f64 + 0.5) / 4000.0))
                    .sum::<f64>()
                    * (2.0 * a / 4000.0)
            };
            let wanted = (integral(&up) - integral(&down)) * limit * sliding;
            // Near the begin of slip one element slides, or none.
            let allowed = if a < 0.5 { 0.29 } else { 0.08 };
            assert!(
                (lost / wanted - 1.0).abs() < allowed,
                "{a}: {lost} {wanted}"
            );
            println!(
                "touched at {:.2}, amplitude {a}: lost {:.4} of what is to be lost",
                first / DEPTH,
                lost / wanted
            );
        }
    }
    println!("branches off by {worst:.4} of the limit");
    assert!(worst < 0.018, "{worst}");
}

/// Whatever is done to it, a contact gives back no more than was put in.
#[test]
fn no_history_gives_work() {
    let mut stream = Stream::new(8);
    let mut least = f64::INFINITY;
    for number in 0..60 {
        let ratio = stream.log_uniform(1.0, 100.0);
        let words = ["hertz 1e6 0.3", "nfd 1e6 0.3 30 20"][number % 2];
        let mut moved = Moved::new(words, Symmetric2::new(1.0, 0.0, ratio));
        let (limit, sliding) = scales(&moved);
        let mut depth = DEPTH;
        moved.by(depth, NONE);
        for step in 0..400 {
            if step % 2 == 0 {
                // The work of a change of penetration is normal.
                depth = (depth * stream.log_uniform(0.5, 2.0)).clamp(1e-4 * DEPTH, 4.0 * DEPTH);
                if step % 50 == 0 {
                    let turn = stream.uniform(0.0, 3.0);
                    let (sin, cos) = turn.sin_cos();
                    moved.0.curvature = Symmetric2::new(
                        cos * cos + ratio * sin * sin,
                        (1.0 - ratio) * sin * cos,
                        sin * sin + ratio * cos * cos,
                    );
                }
                moved.by(depth, NONE);
            } else {
                let by = Vector2::new(stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0));
                moved.by(depth, by * (0.5 * sliding));
            }
            assert!(moved.0.energy >= 0.0);
            least = least.min((moved.0.work - moved.0.energy) / (limit * sliding));
            let of = moved.0.springs;
            let carries: f64 = of.forces.iter().map(|f| f.dot(*f).sqrt()).sum();
            let now = FRICTION * moved.0.normal_force(depth).0;
            assert!(carries <= now * (1.0 + 1e-12), "{carries} {now}");
            assert!(of.reference >= of.penetration);
        }
    }
    println!("least of work less energy {least:.1e}");
    assert!(least > -1e-12, "{least:e}");
}

#[test]
fn nothing_changes_where_no_time_passes() {
    for words in ["hertz 1e6 0.3", "nfd 1e6 0.3 30 20"] {
        let mut moved = Moved::new(words, Symmetric2::new(80.0, 10.0, 300.0));
        let (_, sliding) = scales(&moved);
        let velocity = Vector2::new(0.3, 0.1);
        for k in 0..40 {
            let by = Vector2::new(0.05, 0.02) * (sliding * if k < 25 { 1.0 } else { -1.0 });
            let depth = DEPTH * (1.0 + 0.02 * f64::from(k));
            let before = (moved.0.springs, moved.0.memory, moved.0.energy);
            let t = moved.evaluate(depth, by, velocity, true);
            (moved.0.memory, moved.0.energy) = (t.memory, t.elastic_energy);
            let now = moved.0.springs;
            let again = moved.evaluate(depth, NONE, velocity, false);
            let apart = again.force - t.force;
            let size = FRICTION * moved.0.normal_force(depth).0;
            assert!(
                apart.dot(apart).sqrt() < 1e-13 * size,
                "step {k}: {apart:?}"
            );
            assert_eq!(again.memory, t.memory);
            assert_eq!(again.elastic_energy, t.elastic_energy);
            assert_eq!(moved.0.springs.forces, now.forces);
            assert!(before.0.forces != now.forces);
        }
    }
}

/// A contact that shrank until few elements are left divides them: a cycle at the small penetration has its loop again.
#[test]
fn a_contact_that_shrank_has_a_loop_of_its_own() {
    let mut moved = Moved::new("hertz 1e6 0.3", Symmetric2::new(1.0, 0.0, 1.0));
    let (limit, sliding) = scales(&moved);
    moved.by(1e3 * DEPTH, NONE);
    for k in (0..60).rev() {
        moved.by(DEPTH * 1e3f64.powf(f64::from(k) / 59.0), NONE);
    }
    assert!(moved.0.springs.reference < 6.4 * DEPTH);
    let mut worst: f64 = 0.0;
    for k in 1..=100 {
        let t = moved.by(DEPTH, Vector2::new(0.01 * sliding, 0.0));
        worst = worst.max((-t.force.u / limit - cattaneo_mindlin(0.01 * f64::from(k))).abs());
    }
    println!("off by {worst:.4} of the limit");
    assert!(worst < 0.03, "{worst}");
}

#[test]
fn it_goes_with_tfd_alone() {
    for words in ["mindlin 0.5", "none"] {
        let words: Vec<&str> = ["hertz", "1e6", "0.3", "tangential"]
            .into_iter()
            .chain(words.split(' '))
            .chain(["displacement", "hysteretic"])
            .collect();
        let message = parse(&words).unwrap_err().to_string();
        assert!(
            message.contains("displacement hysteretic goes with 'tangential tfd'"),
            "{message}"
        );
    }
    let law = pair_law("hertz 1e6 0.3 tangential tfd 0.5 displacement hysteretic");
    assert!(law.describe().contains("displacement hysteretic"));
    assert!(!law.can_create_energy());
}

/// Without slip each element has gone the same way, so that it holds its share of the stiffness `c sqrt(d)`: between two edges the
/// difference of their roots.
fn assert_shares(moved: &Moved, depth: f64, per_root: f64, what: &str) {
    let of = &moved.0.springs;
    let root = |k: usize| {
        let edge = of.reference * (k as f64 / 8.0).powf(4.0 / 3.0);
        edge.min(depth).sqrt()
    };
    for (k, force) in of.forces.iter().enumerate() {
        let wanted = per_root * (root(k + 1).max(root(k)) - root(k));
        // The last edge is the contact's own.
        let found = force.u;
        assert!(
            (found - wanted).abs() < 1e-9 * per_root * depth.sqrt() && force.v == 0.0,
            "{what}, element {k}: {found:e} {wanted:e}"
        );
    }
}

/// A contact that shrinks, slowly or at once, gives up what the elements lose that leave it, and divides the others by their stiffness.
#[test]
fn a_contact_that_shrinks_without_slip_keeps_its_displacement() {
    for shrinks_to in [0.99, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 1e-3] {
        for steps in [1, 3, 40] {
            let mut moved = Moved::new("hertz 1e6 0.3", Symmetric2::new(1.0, 0.0, 1.0));
            let (_, sliding) = scales(&moved);
            moved.by(DEPTH, NONE);
            let way = 1e-9 * sliding;
            let force = -moved.by(DEPTH, Vector2::new(way, 0.0)).force.u;
            let per_root = force / DEPTH.sqrt();
            assert_shares(&moved, DEPTH, per_root, "loaded");
            let mut depth = DEPTH;
            for k in 1..=steps {
                depth = DEPTH * f64::powf(shrinks_to, f64::from(k) / f64::from(steps));
                moved.by(depth, NONE);
            }
            let what = format!("to {shrinks_to} in {steps} steps");
            assert_shares(&moved, depth, per_root, &what);
            let t = moved.by(depth, NONE);
            let wanted = 0.5 * per_root * depth.sqrt() * way;
            assert!((t.elastic_energy / wanted - 1.0).abs() < 1e-6, "{what}");
            // Divided as often as one step may, until more than two elements carry.
            if shrinks_to > 0.02 || steps == 40 {
                assert!(moved.0.springs.reference < 6.4 * depth, "{what}");
            }
        }
    }
}

/// A contact that grows keeps the force of each element; two become one where the contact outgrows the grid.
#[test]
fn a_contact_that_grows_keeps_its_forces() {
    for grows_to in [1.01, 1.5, 2.0, 5.0, 12.0, 100.0] {
        for steps in [1, 3, 40] {
            let mut moved = Moved::new("hertz 1e6 0.3", Symmetric2::new(1.0, 0.0, 1.0));
            let (_, sliding) = scales(&moved);
            moved.by(DEPTH, NONE);
            moved.by(0.7 * DEPTH, NONE);
            let way = 1e-9 * sliding;
            let force = -moved.by(0.7 * DEPTH, Vector2::new(way, 0.0)).force.u;
            let per_root = force / (0.7 * DEPTH).sqrt();
            let mut depth = DEPTH;
            for k in 1..=steps {
                depth = DEPTH * f64::powf(grows_to, f64::from(k) / f64::from(steps));
                let t = moved.by(depth, NONE);
                assert!((-t.force.u / force - 1.0).abs() < 1e-12);
            }
            let of = &moved.0.springs;
            let mut edge_before: f64 = 0.0;
            for (k, found) in of.forces.iter().enumerate() {
                let edge = of.reference * ((k + 1) as f64 / 8.0).powf(4.0 / 3.0);
                let [low, high] = [edge_before, edge].map(|e| e.min(0.7 * DEPTH).sqrt());
                let wanted = per_root * (high - low);
                assert!(
                    (found.u - wanted).abs() < 1e-9 * force,
                    "to {grows_to} in {steps}, element {k}: {:e} {wanted:e}",
                    found.u
                );
                edge_before = edge;
            }
            assert!(of.reference >= depth);
        }
    }
}

/// The force without its viscous part has its sign and what the springs hold.
#[test]
fn the_elastic_force_is_that_of_the_springs() {
    for words in ["hertz 1e6 0.3", "nfd 1e6 0.3 30 20"] {
        let mut moved = Moved::new(words, Symmetric2::new(1.0, 0.0, 1.0));
        let (limit, sliding) = scales(&moved);
        moved.by(DEPTH, NONE);
        let by = Vector2::new(0.1 * sliding, 0.0);
        let t = moved.evaluate(DEPTH, by, Vector2::new(1e-6, 0.0), true);
        let held: f64 = moved.0.springs.forces.iter().map(|f| f.u).sum();
        assert!(held > 0.1 * limit && (t.elastic_force.u / -held - 1.0).abs() < 1e-14);
        let viscous = t.force.u - t.elastic_force.u;
        assert!(if words.starts_with("nfd") {
            viscous < 0.0
        } else {
            viscous == 0.0
        });
    }
}

/// A run that begins evaluates the contact of the last step once more, as deep but for rounding: the same elements stick, however narrow the one at
/// the rim of a contact that recedes.
#[test]
fn without_time_the_same_elements_stick() {
    let mut stream = Stream::new(27);
    let mut worst = 0.0f64;
    for _ in 0..4000 {
        let mut moved = Moved::new("nfd 1e6 0.3 2e2 2e2", Symmetric2::new(1.0, 0.2, 3.0));
        let limit = scales(&moved).0;
        let way = |stream: &mut Stream, size: f64| {
            Vector2::new(stream.uniform(-size, size), stream.uniform(-size, size))
        };
        let deepest = DEPTH * stream.uniform(0.4, 1.0);
        for part in [0.5, 0.8, 1.0] {
            let by = way(&mut stream, 0.2 * DEPTH);
            moved.by(deepest * part, by);
        }
        // Where the edge of the seventh of eight elements, (6/8)^(2/3), is almost the rim.
        let edge = 0.75f64.powf(4.0 / 3.0) * moved.0.springs.reference;
        let depth = edge * (1.0 + 10f64.powf(stream.uniform(-7.0, -1.0)));
        let (by, velocity) = (way(&mut stream, 0.05 * DEPTH), way(&mut stream, 10.0));
        let t = moved.evaluate(depth, by, velocity, true);
        (moved.0.memory, moved.0.energy) = (t.memory, t.elastic_energy);
        let depth = depth * (1.0 + stream.uniform(-2e-13, 2e-13));
        let again = moved.evaluate(depth, NONE, velocity, false);
        let apart = t.force + again.force * -1.0;
        worst = worst.max(apart.dot(apart).sqrt() / limit);
    }
    println!("apart by {worst:.1e} of Coulomb's limit");
    assert!(worst < 1e-10, "{worst:e}");
}
