// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cylinders and cones as walls, with their ends.

#[cfg(feature = "std")]
use super::deep_in_solid;
#[cfg(feature = "std")]
use super::plane::flat;
use super::plane::{flat_along, PlaneWall};
use super::rim::Rim;
use super::shape::{Ball, ConeSide, Grain, Side};
#[cfg(feature = "std")]
use super::shape::{Block, End, Found, Search, Shape, ShapeInLanes, ShapeParameters};
use super::tip::Tip;
#[cfg(feature = "std")]
use crate::contact::ranges::LARGEST_COORDINATE;
use crate::contact::staged::WallSurface;
#[cfg(feature = "std")]
use crate::geometry::cone::Cone;
use crate::geometry::cone::{touch_cone, ConeContact};
#[cfg(feature = "std")]
use crate::geometry::ellipsoid::LEAST_SEMI_AXIS;
#[cfg(feature = "std")]
use crate::message::Number;
#[cfg(feature = "std")]
use crate::vector::Tangent;
use crate::vector::Vector3;

/// The side of a cylinder or a cone.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ConeWall {
    surface: ConeSide,
    /// [`Cone::stretch`].
    stretch: f64,
}

/// Relative error of two depths of one contact that were computed in two ways: ten times the rounding of a quadratic form that loses the
/// square of the aspect ratio, at most 1e6, in digits.
const ROUNDING: f64 = 1e-9;

/// Contacts with the surface of one particle that are remembered: a needle touches with both of its ends.
#[cfg(feature = "std")]
const REMEMBERED: usize = 2;

#[cfg(feature = "std")]
pub(super) fn add_cylinder(
    p: &ShapeParameters,
    parts: &mut Vec<Box<dyn Shape>>,
) -> Result<(), String> {
    let radius = p.radii[0];
    require_order("cylinder", p)?;
    if !(LEAST_SEMI_AXIS..=LARGEST_COORDINATE).contains(&radius) {
        return Err(format!(
            "cylinder: radius = {} must be greater than 0, from {LEAST_SEMI_AXIS:e} to {LARGEST_COORDINATE:e}",
            Number(radius)
        ));
    }
    let of_both_ends = ShapeParameters {
        radii: [radius; 2],
        ..*p
    };
    add(
        Cone::cylinder(p.point, p.axis, radius),
        &of_both_ends,
        parts,
    )
}

#[cfg(feature = "std")]
pub(super) fn add_cone(p: &ShapeParameters, parts: &mut Vec<Box<dyn Shape>>) -> Result<(), String> {
    let [low, high] = p.bounds;
    if !(low.is_finite() && high.is_finite()) {
        return Err("cone: both bounds must be finite".into());
    }
    require_order("cone", p)?;
    let in_range = |r: f64| (0.0..=LARGEST_COORDINATE).contains(&r);
    if !(p.radii.iter().all(|r| in_range(*r)) && p.radii[0] + p.radii[1] >= LEAST_SEMI_AXIS) {
        return Err(format!(
            "cone: radii {} and {} must be 0 or greater, at most {LARGEST_COORDINATE:e}, and not both 0",
            Number(p.radii[0]),
            Number(p.radii[1])
        ));
    }
    let slope = (p.radii[1] - p.radii[0]) / (high - low);
    // The cone's point is where the radius is the greater, so that it is not the tip.
    let at = if slope < 0.0 { low } else { high };
    let cone = Cone {
        slope,
        ..Cone::cylinder(p.point + p.axis * at, p.axis, p.radii[0].max(p.radii[1]))
    };
    let from_there = ShapeParameters {
        point: cone.point,
        bounds: [low - at, high - at],
        ..*p
    };
    add(cone, &from_there, parts)
}

/// With the bounds as they were given, before they are measured from the cone's point.
#[cfg(feature = "std")]
fn require_order(name: &str, p: &ShapeParameters) -> Result<(), String> {
    let [low, high] = p.bounds;
    if low < high {
        return Ok(());
    }
    Err(format!(
        "{name}: the lower bound {} must be below the upper one {}",
        Number(low),
        Number(high)
    ))
}

/// With the bounds from the cone's point, and the radii there.
#[cfg(feature = "std")]
fn add(cone: Cone, p: &ShapeParameters, parts: &mut Vec<Box<dyn Shape>>) -> Result<(), String> {
    let [low, high] = p.bounds;
    for (bound, end) in p.bounds.iter().zip(p.ends) {
        if end != End::None && !(bound.abs() <= LARGEST_COORDINATE) {
            return Err(format!(
                "cylinder or cone: it cannot end at {}",
                Number(*bound)
            ));
        }
    }
    // From within, a closed end is a concave corner: what lies behind either surface counts, wherever the other one is.
    let goes_on = |k: usize| p.side == Side::Inside && p.ends[k] == End::Closed;
    let side = ConeWall {
        surface: ConeSide {
            cone,
            bounds: [
                if goes_on(0) { f64::NEG_INFINITY } else { low },
                if goes_on(1) { f64::INFINITY } else { high },
            ],
            side: p.side,
        },
        stretch: cone.stretch(),
    };
    let mut caps = vec![];
    let mut edges = vec![];
    let mut end_in = |centre: Vector3, radius: f64, out: f64, surfaces: [[f64; 2]; 2]| {
        edges.push(if radius > 0.0 {
            Edge::Rim(Rim::new(centre, cone.axis, radius, surfaces))
        } else {
            Edge::Tip(Tip::new(centre, cone.axis * out, cone.slope.abs()))
        });
    };
    for (k, (bound, out)) in [(low, -1.0), (high, 1.0)].into_iter().enumerate() {
        let centre = cone.point + cone.axis * bound;
        let radius = p.radii[k];
        // along the surface, from the end inwards, in the plane of axis and radius
        let inwards = [-out * cone.slope, -out];
        match p.ends[k] {
            End::None => {}
            End::Open => end_in(centre, radius, out, [inwards; 2]),
            End::Closed if p.side == Side::Inside => {
                // The plane goes on beyond the edge, which is concave.
                caps.push(PlaneWall::disc(
                    centre,
                    cone.axis * -out,
                    f64::INFINITY,
                    false,
                ));
            }
            End::Closed => {
                let both_sides = p.side == Side::OfCentre;
                let normal = cone.axis * out;
                caps.push(PlaneWall::disc(centre, normal, radius, both_sides));
                end_in(centre, radius, out, [inwards, [-1.0, 0.0]]);
            }
        }
    }
    // From without each closed end has an edge.
    if let (Side::Outside, Some(cap), Some(edge)) = (p.side, caps.first(), edges.first()) {
        parts.push(Box::new(ConvexSolid {
            side,
            caps: [*cap, *caps.last().unwrap_or(cap)],
            edges: [*edge, *edges.last().unwrap_or(edge)],
            cap_count: caps.len() as u32,
            edge_count: edges.len() as u32,
        }));
        return Ok(());
    }
    parts.push(Box::new(side));
    for cap in caps {
        parts.push(Box::new(cap));
    }
    for edge in edges {
        parts.push(match edge {
            Edge::Rim(rim) => Box::new(rim),
            Edge::Tip(tip) => Box::new(tip),
        });
    }
    Ok(())
}

/// What a side ends in: a rim, or the tip that it has become.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub enum Edge {
    /// A rim.
    Rim(Rim),
    /// A tip.
    Tip(Tip),
}

impl Edge {
    /// Calls `found` with the depth of each place of the edge where the body is deepest or, with a depth below 0, nearest to it.
    fn places(&self, grain: &Grain<'_>, mut found: impl FnMut(f64, &WallSurface)) {
        match self {
            Edge::Rim(rim) => {
                // Where a body is apart from the edge, the nearest place may be beyond its reach, by less than the depth of a surface.
                let reach = 1.5 * grain.body.bounding_radius();
                rim.places(grain, reach, f64::INFINITY, |place| {
                    found(place.depth, &rim.surface_at(grain, place));
                });
            }
            Edge::Tip(tip) => {
                if let Some((depth, surface)) = tip.place(grain) {
                    found(depth, &surface);
                }
            }
        }
    }
}

/// A solid from without: a body touches it if it reaches behind all of its surfaces, and the one behind which it is least
/// deep acts.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ConvexSolid {
    side: ConeWall,
    /// So many of them.
    caps: [PlaneWall; 2],
    edges: [Edge; 2],
    cap_count: u32,
    edge_count: u32,
}

impl ConvexSolid {
    fn caps(&self) -> &[PlaneWall] {
        &self.caps[..self.cap_count as usize]
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        self.side.is_near(ball) && self.caps().iter().all(|cap| cap.is_near(ball))
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        let Grain { body, centre, .. } = *grain;
        let depth_at =
            |normal: Vector3, point: Vector3| body.support(-normal).h - normal.dot(centre - point);
        let mut shallowest =
            (self.caps().iter().map(|cap| cap.depth(grain))).fold(f64::INFINITY, f64::min);
        if !(shallowest > 0.0) {
            return;
        }
        let mut is_behind_side = false;
        let mut least: Option<(f64, WallSurface)> = None;
        let mut offer = |s: &WallSurface, depth: f64| {
            if depth > 0.0 && least.is_none_or(|(other, _)| depth < other) {
                least = Some((depth, *s));
            }
        };
        touch_cone(body, centre, &self.side.surface.cone, false, |c| {
            is_behind_side = true;
            let depth = depth_at(c.normal, c.point);
            shallowest = shallowest.min(depth);
            if let Some(surface) = self.side.surface_at(&c, false) {
                offer(&surface, depth);
            }
        });
        if !is_behind_side {
            return;
        }
        for cap in self.caps() {
            cap.contacts(grain, |s| offer(s, depth_at(s.normal, s.point)));
        }
        for edge in &self.edges[..self.edge_count as usize] {
            edge.places(grain, |depth, s| {
                shallowest = shallowest.min(depth);
                offer(s, depth);
            });
        }
        // A body beside the rim may reach behind each surface by itself and be apart from the solid, by a plane through the rim. Or the
        // surface where it would be least deep has no contact, and a deeper one, such as that of the far end or of one that overhangs,
        // is none either.
        if let Some((_, surface)) =
            least.filter(|(depth, _)| *depth <= shallowest * (1.0 + ROUNDING))
        {
            found(&surface);
        }
    }
}

#[cfg(feature = "std")]
impl Shape for ConvexSolid {
    fn remembered(&self) -> usize {
        1
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        self.side.may_touch_block(block) && self.caps().iter().all(|cap| cap.may_touch_block(block))
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        let Grain { body, centre, .. } = *grain;
        let mut known = None;
        self.contacts(grain, |s| {
            let depth = body.support(-s.normal).h - s.normal.dot(centre - s.point);
            known = Some((depth, *s));
        });
        // A surface that acts may be deeper than the one that does not know the body any more.
        if known.is_none_or(|(depth, _)| depth > deep_in_solid::DEEP * body.smallest_semi_axis()) {
            if let Some((depth, surface)) = self.deep(grain) {
                if known.is_none_or(|(other, _)| depth < other * (1.0 - ROUNDING)) {
                    known = Some((depth, surface));
                }
            }
        }
        if let Some((_, surface)) = known {
            found(&surface, 0);
        }
    }
}

/// Where a body is deep in the solid.
#[cfg(feature = "std")]
pub(super) enum SolidPlace {
    /// The flat end.
    Cap,
    /// The curved side.
    Side(ConeContact),
    /// The edge at an end, and the direction of its radius there.
    Rim(deep_in_solid::Circle, Vector3),
    /// The point.
    Tip(Vector3),
}

#[cfg(feature = "std")]
impl ConvexSolid {
    /// The place of each end along the axis from the cone's point, and its radius; `None` for an end that is infinitely far.
    fn ends(&self) -> [Option<[f64; 2]>; 2] {
        let cone = &self.side.surface.cone;
        let mut ends = [None; 2];
        for edge in &self.edges[..self.edge_count as usize] {
            let (centre, radius) = match edge {
                Edge::Rim(rim) => rim.circle(),
                Edge::Tip(tip) => (tip.point(), 0.0),
            };
            let along = cone.axis.dot(centre - cone.point);
            let bounds = self.side.surface.bounds;
            let upper = (along - bounds[1]).abs() < (along - bounds[0]).abs();
            ends[usize::from(upper)] = Some([along, radius]);
        }
        ends
    }

    /// Whether all of its ends are closed.
    fn is_closed(&self) -> bool {
        let edges = &self.edges[..self.edge_count as usize];
        let tips = edges.iter().filter(|e| matches!(e, Edge::Tip(_))).count();
        let finite = self.side.surface.bounds.iter().filter(|b| b.is_finite());
        let finite = finite.count();
        tips + self.caps().len() == finite && edges.len() == finite
    }

    /// The shortest way out, which is the contact of a body that is so deep in it that no surface or edge by itself knows it.
    fn deep(&self, grain: &Grain<'_>) -> Option<(f64, WallSurface)> {
        if !self.is_closed() {
            return None;
        }
        let (normal, depth, place) = deep_in_solid::shortest_way_out(self, grain)?;
        let foot = grain.centre + grain.body.support(-normal).point + normal * depth;
        let surface = match place {
            SolidPlace::Cap => flat(foot, normal),
            SolidPlace::Side(c) => (self.side.surface_at(&c, false)).unwrap_or(flat(foot, normal)),
            SolidPlace::Rim(circle, radial) => {
                let out = normal.dot(radial);
                WallSurface {
                    direction: circle.axis.cross(radial),
                    curvatures: [out / circle.radius, 0.0],
                    turning_radii: [circle.radius / out, 0.0],
                    ..flat(circle.centre + radial * circle.radius, normal)
                }
            }
            SolidPlace::Tip(point) => WallSurface {
                turning_radii: [0.0; 2],
                ..flat(point, normal)
            },
        };
        Some((depth, surface))
    }
}

#[cfg(feature = "std")]
impl deep_in_solid::Convex for ConvexSolid {
    type Place = SolidPlace;

    fn farthest(&self, n: Vector3) -> Vector3 {
        let cone = &self.side.surface.cone;
        let along = cone.axis.dot(n);
        let across = n - cone.axis * along;
        let radial = across.direction().unwrap_or(Vector3::ZERO);
        let mut best = (f64::NEG_INFINITY, Vector3::ZERO);
        for (end, out) in self.ends().into_iter().zip([-1.0, 1.0]) {
            let Some([z, radius]) = end else {
                if along * out > 1e-12 {
                    return cone.axis * (out * f64::MAX);
                }
                continue;
            };
            let point = cone.axis * z + radial * radius;
            if point.dot(n) > best.0 {
                best = (point.dot(n), point);
            }
        }
        cone.point + best.1
    }

    /// By an edge; whoever asks knows that the body reaches behind side and ends.
    fn is_apart(&self, grain: &Grain<'_>) -> bool {
        let mut apart = false;
        for edge in &self.edges[..self.edge_count as usize] {
            edge.places(grain, |depth, _| apart |= depth <= 0.0);
        }
        apart
    }

    fn nearest(&self, p: Vector3) -> Option<Vector3> {
        let cone = &self.side.surface.cone;
        let offset = p - cone.point;
        let height = cone.axis.dot(offset);
        let [low, high] = self.ends();
        let low = low.map_or(f64::NEG_INFINITY, |[z, _]| z);
        let high = high.map_or(f64::INFINITY, |[z, _]| z);
        let z = height.clamp(low, high);
        let across = offset - cone.axis * height;
        let radius = cone.radius + cone.slope * z;
        let distance = across.norm();
        if z == height && distance <= radius {
            return None;
        }
        let share = if distance > radius {
            radius / distance
        } else {
            1.0
        };
        Some(cone.point + cone.axis * z + across * share)
    }

    fn offer_normals(&self, grain: &Grain<'_>, offer: &mut dyn FnMut(Vector3, SolidPlace)) -> bool {
        let cone = &self.side.surface.cone;
        let (c, s) = cone.normal_components();
        let mut is_behind_side = false;
        touch_cone(grain.body, grain.centre, cone, false, |contact| {
            is_behind_side = true;
            offer(contact.normal, SolidPlace::Side(contact));
        });
        if !is_behind_side {
            return false;
        }
        let directions = Tangent::new(cone.axis);
        for (end, out) in self.ends().into_iter().zip([-1.0, 1.0]) {
            let Some([z, radius]) = end else { continue };
            let centre = cone.point + cone.axis * z;
            if radius == 0.0 {
                deep_in_solid::minima_of_point(grain, centre, |n| {
                    offer(n, SolidPlace::Tip(centre))
                });
                continue;
            }
            offer(cone.axis * out, SolidPlace::Cap);
            let circle = || deep_in_solid::Circle {
                centre,
                axis: cone.axis,
                basis: [directions.u, directions.v],
                radius,
                normals: [[0.0, out], [c, s]],
            };
            circle().minima(grain, |n, radial| {
                offer(n, SolidPlace::Rim(circle(), radial));
            });
        }
        true
    }
}

impl ConeWall {
    /// The surface at a contact of the cone, if the side reaches there.
    fn surface_at(&self, c: &ConeContact, within: bool) -> Option<WallSurface> {
        let ConeSide { cone, bounds, .. } = &self.surface;
        let is_there = bounds[0] <= c.along && c.along <= bounds[1] && c.curvature_radius > 0.0;
        let signed = if within {
            -c.curvature_radius
        } else {
            c.curvature_radius
        };
        is_there.then(|| WallSurface {
            curvatures: [1.0 / signed, 0.0],
            turning_radii: [signed, f64::INFINITY],
            ..flat_along(c.point, c.normal, cone.axis.cross(c.normal).normalised())
        })
    }

    /// As `Shape::may_touch`.
    #[inline(always)]
    pub(super) fn is_near(&self, ball: &Ball) -> bool {
        let Ball { centre, radius, .. } = *ball;
        let ConeSide { cone, bounds, side } = &self.surface;
        let offset = centre - cone.point;
        let along = cone.axis.dot(offset);
        if along + radius < bounds[0] || along - radius > bounds[1] {
            return false;
        }
        // Squares: a root costs more than all else here.
        let across_squared = (offset - cone.axis * along).norm_squared();
        let at_surface = cone.radius + cone.slope * along;
        let reach = radius * self.stretch;
        let (nearest, farthest) = (at_surface - reach, at_surface + reach);
        let is_clear_within = nearest > 0.0 && across_squared <= nearest * nearest;
        let is_clear_outside = farthest <= 0.0 || across_squared >= farthest * farthest;
        !match side {
            Side::Inside => is_clear_within,
            Side::Outside => is_clear_outside,
            Side::OfCentre => is_clear_within || is_clear_outside,
        }
    }

    /// As `Shape::touch`.
    pub(super) fn contacts(&self, grain: &Grain<'_>, mut found: impl FnMut(&WallSurface)) {
        let Grain { body, centre, .. } = *grain;
        let ConeSide { cone, side, .. } = &self.surface;
        let within = side.is_within(|| cone.has_within(centre));
        touch_cone(body, centre, cone, within, |c| {
            if let Some(surface) = self.surface_at(&c, within) {
                found(&surface);
            }
        });
    }
}

#[cfg(feature = "std")]
impl Shape for ConeWall {
    fn remembered(&self) -> usize {
        REMEMBERED
    }

    fn may_touch(&self, ball: &Ball) -> bool {
        self.is_near(ball)
    }

    fn may_touch_block(&self, block: &Block) -> bool {
        let ConeSide { cone, bounds, side } = &self.surface;
        let half = block.half_edges();
        let offset = block.centre() - cone.point;
        let along = cone.axis.dot(offset);
        // How far centres may lie from the middle, along the axis and across it.
        let a = cone.axis;
        let spread_along = a.x.abs() * half.x + a.y.abs() * half.y + a.z.abs() * half.z;
        let off_axis = |component: f64| (1.0 - component * component).max(0.0).sqrt();
        let spread_across =
            off_axis(a.x) * half.x + off_axis(a.y) * half.y + off_axis(a.z) * half.z;
        let reach_along = spread_along + block.radius();
        if along + reach_along < bounds[0] || along - reach_along > bounds[1] {
            return false;
        }
        let at_surface = cone.radius + cone.slope * along;
        let [least, most] = block.distances(offset - cone.axis * along, spread_across);
        let outwards = [
            least - at_surface - cone.slope.abs() * spread_along,
            most - at_surface + cone.slope.abs() * spread_along,
        ];
        // `stretch` is at least 1.
        side.may_touch_block(outwards, block.radius() * self.stretch)
    }

    fn in_lanes(&self) -> Option<ShapeInLanes> {
        Some(ShapeInLanes::Cone(self.surface))
    }

    fn touch(&self, grain: &Grain<'_>, _: &mut Search, found: &mut Found<'_>) {
        self.contacts(grain, |surface| found(surface, 0));
    }
}
