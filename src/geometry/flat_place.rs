// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is a surface of triangles nothing but a plane within a ball? What is in the ball then touches that plane, in one place or not at all, and
//! no triangle has to be looked at.

use super::triangle::{Near, Triangle, MEETING};
use super::triangle_places::INSIDE;
use crate::real::Real;
use crate::vector::Vector3;

/// Sine of the angle between two triangles up to which they are of one plane here. More than rounding of corners that are 1000 triangles
/// away from the origin, and less than what a force shows. Triangles at larger angles, up to that at which the search itself takes them for
/// one plane, are left to the search.
const SAME_PLANE: f64 = 1e-12;

/// By how much of its radius a body looks beyond the ball that contains it ([`super::triangles::TriangleSearch::touch`]).
const LOOKS_BEYOND: f64 = 2.0 * INSIDE * MEETING;

/// Most triangles that are looked at each beside each other.
const MOST: usize = 128;

/// A ball in which a surface of triangles is a plane.
#[derive(Clone, Copy, Debug)]
pub struct FlatPlace<T: Real = f64> {
    centre: Vector3<T>,
    radius: T,
    /// Unit normal of the plane, that of a triangle, on either side.
    pub normal: Vector3<T>,
    /// Where the ball's centre lies above the plane, along the normal.
    height: T,
}

impl<T: Real> FlatPlace<T> {
    /// From its eight numbers, or those of one in each lane.
    #[inline(always)]
    pub fn of([x, y, z, radius, a, b, c, height]: [T; 8]) -> Self {
        FlatPlace {
            centre: Vector3::new(x, y, z),
            radius,
            normal: Vector3::new(a, b, c),
            height,
        }
    }

    /// How far the centre of a ball of this radius may be from that of the place for this to have what a body within the ball touches; less than 0
    /// where there is no room.
    #[inline(always)]
    pub fn room(&self, radius: T) -> T {
        self.radius - radius * (1.0 + LOOKS_BEYOND)
    }

    /// From the centre of the place to that of a ball.
    #[inline(always)]
    pub fn way_to(&self, centre: Vector3<T>) -> Vector3<T> {
        centre - self.centre
    }

    /// Height above the plane at the end of a way from the centre of the place.
    #[inline(always)]
    pub fn height_after(&self, way: Vector3<T>) -> T {
        self.normal.dot(way) + self.height
    }
}

impl FlatPlace {
    /// The numbers of a place that has nothing.
    pub(crate) const NONE: [f64; 8] = [0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0];

    /// Its numbers, as [`FlatPlace::of`] takes them.
    pub fn numbers(&self) -> [f64; 8] {
        let (c, n) = (self.centre, self.normal);
        [c.x, c.y, c.z, self.radius, n.x, n.y, n.z, self.height]
    }

    /// A ball about `centre`, if the surface is a plane there. `triangles` are at least all of those that come into it; `memory` is
    /// overwritten.
    pub fn find(
        centre: Vector3,
        radius: f64,
        triangles: impl ExactSizeIterator<Item = Triangle>,
        memory: &mut Vec<Near>,
    ) -> Option<FlatPlace> {
        memory.clear();
        if triangles.len() > MOST {
            return None;
        }
        for (index, triangle) in triangles.enumerate() {
            // What is too narrow for a small body may be no sliver for a large one: the search finds out.
            let near = Near::new(index, &triangle, centre, MEETING * radius)?;
            if near.has(Vector3::ZERO, radius) {
                memory.push(near);
            }
        }
        let near = &memory[..];
        let first = near.first()?;
        let is_plane = near
            .iter()
            .all(|t| t.is_in_plane_of(first, radius, SAME_PLANE));
        if !is_plane {
            return None;
        }
        // No border comes into the ball: so the plane is covered there as a whole, or nowhere.
        let is_joined = |t: &Near, k: usize| {
            let (a, b) = (t.corners[k], t.corners[(k + 1) % 3]);
            !comes_within(a, b, radius) || near.iter().any(|q| t.is_continued_by(q, a, b))
        };
        if !near.iter().all(|t| (0..3).all(|k| is_joined(t, k))) {
            return None;
        }
        let covers = |t: &&Near| t.has(t.normal * -t.distance, 1e-9 * radius);
        let stands_for_all = near.iter().find(covers)?;
        Some(FlatPlace {
            centre,
            radius,
            normal: stands_for_all.normal,
            height: -stands_for_all.normal.dot(stands_for_all.corners[0]),
        })
    }

    /// The height of the centre of another ball above the plane, if what a body within the ball touches is in this one.
    #[inline(always)]
    pub fn height_of(&self, centre: Vector3, radius: f64) -> Option<f64> {
        let (room, way) = (self.room(radius), self.way_to(centre));
        let has = room > 0.0 && way.norm_squared() < room * room;
        has.then(|| self.height_after(way))
    }
}

/// Whether a way between two points comes nearer to the origin than this.
fn comes_within(a: Vector3, b: Vector3, radius: f64) -> bool {
    let way = b - a;
    let place = (-a.dot(way) / way.norm_squared()).clamp(0.0, 1.0);
    // A way of no length is looked at, too.
    !((a + way * place).norm_squared() > radius * radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangles::{Feature, TriangleSearch};
    use crate::geometry::Ellipsoid;

    fn sheet(cells: usize, half: f64, height: impl Fn(f64, f64) -> f64) -> Vec<Triangle> {
        let at = |i: usize, j: usize| {
            let x = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
            Vector3::new(x(i), x(j), height(x(i), x(j)))
        };
        let mut all = vec![];
        for i in 0..cells {
            for j in 0..cells {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                all.push([a, b, c]);
                all.push([a, c, d]);
            }
        }
        all
    }

    /// Numbers between two, the same in every run.
    fn numbers() -> impl FnMut(f64, f64) -> f64 {
        let mut state = 11u64;
        move |low, high| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// A body belongs to the place of a ball of radius 1 where its own ball, and what is looked at around it, lies within.
    #[test]
    fn a_place_has_what_lies_within_its_ball() {
        let place = FlatPlace {
            centre: Vector3::new(3.0, -2.0, 5.0),
            radius: 1.0,
            normal: Vector3::new(0.0, 0.0, 1.0),
            height: 5.0,
        };
        let direction = Vector3::new(0.36, -0.48, 0.8);
        for radius in [0.01, 0.3, 0.7] {
            let room = 1.0 - radius * (1.0 + LOOKS_BEYOND);
            for (off, has) in [(0.0, true), (0.99, true), (1.01, false), (3.0, false)] {
                let centre = place.centre + direction * (off * room);
                let height = place.height_of(centre, radius);
                assert_eq!(height.is_some(), has, "{radius}, {off}");
                assert!(height.is_none_or(|h| (h - centre.z).abs() < 1e-14));
            }
        }
        for off in [0.0, 0.1, 0.5, 5.0] {
            let centre = place.centre + direction * off;
            assert!(place.height_of(centre, 1.5).is_none());
        }
        let none = FlatPlace::of(FlatPlace::NONE);
        assert!(none.height_of(Vector3::ZERO, 0.0).is_none());
        let again = FlatPlace::of(place.numbers());
        assert_eq!(again.height_of(place.centre, 0.1), Some(5.0));
    }

    /// Bodies in flat places touch the plane where the search finds them to touch the triangles, and nowhere else: sheets with and without
    /// holes, inclined ones, with a fold, two of them close to one another.
    #[test]
    fn bodies_in_flat_places_touch_what_the_search_finds() {
        let mut uniform = numbers();
        let tilted = |x: f64, y: f64| 0.3 * x - 0.7 * y;
        let sheets = [
            (sheet(1, 3.0, |_, _| 0.0), 0.0),
            (sheet(6, 1.0, |_, _| 0.0), 0.0),
            (sheet(9, 1.0, tilted), 0.0),
            (sheet(9, 1.0, tilted), 0.05),
            (sheet(8, 1.0, |x, _| x.abs()), 0.0),
            (
                [sheet(4, 1.0, |_, _| 0.0), sheet(4, 1.0, |_, _| 0.1)].concat(),
                0.0,
            ),
        ];
        let (mut flat, mut touching, mut not_flat, mut deep) = (0, 0, 0, 0);
        let mut memory = vec![];
        let mut search = TriangleSearch::default();
        for (whole, holes) in sheets {
            for _ in 0..4000 {
                let mut sheet = whole.clone();
                sheet.retain(|_| uniform(0.0, 1.0) >= holes);
                let axes = [0; 3].map(|_| uniform(0.03, 0.25));
                let q = [0; 4].map(|_| uniform(-1.0, 1.0));
                let body = Ellipsoid::new(axes, q).unwrap();
                let triangle = sheet[uniform(0.0, sheet.len() as f64) as usize];
                let on_it = (triangle[0] + triangle[1] + triangle[2]) * (1.0 / 3.0);
                let reach = body.bounding_radius();
                let centre = on_it + Vector3::new(0.0, 0.0, uniform(-1.2, 1.2) * reach);
                let place_at = centre + Vector3::new(uniform(-0.1, 0.1) * reach, 0.0, 0.0);
                let place =
                    FlatPlace::find(place_at, 1.25 * reach, sheet.iter().copied(), &mut memory);
                let of_place = |p: FlatPlace| Some((p.normal, p.height_of(centre, reach)?));
                let Some((mut normal, mut height)) = place.and_then(of_place) else {
                    not_flat += 1;
                    continue;
                };
                flat += 1;
                if height < 0.0 {
                    (normal, height) = (-normal, -height);
                }
                let support = body.support(-normal);
                let penetration = support.h - height;
                search.touch(&body, centre, &sheet);
                let found = search.contacts();
                // The search looks into the box about the body, which the foot of one leaves that is deeper in an inclined plane than thick.
                let is_deep = penetration > body.smallest_semi_axis() && found.is_empty();
                if penetration.abs() < 1e-13 || is_deep {
                    deep += usize::from(is_deep);
                    continue;
                }
                assert_eq!(
                    found.len(),
                    usize::from(penetration > 0.0),
                    "{penetration:e} {found:?}"
                );
                let [found] = found else { continue };
                touching += 1;
                assert_eq!(found.feature, Feature::Face);
                assert_eq!(found.share.value, 1.0);
                assert!((found.normal - normal).norm() < 1e-13);
                assert!((found.penetration - penetration).abs() < 1e-14);
                let foot = centre + support.point + normal * penetration;
                assert!((found.point - foot).norm() < 1e-12);
            }
        }
        println!("{flat} flat places, {touching} contacts in them, {not_flat} others, {deep} deep");
        assert!(touching > 3000 && flat > touching + 500 && not_flat > 5000 && deep < 300);
    }

    /// A place at whose rim a border is, a fold, or another plane, is none.
    #[test]
    fn what_comes_into_the_ball_counts() {
        let find = |sheet: Vec<Triangle>, x: f64| {
            let centre = Vector3::new(x, 0.1, 0.2);
            FlatPlace::find(centre, 0.5, sheet.iter().copied(), &mut vec![]).is_some()
        };
        // The plane's disc in the ball has the radius sqrt(0.25 - 0.04).
        let reach = (0.25f64 - 0.04).sqrt();
        let flat = || sheet(4, 1.0, |_, _| 0.0);
        assert!(find(flat(), 1.0 - reach - 1e-6));
        assert!(!find(flat(), 1.0 - reach + 1e-6));
        let folded = || sheet(4, 1.0, |x, _| 0.01 * (x - 0.5).max(0.0));
        assert!(find(folded(), 0.5 - reach - 1e-6));
        assert!(!find(folded(), 0.5 - reach + 1e-3));
        // A hole as large as one triangle, a plane beside, a corner that touches from above.
        let mut holed = flat();
        holed.remove(20);
        assert!(!find(holed, 0.0));
        let p = Vector3::new;
        let above = |z: f64| [p(0.0, 0.0, z), p(0.1, 0.0, z + 1.0), p(0.0, 0.1, z + 1.0)];
        assert!(!find([flat(), vec![above(0.65)]].concat(), 0.0));
        assert!(find([flat(), vec![above(0.75)]].concat(), 0.0));
        // Nothing there, and a sliver.
        assert!(!find(vec![above(2.0)], 0.0));
        let sliver = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.5, 1e-9, 0.0)];
        assert!(!find([flat(), vec![sliver]].concat(), 0.0));
    }
}
