// SPDX-License-Identifier: MIT OR Apache-2.0
//! A rigid wall: its parts, and the memory that its calls keep.

use super::contacts::{Contacts, Places, Source, WithHistories};
use super::histories::{WallHistoryLayout, WrongHistory};
use super::lent_triangles::LentTriangles;
use super::lone_contacts::LoneContacts;
use super::mesh::Mesh;
use super::motion::Motion;
use super::parts::{OwnParts, Part};
use super::shape::{Ball, Block, Shape, ShapeInLanes, WholePlane};
use super::solid_block::SolidBlock;
use super::surface::Surface;
use super::touching_loads::{TouchingLoad, TouchingLoads};
use crate::contact::{ContactForces, HistoryLayout, Laws};
use crate::geometry::triangles::Triangle;
use crate::vector::Vector3;
use core::any::Any;

/// Parts that move as one, and what is kept between calls so that a step allocates nothing.
///
/// # Example
/// ```
/// use ellgran::contact::{prepare_body, Body, Laws, Step};
/// use ellgran::simd::InstructionSet;
/// use ellgran::tallies::Tallies;
/// use ellgran::vector::Vector3;
/// use ellgran::walls::{compute_wall, write_triangle_loads, Mesh, Motion, Wall, WallInput, WallOutput};
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3", "tangential", "tfd", "0.5"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// // A plate of two triangles in the plane z = 0, which moves up at 1 cm/s and has come 1 mm so far (m, s).
/// let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
/// let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
/// let mesh = Mesh::new(vec![[a, b, c], [a, c, d]])?;
/// assert_eq!(mesh.triangle_count(), 2);
/// let mut wall = Wall::new();
/// wall.add_mesh(mesh);
/// assert_eq!((wall.part_count(), wall.triangles().count()), (1, 2));
/// assert!(wall.whole_plane(0).is_none(), "it has edges");
/// wall.records_contacts = true;
/// wall.records_triangles = true;
/// wall.keeps_inelastic_loads = true;
/// let motion = Motion {
///     displacement: Vector3::new(0.0, 0.0, 1e-3),
///     velocity: Vector3::new(0.0, 0.0, 0.01),
///     ..Motion::REST
/// };
/// // Where it speeds up, what it has more at the step is read beside grains with velocities of the step.
/// let faster = Motion { velocity_change: Vector3::new(0.0, 0.0, 1e-4), ..motion };
/// assert_eq!(faster.velocity_change_at(faster.centre()), faster.velocity_change);
/// let ball = Body {
///     position: [0.3, -0.2, 10.99e-3],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [10e-3; 3],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1e-2,
///     particle_type: 1,
///     identifier: 1,
/// };
/// wall.find_near(&motion, 1, |_| Some((Vector3::from_array(ball.position), 10e-3)));
/// // In later steps of the same particles their positions are enough.
/// assert_eq!(wall.find_near_again(&motion, &[ball.position]), Some(&[0][..]));
/// assert_eq!(wall.near(), [0]);
/// let layout = wall.histories(&laws);
/// let mut histories = vec![0.0; layout.length()];
/// wall.check_histories(layout, Some(&laws.layout()), &histories).expect("zeros: nothing is remembered");
/// let (mut forces, mut torques) = ([[0.0; 3]], [[0.0; 3]]);
/// let input = WallInput {
///     laws: &laws,
///     wall_type: 1,
///     near: &[prepare_body(&ball, Some(1))?],
///     motion: &motion,
///     step: &Step { time_step: 1e-6, advance_history: true },
///     instruction_set: InstructionSet::widest(),
/// };
/// let mut output =
///     WallOutput { acts_on: &|_| true, histories: &mut histories, forces: &mut forces, torques: &mut torques };
/// let mut tallies = Tallies::default();
/// let load = compute_wall(&mut wall, &input, &mut output, Some(&mut tallies)).expect("exact factors");
/// assert_eq!(load.contacts, 1);
/// assert!(layout.used(&histories) > 0);
/// // The power of the ball on the wall is its force times the wall's velocity.
/// assert!((load.power - load.force.z * 0.01).abs() < 1e-12 * load.power.abs());
/// assert!((wall.part_forces()[0] - load.force).norm() < 1e-12 * load.force.norm());
/// let [contact] = wall.contacts() else { panic!("one contact was recorded") };
/// assert!((contact.penetration - 1e-5).abs() < 1e-12 && contact.part == 0);
/// let loads = wall.triangle_loads();
/// assert!((loads.iter().map(|t| t.force.z).sum::<f64>() / load.force.z - 1.0).abs() < 1e-12);
/// // Each grain that touched, with what acted on it beside the gradient of the elastic energy; here nothing yet.
/// let [touched] = wall.touching_loads() else { panic!("one grain touched") };
/// assert!(touched.particle == 0 && touched.load.is_zero());
/// wall.touching_loads_mut()[0].load.respond(|torque| torque * 0.5);
///
/// // For ParaView, where the plate is now.
/// let file = std::env::temp_dir().join(format!("ellgran plate {}.vtk", std::process::id()));
/// let triangles: Vec<_> = wall.triangles().copied().collect();
/// write_triangle_loads(&file, &triangles, &motion, wall.triangle_loads())?;
/// assert!(std::fs::read_to_string(&file)?.contains("POLYGONS"));
/// std::fs::remove_file(file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Wall {
    pub(super) parts: Vec<Box<dyn Shape>>,
    /// The last part, of a wall to which an engine lends triangles.
    pub(super) lent: Option<LentTriangles>,
    /// Particles that may touch.
    pub(super) near: Vec<usize>,
    /// The radius of each particle that the last search was given, or [`TAKES_NO_PART`].
    reaches: Vec<f64>,
    /// The largest radius of each block of them: less than 0 where none took part, NaN where the block has to be looked at, as one in which
    /// a particle was near.
    radii: Vec<f64>,
    /// The particles of which something is remembered, as far as that is known.
    pub(super) with_histories: WithHistories,
    /// The contacts that were found last.
    pub(super) found: Contacts,
    /// Of walls whose contacts are taken in lanes.
    pub(super) lone: LoneContacts,
    /// Force on each part in the last call, world frame.
    pub(super) part_forces: Vec<Vector3>,
    /// The contacts of the last call.
    pub(super) contacts: Vec<RecordedWallContact>,
    /// Whether a call records its contacts.
    pub records_contacts: bool,
    /// What acted on each triangle in the last call that recorded it.
    pub(super) triangle_loads: Vec<TriangleLoad>,
    /// Whether a call records the loads of triangles.
    pub records_triangles: bool,
    /// What acted on the particles that touched in the last call that kept it.
    pub(super) touching_loads: TouchingLoads,
    /// Whether a call with tallies that have no place for the loads that are not elastic keeps those of the particles that touch, so
    /// that their work is reckoned in two halves ([`crate::tallies::Tallies::add_half_step`]).
    pub keeps_inelastic_loads: bool,
}

/// What the particles do to one triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct TriangleLoad {
    /// Force on the triangle, world frame.
    pub force: Vector3,
    /// Sum of the forces that press on its plane, each from the side of its particle: pressure on the two sides adds up.
    pub pressing: f64,
}

/// What the particles do to a wall in one call.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallLoad {
    /// Force on the wall, world frame.
    pub force: Vector3,
    /// Torque on the wall about [`Motion::centre`], world frame.
    pub torque: Vector3,
    /// Power that the particles give to the wall by its motion: force times velocity and torque times angular velocity.
    pub power: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Sum over the contacts of a bound of the stiffness, force/length ([`crate::force::PairLaw::largest_springs`]): the wall
    /// feels at most that in any direction in which it is displaced.
    pub stiffness: f64,
    /// The same of the damping, force x time/length.
    pub damping: f64,
    /// A particle that touches in more places than are remembered.
    pub crowded: Option<usize>,
    /// Where the wall keeps the loads of its particles that are not elastic: the viscous part of force and torque, and then that of the
    /// tangential displacement.
    pub inelastic: [ForceAndTorque; 2],
}

/// A force and a torque on a wall, about [`Motion::centre`], world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceAndTorque {
    /// The force.
    pub force: Vector3,
    /// The torque.
    pub torque: Vector3,
}

/// One contact as it acted.
#[derive(Clone, Copy, Debug)]
pub struct RecordedWallContact {
    /// Index of the particle.
    pub particle: usize,
    /// Index of the wall's part.
    pub part: usize,
    /// Unit normal out of the wall, towards the particle, world frame.
    pub normal: Vector3,
    /// Contact point, world frame.
    pub point: Vector3,
    /// Penetration > 0.
    pub penetration: f64,
    /// Force on the particle and torque about its centre, normal and tangential force and energies, world frame; forces in it
    /// are those on the wall, torques those on the particle.
    pub forces: ContactForces,
}

/// Particles that are looked at together: engines keep neighbours next to each other, so that most of these are far from a wall as a
/// whole. As many as lie side by side in a row that does not reach from one side of a vessel to the other.
const BLOCK: usize = 16;
/// Blocks that are looked at together first.
const TOGETHER: usize = 4;

/// Instead of the radius of a particle that the wall does not act on.
const TAKES_NO_PART: f64 = f64::NEG_INFINITY;

/// The largest of some numbers; NaN where one of them is.
fn largest_or_nan(numbers: &[f64]) -> f64 {
    (numbers.iter()).fold(-1.0, |largest, x| {
        if *x <= largest || largest.is_nan() {
            largest
        } else {
            *x
        }
    })
}

impl Wall {
    /// A wall without parts.
    pub fn new() -> Self {
        Wall::default()
    }

    /// Adds a surface of triangles.
    pub fn add_mesh(&mut self, mesh: Mesh) {
        self.parts.push(Box::new(mesh));
    }

    /// Adds a block from without, along the axes of the wall, by its lower and its upper corner. Bodies that are deep in it go out the
    /// shortest way.
    ///
    /// # Errors
    /// Corners that are not in order, or out of range.
    ///
    /// # Example
    /// ```
    /// let mut wall = ellgran::walls::Wall::new();
    /// wall.add_block([-1.0; 3], [1.0, 1.0, 2.0]).unwrap();
    /// assert_eq!(wall.part_count(), 1);
    /// assert!(wall.add_block([0.0; 3], [1.0, 0.0, 1.0]).is_err());
    /// ```
    pub fn add_block(&mut self, low: [f64; 3], high: [f64; 3]) -> Result<(), String> {
        self.parts.push(Box::new(SolidBlock::new(low, high)?));
        Ok(())
    }

    /// The triangles that an engine lends: from the first call on a part of the wall, after the others.
    pub fn lent_triangles(&mut self) -> &mut LentTriangles {
        self.lent.get_or_insert_default()
    }

    /// The parts, one after the other.
    pub(super) fn shapes(&self) -> impl Iterator<Item = &dyn Shape> + Clone {
        let lent = self.lent.iter().map(|l| l as &dyn Shape);
        self.parts.iter().map(|p| &**p).chain(lent)
    }

    /// How many parts there are.
    pub fn part_count(&self) -> usize {
        self.shapes().count()
    }

    /// The plane that a part is, in the frame of the wall; `None` for another shape, and where there is no such part.
    pub fn whole_plane(&self, part: usize) -> Option<WholePlane> {
        match self.shapes().nth(part)?.in_lanes()? {
            ShapeInLanes::Plane(plane) => Some(plane),
            ShapeInLanes::Cone(_) | ShapeInLanes::PlaneInPlaces => None,
        }
    }

    /// The parts without memory of their own, as a device has them. Public for `gpu/`; no interface for others.
    ///
    /// # Errors
    /// The number of the first part that is no such surface: triangles.
    #[doc(hidden)]
    pub fn surfaces(&self) -> Result<Vec<Surface>, usize> {
        let parts = self.parts.iter().map(|part| Surface::of(&**part));
        let lent = self.lent.iter().map(|_| None);
        let all = parts.chain(lent).enumerate();
        all.map(|(part, surface)| surface.ok_or(part)).collect()
    }

    /// The parts as a device has them, where triangles are among them. Public for `gpu/`; no interface for others.
    ///
    /// # Errors
    /// The number of the first part that can only be on the host: triangles that an engine lends.
    #[doc(hidden)]
    pub fn parts_with_triangles(&self) -> Result<OwnParts, usize> {
        let mut all = OwnParts::default();
        for (number, part) in self.parts.iter().enumerate() {
            if let Some(surface) = Surface::of(&**part) {
                all.parts.push(Part::Surface(surface));
                continue;
            }
            let any: &dyn Any = &**part;
            let of_block = any.downcast_ref().map(|block: &SolidBlock| &block.mesh);
            let mesh: &Mesh = any.downcast_ref().or(of_block).ok_or(number)?;
            let (triangle, node) = (all.triangles.len() as u64, all.nodes.len() as u64);
            all.triangles.extend_from_slice(&mesh.triangles);
            all.boxes.extend_from_slice(&mesh.boxes);
            all.widths.extend_from_slice(&mesh.widths);
            all.nodes.extend_from_slice(&mesh.tree.nodes);
            all.order.extend_from_slice(&mesh.tree.order);
            let triangles = [triangle, all.triangles.len() as u64];
            let part = Part::Triangles(triangles, [node, all.nodes.len() as u64]);
            all.parts.push(part);
        }
        match self.lent {
            Some(_) => Err(self.parts.len()),
            None => Ok(all),
        }
    }

    /// How the histories of a particle are laid out, with the library's own contact laws.
    pub fn histories(&self, laws: &Laws) -> WallHistoryLayout {
        let layout = laws.layout();
        self.histories_of(layout.memory.map_or(0, |_| layout.length))
    }

    /// The same, with a contact model that keeps `history` doubles of each contact.
    pub fn histories_of(&self, history: usize) -> WallHistoryLayout {
        WallHistoryLayout::new(history, self.shapes().map(Shape::remembered).sum())
    }

    /// Finds the particles that may touch: those of which `of` gives the centre and the largest semi-axis. Of the others it
    /// gives `None`.
    pub fn find_near(
        &mut self,
        motion: &Motion,
        particles: usize,
        of: impl Fn(usize) -> Option<(Vector3, f64)>,
    ) -> &[usize] {
        self.with_histories.forget();
        self.radii.clear();
        self.radii.resize(particles.div_ceil(BLOCK), 0.0);
        self.reaches.clear();
        self.reaches.resize(particles, TAKES_NO_PART);
        let ball = |particle: usize, reach: &mut f64| {
            let (centre, radius) = of(particle)?;
            *reach = radius;
            Some((centre, radius))
        };
        self.find_in_blocks(motion, particles, None, ball)
    }

    /// The same where the particles and their order are those of the last search, with the same semi-axes, the same ones take part, and
    /// nobody else has written their histories: their centres alone are looked at. `None`, and no search, where their number is another one.
    pub fn find_near_again(&mut self, motion: &Motion, positions: &[[f64; 3]]) -> Option<&[usize]> {
        let particles = positions.len();
        if self.reaches.len() != particles {
            return None;
        }
        let ball = |particle: usize, reach: &mut f64| {
            let centre = Vector3::from_array(positions[particle]);
            (*reach != TAKES_NO_PART).then_some((centre, *reach))
        };
        Some(self.find_in_blocks(motion, particles, Some(positions), ball))
    }

    /// What was searched last are not the particles that [`Wall::find_near_again`] is told of: it finds none.
    pub(crate) fn forget_particles(&mut self) {
        self.reaches.clear();
    }

    /// Whether particles with these centres, none with a radius greater than this one, are far from all parts; false for NaN.
    fn is_far(&self, motion: &Motion, centres: &[[f64; 3]], radius: f64) -> bool {
        if radius.is_nan() {
            return false;
        }
        let block = Block::of_centres(centres, radius).seen_from_wall(motion);
        block.can_be_asked() && !self.shapes().any(|shape| shape.may_touch_block(&block))
    }

    /// `ball` gives centre and radius of a particle that takes part, and is handed the place of its radius.
    fn find_in_blocks(
        &mut self,
        motion: &Motion,
        particles: usize,
        known: Option<&[[f64; 3]]>,
        ball: impl Fn(usize, &mut f64) -> Option<(Vector3, f64)>,
    ) -> &[usize] {
        let mut near = core::mem::take(&mut self.near);
        // What stands there is overwritten.
        if near.len() < particles {
            near.resize(particles, 0);
        }
        let mut found = 0;
        const ALL: usize = BLOCK * TOGETHER;
        let (mut balls, mut marks) = ([Ball::default(); ALL], [false; ALL]);
        for start in (0..particles).step_by(ALL) {
            let stop = particles.min(start + ALL);
            if let Some(positions) = known {
                let radii = &self.radii[start / BLOCK..stop.div_ceil(BLOCK)];
                let radius = largest_or_nan(radii);
                if radius < 0.0 || self.is_far(motion, &positions[start..stop], radius) {
                    continue;
                }
            }
            let mut blocks = [const { (0, 0..0) }; TOGETHER];
            let (mut count, mut filled, mut all) = (0, 0, Block::EMPTY);
            for first in (start..stop).step_by(BLOCK) {
                let end = particles.min(first + BLOCK);
                if let Some(positions) = known {
                    let radius = self.radii[first / BLOCK];
                    if radius < 0.0 || self.is_far(motion, &positions[first..end], radius) {
                        continue;
                    }
                }
                let from = filled;
                for (particle, reach) in (first..end).zip(&mut self.reaches[first..end]) {
                    if let Some((centre, radius)) = ball(particle, reach) {
                        let centre = motion.point_to_wall(centre);
                        balls[filled] = Ball {
                            particle,
                            centre,
                            radius,
                        };
                        filled += 1;
                    }
                }
                // What was near is looked at again without asking.
                let mut block = Block::UNKNOWN;
                let radius = &mut self.radii[first / BLOCK];
                if !radius.is_nan() {
                    block = Block::of(&balls[from..filled]);
                    *radius = block.radius_or_none();
                }
                all = all.with(&block);
                blocks[count] = (first / BLOCK, from..filled);
                count += 1;
            }
            let (balls, marks) = (&balls[..filled], &mut marks[..filled]);
            if !self.mark_near(&all, balls, marks) {
                continue;
            }
            for (index, range) in &blocks[..count] {
                let before = found;
                for k in range.clone() {
                    // Without a branch, which would often be mispredicted
                    near[found] = balls[k].particle;
                    found += usize::from(marks[k]);
                }
                let radius = &mut self.radii[*index];
                if found > before {
                    // So it will be in the next steps, too.
                    *radius = f64::NAN;
                } else if radius.is_nan() {
                    *radius = Block::of(&balls[range.clone()]).radius_or_none();
                }
            }
        }
        near.truncate(found);
        self.near = near;
        &self.near
    }

    /// Marks the particles of a block that may touch; false where none can.
    #[inline(always)]
    fn mark_near(&mut self, block: &Block, balls: &[Ball], marks: &mut [bool]) -> bool {
        let lent = self.lent.iter_mut().map(|l| l as &mut dyn Shape);
        let parts = self.parts.iter_mut().map(|p| &mut **p as &mut dyn Shape);
        let mut is_far = true;
        for shape in parts.chain(lent) {
            if block.can_be_asked() && !shape.may_touch_block(block) {
                continue;
            }
            if is_far {
                marks.fill(false);
                is_far = false;
            }
            shape.mark_near(balls, marks);
        }
        !is_far
    }

    /// The particles that [`Wall::find_near`] found.
    pub fn near(&self) -> &[usize] {
        &self.near
    }

    /// Forgets what the last call gave.
    pub(super) fn start_call(&mut self) {
        self.touching_loads.clear();
        self.contacts.clear();
        self.triangle_loads.clear();
        if self.records_triangles {
            let triangles = self.parts.iter().map(|p| p.triangles().len()).sum();
            self.triangle_loads
                .resize(triangles, TriangleLoad::default());
        }
        let parts = self.part_count();
        self.part_forces.clear();
        self.part_forces.resize(parts, Vector3::ZERO);
    }

    /// Whether the histories of the particles that may touch are such as calls have written. `of_laws` is the layout of the library's
    /// own histories, `None` for those of an engine.
    ///
    /// # Errors
    /// The first number that is not.
    pub fn check_histories(
        &self,
        layout: WallHistoryLayout,
        of_laws: Option<&HistoryLayout>,
        histories: &[f64],
    ) -> Result<(), WrongHistory> {
        let parts = self.part_count();
        self.near
            .iter()
            .try_for_each(|&particle| layout.check(particle, histories, parts, of_laws))
    }

    /// Finds the contacts of the particles that may touch, and what each goes on from. `histories` are read alone, and have been
    /// checked ([`Wall::check_histories`]).
    ///
    /// # Example
    /// ```
    /// use ellgran::contact::stable_step::{least_stable_step, ContactExtremes, SUMS};
    /// use ellgran::contact::{prepare_body, Body, Laws, Step};
    /// use ellgran::vector::Vector3;
    /// use ellgran::walls::{Frame, Motion, Places, Wall, WallMasses};
    ///
    /// // An engine that computes forces itself: the library finds the contacts, and keeps 2 doubles of each.
    /// let mut wall = Wall::new();
    /// let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
    /// let floor = [corner(-3.0, -3.0), corner(3.0, -3.0), corner(0.0, 6.0)];
    /// // The triangle is the engine's own: it is lent for this step, and particle 0 is near it.
    /// wall.lent_triangles().set([floor].into_iter(), std::iter::empty(), std::iter::empty(), &[0, 1], &[0])?;
    /// let ball = Body {
    ///     position: [0.0, 0.0, 0.99],
    ///     quaternion: [1.0, 0.0, 0.0, 0.0],
    ///     semi_axes: [1.0; 3],
    ///     velocity: [0.0; 3],
    ///     angular_velocity: [0.0; 3],
    ///     mass: 1.0,
    ///     particle_type: 1,
    ///     identifier: 1,
    /// };
    /// wall.find_near(&Motion::REST, 1, |_| Some((Vector3::from_array(ball.position), 1.0)));
    /// let layout = wall.histories_of(2);
    /// let mut histories = vec![0.0; layout.length()];
    /// let step = Step { time_step: 1e-6, advance_history: true };
    /// let near = [prepare_body(&ball, None)?];
    /// let places = Places { near: &near, motion: &Motion::REST, step: &step, frame: Frame::World };
    /// wall.find_contacts(&places, layout, &histories);
    /// let [contact] = wall.found().all() else { panic!("one contact") };
    /// assert_eq!((contact.particle, contact.last_normal), (0, None));
    /// assert_eq!(wall.found().histories_length(), layout.length());
    /// assert!(wall.found().crowded().is_none());
    /// assert!((wall.found().staged()[0].contact.penetration() - 0.01).abs() < 1e-14);
    /// // What the contact adds to the bound of the time step.
    /// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
    /// let laws = Laws::new(1, &[Some(parameters)], true)?;
    /// let (mut sums, mut extremes) = ([[0.0; SUMS]], ContactExtremes::default());
    /// let masses = WallMasses { inverse_mass: 1.0, effective_mass: 1.0 };
    /// wall.add_to_step_sums(&laws, &near, &|_| 1, &|_| masses, &|k| k as i64 + 1, &mut sums, &mut extremes)
    ///     .expect("exact factors");
    /// assert!(least_stable_step(&sums).0 < f64::INFINITY);
    /// wall.found_mut().history(0).copy_from_slice(&[7.0, 8.0]);
    /// wall.found().remember(&mut histories, &|_| true);
    /// // In the next step the contact goes on from that.
    /// wall.find_contacts(&places, layout, &histories);
    /// assert!(wall.found().all()[0].last_normal.is_some());
    /// assert_eq!(wall.found_mut().history(0), [7.0, 8.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_contacts(
        &mut self,
        places: &Places<'_>,
        layout: WallHistoryLayout,
        histories: &[f64],
    ) {
        let length = layout.length();
        let mut found = core::mem::take(&mut self.found);
        found.start(layout);
        let is_alone = self.part_count() == 1;
        for (near, (i, &particle)) in places.near.iter().zip(&self.near).enumerate() {
            let histories = &histories[particle * length..(particle + 1) * length];
            let shapes = self.shapes();
            let from = Source::Shapes { is_alone, shapes };
            found.add(from, places, i, (particle, near), histories);
        }
        self.found = found;
    }

    /// Writes what is remembered of the contacts that were found, but for those of the particles `written`, in ascending order.
    pub(super) fn remember(
        &mut self,
        histories: &mut [f64],
        acts_on: &dyn Fn(usize) -> bool,
        written: &[usize],
    ) {
        let with_histories = &mut self.with_histories;
        self.found
            .remember_others(histories, acts_on, written, with_histories);
    }

    /// The contacts that were found last.
    pub fn found(&self) -> &Contacts {
        &self.found
    }

    /// The same, with their histories to be changed.
    pub fn found_mut(&mut self) -> &mut Contacts {
        &mut self.found
    }

    /// Force on each part in the last call, world frame.
    pub fn part_forces(&self) -> &[Vector3] {
        &self.part_forces
    }

    /// What acted on the particles that touched in the last call, if it kept that; else empty.
    pub fn touching_loads(&self) -> &[TouchingLoad] {
        self.touching_loads.all()
    }

    /// The same, to replace their torques ([`crate::tallies::InelasticLoad::respond`]).
    pub fn touching_loads_mut(&mut self) -> &mut [TouchingLoad] {
        self.touching_loads.all_mut()
    }

    /// The triangles of all parts, one part after the other, in the frame of the wall.
    pub fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.parts.iter().flat_map(|p| p.triangles())
    }

    /// What acted on each of the triangles in the last call, if it recorded that; else empty.
    pub fn triangle_loads(&self) -> &[TriangleLoad] {
        &self.triangle_loads
    }

    /// The contacts of the last call, if it recorded them.
    pub fn contacts(&self) -> &[RecordedWallContact] {
        &self.contacts
    }
}
