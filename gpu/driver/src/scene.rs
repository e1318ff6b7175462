// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene on the device: what it holds from step to step, and which kernels a call starts, in which order.
//!
//! Memory is allocated with a new list alone. In a step nothing is allocated, nothing is copied, and nothing is waited for.

use crate::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuLoads,
    EllgranGpuMotion, EllgranGpuTallies, EllgranGpuVectors,
};
use crate::device::{Array, Buffer, Device, OnDevice, VectorArray};
use crate::driver_library::Stream;
use crate::entries::{
    Chosen, Common, MeshEntries, Precision, Shapes, TallyEntries, Terms, WallEntry,
};
use crate::wall_histories::WallHistories;
use core::sync::atomic::{AtomicU32, AtomicU64};
use ellgran::c_api::status::{
    Failure, ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_PARTICLE,
};
use ellgran::contact::ranges::{LARGEST_COORDINATE, LARGEST_VELOCITY, LONGEST_TIME_STEP};
use ellgran::contact::{Laws, Step};
use ellgran::force::PairLaw;
use ellgran::geometry::box_tree::{Extent, Node};
use ellgran::geometry::triangles::Triangle;
use ellgran::walls::one_particle::{LONGEST_HISTORY, MOST_CONTACTS};
use ellgran::walls::parts::{OwnParts, Part, MOST_RECORDS};
use ellgran::walls::{Motion, MovingPlane, Surface, Wall, WallHistoryLayout};
use ellgran_kernels::arguments::{
    BodyArguments, CandidateArguments, CarryPairsArguments, CarryWallArguments, ContactArguments,
    FileArguments, MeshArguments, MotionArguments, NumberArguments, PlaneArguments, PoseArguments,
    PrepareArguments, SceneArguments, ShapeArguments, SumArguments, TallyArguments, TermArguments,
    WallArguments, CANDIDATES, FAULT, FOUND, KEPT, MARKED, MOVED, NOTES, NO_SPHERE, NO_SPHEROID,
    ROWS_NUMBERED, SELECTIONS,
};
use ellgran_kernels::candidates::Candidate;
use ellgran_kernels::meshes::{LargeRoom, SmallRoom, COUNTS, MOST_TRIANGLES, TOO_MANY_TRIANGLES};
use ellgran_kernels::pair_memory::{slots_for, HALF_LIST, NAMED_TWICE, WRONG_NEIGHBOUR, WRONG_ROW};
use ellgran_kernels::preparation::Fault;
use ellgran_kernels::shapes::{Grain, GrainChange};
use ellgran_kernels::tallies::TALLIES;
use ellgran_kernels::terms::{COMPONENTS, NUMBERS};
use ellgran_kernels::walls::{WallMotion, TOO_MANY_CONTACTS};
use std::sync::Arc;

/// Threads that contacts get, at least, where there are so many pairs: few candidates may become more before the next list.
const FEWEST_CONTACT_THREADS: usize = 1 << 14;
/// Threads that look for marked contacts, at most: there are few of these.
const MARKED_THREADS: usize = 1 << 16;

/// Threads that select candidates, at most: in most steps they find that there is nothing to do.
const SELECTING_THREADS: usize = 1 << 18;

/// Threads that sum up energies, at most: each leaves its sums to the host.
const TALLYING_THREADS: usize = 1 << 14;

/// Threads that look for the contacts with triangles, at most, each of which has 60 kB of memory of the device for it: as many as there may be at
/// a time on a GPU of 128 processors with two blocks each.
const MESH_THREADS: usize = 1 << 13;
/// The same for grains that need large room, of which there are few.
const CROWDED_MESH_THREADS: usize = 1 << 7;

fn argument<T>(what: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::new(ELLGRAN_ERROR_ARGUMENT, what))
}

/// The address of an array that must be given.
fn address<T>(pointer: *const T, name: &str) -> Result<u64, Failure> {
    if pointer.is_null() {
        return Err(Failure::new(
            ELLGRAN_ERROR_NULL_POINTER,
            format!("{name} must not be NULL"),
        ));
    }
    Ok(pointer.addr() as u64)
}

/// An array that must be given where it has elements.
fn array<T, P>(pointer: *const P, length: usize, name: &str) -> Result<Array<T>, Failure> {
    if length == 0 {
        return Ok(Array::EMPTY);
    }
    Ok(Array::at(address(pointer, name)?, length))
}

/// An array that need not be given.
fn optional<T, P>(pointer: *const P, length: usize) -> Array<T> {
    Array::at(pointer.addr() as u64, length)
}

/// Vectors that must be given where there are any.
fn vectors<const N: usize>(
    given: &EllgranGpuVectors,
    count: usize,
    name: &str,
) -> Result<VectorArray<N>, Failure> {
    if count > 0 {
        address(given.first, name)?;
    }
    // A distance of 0 would put components into one another's places.
    if (given.per_grain == 0) != (given.per_component == 0) {
        return argument(format!(
            "{name}: per_grain = {} and per_component = {} must both be 0, or both greater",
            given.per_grain, given.per_component
        ));
    }
    let first = given.first.addr() as u64;
    Ok(VectorArray::at(
        first,
        given.per_grain,
        given.per_component,
        count,
    ))
}

/// How many entries the arrays have that owners name.
fn named_count(g: &EllgranGpuGrains) -> usize {
    if g.owners.is_null() {
        g.count
    } else {
        g.owned_count
    }
}

fn bodies(g: &EllgranGpuGrains) -> Result<BodyArguments<OnDevice>, Failure> {
    let count = if g.body_places.is_null() {
        named_count(g)
    } else {
        g.body_count
    };
    Ok(BodyArguments {
        owners: optional(g.owners, g.count),
        places: optional(g.body_places, named_count(g)),
        semi_axes: vectors(&g.semi_axes, count, "semi_axes")?,
        quaternions: vectors(&g.quaternions, count, "quaternions")?,
    })
}

/// States and histories of one wall.
struct WallMemory {
    states: Buffer<u32>,
    histories: Buffer<f64>,
    /// Doubles of one grain.
    length: usize,
}

impl WallMemory {
    fn new(device: &Arc<Device>, length: usize) -> Self {
        WallMemory {
            states: Buffer::new(device),
            histories: Buffer::new(device),
            length,
        }
    }

    /// Room for so many grains.
    fn resize(&mut self, owned: usize) -> Result<(), Failure> {
        self.states.resize(owned)?;
        self.histories.resize(owned * self.length)
    }
}

/// What a wall is.
enum WallKind {
    /// A plane, of which each call says where it is.
    Plane,
    /// Surfaces on the device, and how the histories of a grain with them are laid out.
    Surfaces(Buffer<Surface>, WallHistoryLayout),
    /// The same of parts of which some are triangles.
    Parts(Box<PartsOnDevice>, WallHistoryLayout),
}

/// The parts of a wall with triangles.
struct PartsOnDevice {
    parts: Buffer<Part>,
    triangles: Buffer<Triangle>,
    boxes: Buffer<Extent>,
    widths: Buffer<f64>,
    nodes: Buffer<Node>,
    order: Buffer<usize>,
}

impl PartsOnDevice {
    fn new(device: &Arc<Device>, own: &OwnParts, stream: Stream) -> Result<Self, Failure> {
        fn copied<T>(
            device: &Arc<Device>,
            values: &[T],
            stream: Stream,
        ) -> Result<Buffer<T>, Failure> {
            let mut buffer = Buffer::new(device);
            buffer.resize(values.len())?;
            if !values.is_empty() {
                device.driver().copy_in(buffer.address(), values, stream)?;
            }
            Ok(buffer)
        }
        let parts = PartsOnDevice {
            parts: copied(device, &own.parts, stream)?,
            triangles: copied(device, &own.triangles, stream)?,
            boxes: copied(device, &own.boxes, stream)?,
            widths: copied(device, &own.widths, stream)?,
            nodes: copied(device, &own.nodes, stream)?,
            order: copied(device, &own.order, stream)?,
        };
        // Before the copies on the host go.
        device.driver().synchronise(stream)?;
        Ok(parts)
    }

    fn bytes(&self) -> usize {
        self.parts.bytes()
            + self.triangles.bytes()
            + self.boxes.bytes()
            + self.widths.bytes()
            + self.nodes.bytes()
            + self.order.bytes()
    }
}

/// What the searches among triangles of all walls take turns in.
struct MeshMemory {
    /// `None` where no wall has triangles.
    entries: Option<MeshEntries>,
    near: Buffer<u32>,
    crowded: Buffer<u32>,
    counts: Buffer<u32>,
    rooms: Buffer<SmallRoom>,
    large_rooms: Buffer<LargeRoom>,
}

impl MeshMemory {
    fn new(device: &Arc<Device>) -> Self {
        MeshMemory {
            entries: None,
            near: Buffer::new(device),
            crowded: Buffer::new(device),
            counts: Buffer::new(device),
            rooms: Buffer::new(device),
            large_rooms: Buffer::new(device),
        }
    }

    /// For so many grains.
    fn resize(&mut self, owned: usize, stream: Stream) -> Result<(), Failure> {
        self.near.resize(owned)?;
        self.crowded.resize(owned)?;
        self.counts.resize(COUNTS)?;
        // Zeros are room, and not any bits are; what a search leaves is.
        if owned.min(MESH_THREADS) > self.rooms.len() {
            self.rooms.resize_exactly(owned.min(MESH_THREADS))?;
            self.rooms.clear(stream)?;
        }
        let crowded = owned.min(CROWDED_MESH_THREADS);
        if crowded > self.large_rooms.len() {
            self.large_rooms.resize_exactly(crowded)?;
            self.large_rooms.clear(stream)?;
        }
        Ok(())
    }

    fn bytes(&self) -> usize {
        self.near.bytes()
            + self.crowded.bytes()
            + self.counts.bytes()
            + self.rooms.bytes()
            + self.large_rooms.bytes()
    }
}

/// What is remembered of the pairs of one list, and of walls.
struct PairMemory {
    owned: usize,
    starts: Buffer<u32>,
    /// Of all grains.
    identifiers: Buffer<i32>,
    partners: Buffer<i32>,
    states: Buffer<u32>,
    histories: Buffer<f64>,
    walls: Vec<WallMemory>,
}

impl PairMemory {
    fn new(device: &Arc<Device>) -> Self {
        PairMemory {
            owned: 0,
            starts: Buffer::new(device),
            identifiers: Buffer::new(device),
            partners: Buffer::new(device),
            states: Buffer::new(device),
            histories: Buffer::new(device),
            walls: Vec::new(),
        }
    }

    fn bytes(&self) -> usize {
        let walls = self.walls.iter();
        self.starts.bytes()
            + self.identifiers.bytes()
            + self.partners.bytes()
            + self.states.bytes()
            + self.histories.bytes()
            + walls
                .map(|w| w.states.bytes() + w.histories.bytes())
                .sum::<usize>()
    }
}

/// What a list was made with.
#[derive(Clone, Copy)]
struct Listed {
    owned: usize,
    count: usize,
    neighbours: Array<u32>,
    margin: f64,
    has_changes: bool,
}

/// A scene.
pub struct Scene {
    device: Arc<Device>,
    laws: Laws,
    terms: Terms,
    /// `None`: each new list is looked through.
    stated: Option<Shapes>,
    precision: Precision,
    common: Common,
    chosen: Option<Chosen>,
    listed: Option<Listed>,
    table: Buffer<PairLaw>,
    grains: Buffer<Grain>,
    changes: Buffer<GrainChange>,
    inverse_masses: Buffer<f64>,
    poses: Buffer<[f64; 8]>,
    /// By their numbers.
    candidates: Buffer<Candidate>,
    /// Columns, which neighbouring threads write and read side by side.
    contact_loads: Buffer<[f64; NUMBERS]>,
    /// Numbers of marked candidates.
    marked: Buffer<u32>,
    /// Of each row, places of the candidates that it keeps, the number of the first of them, and how many they are.
    places: Buffer<u32>,
    firsts: Buffer<u32>,
    counts: Buffer<u32>,
    /// Which contacts add to the load of each grain, in its row, and how many.
    load_terms: Buffer<u32>,
    load_term_counts: Buffer<u32>,
    /// Threads that the contacts get: a few more than there were candidates with the list.
    contact_threads: usize,
    /// Of grains that cannot be prepared, and of rows.
    faults: Buffer<u32>,
    /// Of grains that cannot be moved.
    motion_faults: Buffer<u32>,
    notes: Buffer<u32>,
    slots: Buffer<u64>,
    /// By their numbers.
    walls: Vec<WallKind>,
    /// From the first wall of surfaces on.
    wall_entry: Option<WallEntry>,
    /// Empty where no wall has triangles.
    meshes: MeshMemory,
    /// From the first call on that asks for energies.
    tallies: Option<(TallyEntries, Buffer<f64>)>,
    now: PairMemory,
    /// The memory of the list before, or of a list that is being made.
    other: PairMemory,
}

impl Scene {
    /// A scene with these laws, which are copied to the device.
    ///
    /// # Errors
    /// Laws without a kernel; a status of a GPU.
    pub fn new(device: &Arc<Device>, laws: &Laws, stated: Option<Shapes>) -> Result<Self, Failure> {
        let terms = Terms::of(laws)?;
        let _entered = device.enter()?;
        let stream = Stream(core::ptr::null_mut());
        let types = 1..=laws.types();
        let table: Vec<PairLaw> = types
            .clone()
            .flat_map(|i| types.clone().map(move |j| *laws.get(i, j)))
            .collect();
        let mut scene = Scene {
            device: Arc::clone(device),
            laws: laws.clone(),
            terms,
            stated,
            precision: Precision::default(),
            common: Common::new(device)?,
            chosen: None,
            listed: None,
            table: Buffer::new(device),
            grains: Buffer::new(device),
            changes: Buffer::new(device),
            inverse_masses: Buffer::new(device),
            poses: Buffer::new(device),
            candidates: Buffer::new(device),
            contact_loads: Buffer::new(device),
            marked: Buffer::new(device),
            places: Buffer::new(device),
            firsts: Buffer::new(device),
            counts: Buffer::new(device),
            load_terms: Buffer::new(device),
            load_term_counts: Buffer::new(device),
            contact_threads: 0,
            faults: Buffer::new(device),
            motion_faults: Buffer::new(device),
            notes: Buffer::new(device),
            slots: Buffer::new(device),
            walls: Vec::new(),
            wall_entry: None,
            meshes: MeshMemory::new(device),
            tallies: None,
            now: PairMemory::new(device),
            other: PairMemory::new(device),
        };
        scene.table.resize(table.len())?;
        scene.notes.resize(NOTES)?;
        scene.notes.clear(stream)?;
        let driver = device.driver();
        driver.copy_in(scene.table.address(), &table, stream)?;
        driver.synchronise(stream)?;
        Ok(scene)
    }

    fn notes(&self) -> Array<AtomicU32> {
        self.notes.all_as()
    }

    fn contact_loads(&self) -> VectorArray<NUMBERS> {
        let count = self.contact_loads.len();
        VectorArray::at(self.contact_loads.address(), 1, count, count)
    }

    fn read_notes(&self, stream: Stream) -> Result<[u32; NOTES], Failure> {
        let mut notes = [0; NOTES];
        let driver = self.device.driver();
        driver.copy_out(&mut notes, self.notes.address(), stream)?;
        Ok(notes)
    }

    fn clear_note(&self, which: usize, stream: Stream) -> Result<(), Failure> {
        let at = self.notes.address() + (which * size_of::<u32>()) as u64;
        self.device.driver().clear(at, 1, stream)
    }

    /// The present list, if these grains are those that it was made with.
    fn listed_for(&self, g: &EllgranGpuGrains) -> Result<Listed, Failure> {
        let Some(listed) = self.listed else {
            return argument("there is no list yet: call ellgran_gpu_new_list first");
        };
        if (g.owned_count, g.count) != (listed.owned, listed.count) {
            return argument(format!(
                "owned_count = {} and count = {} of the grains were {} and {} with the list: call ellgran_gpu_new_list",
                g.owned_count, g.count, listed.owned, listed.count
            ));
        }
        if g.velocity_changes.is_null() == listed.has_changes {
            return argument(
                "velocity_changes are given now and were not with the list, or the other way round: call ellgran_gpu_new_list",
            );
        }
        Ok(listed)
    }

    fn chosen(&self) -> Result<&Chosen, Failure> {
        match &self.chosen {
            Some(chosen) => Ok(chosen),
            None => argument("there is no list yet: call ellgran_gpu_new_list first"),
        }
    }

    /// What all threads of a contact kernel read.
    fn scene_arguments(
        &self,
        g: &EllgranGpuGrains,
        step: &Step,
    ) -> Result<SceneArguments<OnDevice>, Failure> {
        Ok(SceneArguments {
            grains: self.grains.all(),
            changes: if g.velocity_changes.is_null() {
                Array::EMPTY
            } else {
                self.changes.all()
            },
            types: array(g.types, g.count, "types")?,
            inverse_masses: self.inverse_masses.all(),
            identifiers: array(g.identifiers, g.count, "identifiers")?,
            laws: self.table.all(),
            time_step: step.time_step,
            type_count: self.laws.types() as u32,
            advance_history: u32::from(step.advance_history),
            cached_normal: u32::from(self.terms.cached_normal),
            tangential: u32::from(self.terms.tangential),
            rescaled: u32::from(self.terms.rescaled),
        })
    }

    /// Prepares grains; with the margin of the candidates, notes whether one has moved too far for them.
    fn launch_prepare(
        &self,
        g: &EllgranGpuGrains,
        margin: Option<f64>,
        stream: Stream,
    ) -> Result<(), Failure> {
        let (n, named) = (g.count, named_count(g));
        let arguments = PrepareArguments {
            positions: vectors(&g.positions, n, "positions")?,
            velocities: vectors(&g.velocities, named, "velocities")?,
            angular_momenta: vectors(&g.angular_momenta, named, "angular_momenta")?,
            changes: optional(g.velocity_changes, named),
            masses: array(g.masses, named, "masses")?,
            bodies: bodies(g)?,
            types: array(g.types, n, "types")?,
            grains: self.grains.all(),
            motion_changes: self.changes.all(),
            inverse_masses: self.inverse_masses.all(),
            poses: match margin {
                Some(_) => self.poses.all(),
                None => Array::EMPTY,
            },
            faults: self.faults.all(),
            notes: self.notes(),
            margin: margin.unwrap_or(0.0),
            type_count: self.laws.types() as u32,
        };
        let prepare = &self.chosen()?.prepare;
        prepare.launch(&self.device, stream, n, &arguments)
    }

    /// Selects candidates, all of them or where a grain has moved.
    fn launch_candidates(
        &self,
        g: &EllgranGpuGrains,
        memory: &PairMemory,
        listed: &Listed,
        always: bool,
        stream: Stream,
    ) -> Result<(), Failure> {
        // Candidates do not depend on the step.
        let step = Step {
            time_step: 0.0,
            advance_history: false,
        };
        let (margin, always) = (listed.margin, u32::from(always));
        let arguments = CandidateArguments {
            scene: self.scene_arguments(g, &step)?,
            starts: memory.starts.all(),
            neighbours: listed.neighbours,
            places: self.places.all(),
            states: memory.states.all(),
            histories: memory.histories.all(),
            counts: self.counts.all(),
            notes: self.notes(),
            margin,
            always,
        };
        let candidates = &self.chosen()?.candidates;
        let threads = listed.owned.min(SELECTING_THREADS);
        candidates.launch(&self.device, stream, threads, &arguments)?;
        let arguments = NumberArguments {
            counts: self.counts.all(),
            firsts: self.firsts.all(),
            notes: self.notes(),
            always,
        };
        let number = &self.common.number_candidates;
        let chunks = listed.owned.div_ceil(ROWS_NUMBERED);
        number.launch(&self.device, stream, chunks, &arguments)?;
        let arguments = TermArguments {
            identifiers: array(g.identifiers, g.count, "identifiers")?,
            types: array(g.types, g.count, "types")?,
            starts: memory.starts.all(),
            neighbours: listed.neighbours,
            places: self.places.all(),
            firsts: self.firsts.all(),
            counts: self.counts.all(),
            candidates: self.candidates.all(),
            terms: self.load_terms.all(),
            term_counts: self.load_term_counts.all(),
            notes: self.notes(),
            type_count: self.laws.types() as u32,
            always,
        };
        let terms = &self.common.terms;
        terms.launch(&self.device, stream, threads, &arguments)?;
        let arguments = PoseArguments {
            positions: vectors(&g.positions, g.count, "positions")?,
            bodies: bodies(g)?,
            poses: self.poses.all(),
            notes: self.notes(),
            margin,
            always,
        };
        let remember = &self.common.remember_poses;
        let threads = g.count.min(SELECTING_THREADS);
        remember.launch(&self.device, stream, threads, &arguments)?;
        self.clear_note(MOVED, stream)
    }

    /// Begins with a new list: memory is allocated, histories are carried over, grains prepared, candidates selected.
    ///
    /// # Errors
    /// What is wrong with the arguments, a grain or a row, of this list or of the steps before; a status of a GPU. What was remembered
    /// with the list before is then still there for another call.
    pub fn new_list(
        &mut self,
        g: &EllgranGpuGrains,
        list: &EllgranGpuList,
        stream: Stream,
    ) -> Result<(), Failure> {
        let (owned, count) = (g.owned_count, g.count);
        if owned > count || count > i32::MAX as usize {
            return argument(format!(
                "owned_count = {owned} and count = {count}: there must be no more owned grains than grains, and fewer than 2^31"
            ));
        }
        if !(list.margin >= 0.0 && list.margin <= LARGEST_COORDINATE) {
            return argument(format!(
                "margin = {:?} must be 0 or greater, at most {LARGEST_COORDINATE:e}",
                list.margin
            ));
        }
        let _entered = self.device.enter()?;
        let driver = self.device.driver();
        self.check_pointers(g, list)?;
        self.report_faults(None, stream)?;
        // From here on there is no list, until all is there.
        self.listed = None;
        let mut total = [0u32];
        if owned > 0 {
            let last = address(list.starts, "starts")? + (owned * size_of::<u32>()) as u64;
            driver.copy_out(&mut total, last, stream)?;
        } else {
            driver.synchronise(stream)?;
        }
        let pairs = total[0] as usize;
        let rows = if owned > 0 { owned + 1 } else { 0 };
        let starts = array(list.starts, rows, "starts")?;
        let listed = Listed {
            owned,
            count,
            neighbours: array(list.neighbours, pairs, "neighbours")?,
            margin: list.margin,
            has_changes: !g.velocity_changes.is_null(),
        };
        self.choose(g, stream)?;
        self.allocate(&listed, pairs, stream)?;
        self.faults.clear(stream)?;
        self.motion_faults.clear(stream)?;
        for which in [KEPT, CANDIDATES, FOUND, MARKED] {
            self.clear_note(which, stream)?;
        }
        self.carry_over(g, starts, &listed, stream)?;
        if owned > 0 {
            let from = address(list.starts, "starts")?;
            let bytes = (owned + 1) * size_of::<u32>();
            driver.copy_within(self.other.starts.address(), from, bytes, stream)?;
        }
        if count > 0 {
            let from = address(g.identifiers, "identifiers")?;
            let bytes = count * size_of::<i32>();
            driver.copy_within(self.other.identifiers.address(), from, bytes, stream)?;
        }
        self.launch_prepare(g, None, stream)?;
        // A row that is wrong, or a type, would end the kernels that follow.
        self.report_faults(Some(g), stream)?;
        // Of the pairs that the rows keep any may become a candidate in a later step.
        let kept = self.read_notes(stream)?[KEPT] as usize;
        if kept > i32::MAX as usize || owned > u32::MAX as usize / COMPONENTS {
            return argument(format!(
                "{owned} owned grains with {kept} pairs are too many for one list: at most {} and {}",
                u32::MAX as usize / COMPONENTS,
                i32::MAX
            ));
        }
        self.candidates.resize(kept)?;
        self.contact_loads.resize(kept)?;
        self.marked.resize(kept)?;
        self.launch_candidates(g, &self.other, &listed, true, stream)?;
        let found = self.read_notes(stream)?[CANDIDATES] as usize;
        self.contact_threads = (found + found / 8).max(FEWEST_CONTACT_THREADS).min(kept);
        core::mem::swap(&mut self.now, &mut self.other);
        self.listed = Some(listed);
        Ok(())
    }

    /// Where the driver can tell, all arrays must be on the device.
    fn check_pointers(&self, g: &EllgranGpuGrains, list: &EllgranGpuList) -> Result<(), Failure> {
        if !self.device.checks_pointers {
            return Ok(());
        }
        let pointers: [(u64, &str); 13] = [
            (g.positions.first.addr() as u64, "positions"),
            (g.velocities.first.addr() as u64, "velocities"),
            (g.angular_momenta.first.addr() as u64, "angular_momenta"),
            (g.velocity_changes.addr() as u64, "velocity_changes"),
            (g.masses.addr() as u64, "masses"),
            (g.semi_axes.first.addr() as u64, "semi_axes"),
            (g.quaternions.first.addr() as u64, "quaternions"),
            (g.types.addr() as u64, "types"),
            (g.identifiers.addr() as u64, "identifiers"),
            (g.owners.addr() as u64, "owners"),
            (g.body_places.addr() as u64, "body_places"),
            (list.starts.addr() as u64, "starts"),
            (list.neighbours.addr() as u64, "neighbours"),
        ];
        for (pointer, name) in pointers {
            if pointer != 0 {
                self.device.driver().require_known(pointer, name)?;
            }
        }
        Ok(())
    }

    /// The kernels for the shapes.
    fn choose(&mut self, g: &EllgranGpuGrains, stream: Stream) -> Result<(), Failure> {
        let shapes = match self.stated {
            Some(shapes) => shapes,
            None => {
                self.clear_note(NO_SPHERE, stream)?;
                self.clear_note(NO_SPHEROID, stream)?;
                let arguments = ShapeArguments {
                    bodies: bodies(g)?,
                    notes: self.notes(),
                };
                let find = &self.common.find_shapes;
                find.launch(&self.device, stream, g.count, &arguments)?;
                let notes = self.read_notes(stream)?;
                match (notes[NO_SPHERE], notes[NO_SPHEROID]) {
                    (0, _) => Shapes::Spheres,
                    (_, 0) => Shapes::Spheroids,
                    _ => Shapes::Ellipsoids,
                }
            }
        };
        if self.chosen.as_ref().is_none_or(|c| c.shapes != shapes) {
            let (terms, precision) = (self.terms, self.precision);
            self.chosen = Some(Chosen::new(&self.device, shapes, terms, precision)?);
        }
        Ok(())
    }

    /// The precision of contacts from the next call on. What is remembered is the same in each.
    ///
    /// # Errors
    /// A status of a GPU.
    pub fn set_precision(&mut self, precision: Precision) -> Result<(), Failure> {
        if let Some(shapes) = self.chosen.as_ref().map(|c| c.shapes) {
            let _entered = self.device.enter()?;
            self.chosen = Some(Chosen::new(&self.device, shapes, self.terms, precision)?);
        }
        self.precision = precision;
        Ok(())
    }

    /// Room for a list of so many pairs. Nothing is under way.
    fn allocate(&mut self, listed: &Listed, pairs: usize, stream: Stream) -> Result<(), Failure> {
        let (owned, count) = (listed.owned, listed.count);
        let length = self.laws.layout().length;
        self.grains.resize(count)?;
        self.changes
            .resize(if listed.has_changes { count } else { 0 })?;
        self.inverse_masses
            .resize(if self.terms.mass { count } else { 0 })?;
        self.poses.resize(count)?;
        self.faults.resize(count)?;
        self.motion_faults.resize(owned)?;
        self.places.resize(pairs)?;
        self.firsts.resize(owned)?;
        self.counts.resize(owned)?;
        self.load_terms.resize(pairs)?;
        self.load_term_counts.resize(owned)?;
        // Those of the list before; as many as this one has, so that the next list of the same size takes no more.
        self.slots.resize(slots_for(self.now.owned.max(owned)))?;
        let memory = &mut self.other;
        memory.owned = owned;
        memory.starts.resize(owned + 1)?;
        memory.identifiers.resize(count)?;
        memory.partners.resize(pairs)?;
        memory.states.resize(pairs)?;
        memory.histories.resize(pairs * length)?;
        for wall in &mut memory.walls {
            wall.resize(owned)?;
        }
        if self.has_triangles() {
            self.meshes.resize(owned, stream)?;
        }
        Ok(())
    }

    /// What is remembered goes to the memory of the list that is being made; its rows are checked.
    fn carry_over(
        &self,
        g: &EllgranGpuGrains,
        starts: Array<u32>,
        listed: &Listed,
        stream: Stream,
    ) -> Result<(), Failure> {
        let (now, new) = (&self.now, &self.other);
        let length = self.laws.layout().length as u32;
        let identifiers = array(g.identifiers, listed.count, "identifiers")?;
        let slots: Array<AtomicU64> = self.slots.all_as();
        self.slots.clear(stream)?;
        let arguments = FileArguments {
            identifiers: now.identifiers.all(),
            slots,
        };
        let file = &self.common.file_identifiers;
        file.launch(&self.device, stream, now.owned, &arguments)?;
        let arguments = CarryPairsArguments {
            identifiers,
            starts,
            neighbours: listed.neighbours,
            slots,
            starts_before: now.starts.all(),
            partners_before: now.partners.all(),
            states_before: now.states.all(),
            histories_before: now.histories.all(),
            partners: new.partners.all(),
            states: new.states.all(),
            histories: new.histories.all(),
            faults: self.faults.all(),
            notes: self.notes(),
            length,
        };
        let carry = &self.common.carry_pairs;
        carry.launch(&self.device, stream, listed.owned, &arguments)?;
        for (before, wall) in now.walls.iter().zip(&new.walls) {
            let arguments = CarryWallArguments {
                identifiers,
                slots,
                states_before: before.states.all(),
                histories_before: before.histories.all(),
                states: wall.states.all(),
                histories: wall.histories.all(),
                length: wall.length as u32,
            };
            let carry = &self.common.carry_wall;
            carry.launch(&self.device, stream, listed.owned, &arguments)?;
        }
        Ok(())
    }

    /// Prepares the present grains, and selects candidates anew where one has moved by half of the margin.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    pub fn prepare(&mut self, g: &EllgranGpuGrains, stream: Stream) -> Result<(), Failure> {
        let listed = self.listed_for(g)?;
        let _entered = self.device.enter()?;
        self.launch_prepare(g, Some(listed.margin), stream)?;
        self.launch_candidates(g, &self.now, &listed, false, stream)
    }

    /// Writes the loads of all contacts of the owned grains.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    pub fn compute_pairs(
        &mut self,
        g: &EllgranGpuGrains,
        step: &Step,
        loads: &EllgranGpuLoads,
        stream: Stream,
    ) -> Result<(), Failure> {
        let listed = self.listed_for(g)?;
        // Nothing is started for an address that will not do.
        let forces = vectors(&loads.forces, listed.owned, "forces")?;
        let torques = vectors(&loads.torques, listed.owned, "torques")?;
        if !matches!(loads.add, 0 | 1) {
            return argument(format!("add = {} must be 0 or 1", loads.add));
        }
        let _entered = self.device.enter()?;
        let now = &self.now;
        let arguments = ContactArguments {
            scene: self.scene_arguments(g, step)?,
            candidates: self.candidates.all(),
            states: now.states.all(),
            histories: now.histories.all(),
            contact_loads: self.contact_loads(),
            marked: self.marked.all(),
            notes: self.notes(),
        };
        let (chosen, device) = (self.chosen()?, &self.device);
        let threads = self.contact_threads;
        chosen
            .contacts
            .launch(device, stream, threads, &arguments)?;
        let marked = &chosen.marked_contacts;
        marked.launch(device, stream, threads.min(MARKED_THREADS), &arguments)?;
        let arguments = SumArguments {
            starts: now.starts.all(),
            terms: self.load_terms.all(),
            term_counts: self.load_term_counts.all(),
            contact_loads: self.contact_loads(),
            forces,
            torques,
            notes: self.notes(),
            add: loads.add as u32,
        };
        let sum = &self.common.sum_contacts;
        sum.launch(device, stream, listed.owned * COMPONENTS, &arguments)
    }

    /// Energies and virial of what the contacts are about to be computed from.
    ///
    /// # Errors
    /// Other grains than those of the list; a status of a GPU.
    pub fn tally_pairs(
        &mut self,
        g: &EllgranGpuGrains,
        step: &Step,
        stream: Stream,
    ) -> Result<EllgranGpuTallies, Failure> {
        let listed = self.listed_for(g)?;
        let _entered = self.device.enter()?;
        let threads = self.contact_threads.min(TALLYING_THREADS);
        let mut sums = vec![0.0; threads * TALLIES];
        if threads > 0 {
            if self.tallies.is_none() {
                self.tallies = Some((TallyEntries::new(&self.device)?, Buffer::new(&self.device)));
            }
            let arguments = TallyArguments {
                scene: self.scene_arguments(g, step)?,
                candidates: self.candidates.all(),
                states: self.now.states.all(),
                histories: self.now.histories.all(),
                notes: self.notes(),
                sums: Array::EMPTY,
                threads: threads as u32,
                owned: listed.owned as u32,
            };
            let shapes = self.chosen()?.shapes;
            let Some((entries, buffer)) = &mut self.tallies else {
                return argument("there are no kernels of energies");
            };
            buffer.resize(sums.len())?;
            let arguments = TallyArguments {
                sums: buffer.all(),
                ..arguments
            };
            let kernel = entries.of(shapes);
            kernel.launch_spread(&self.device, stream, threads, &arguments)?;
            let driver = self.device.driver();
            driver.copy_out(&mut sums, buffer.address(), stream)?;
        }
        let mut total = [0.0; TALLIES];
        for own in sums.chunks_exact(TALLIES) {
            for (sum, x) in total.iter_mut().zip(own) {
                *sum += x;
            }
        }
        let [normal, tangential, virial @ ..] = total;
        Ok(EllgranGpuTallies {
            size: size_of::<EllgranGpuTallies>(),
            normal_elastic_energy: normal,
            tangential_elastic_energy: tangential,
            virial,
        })
    }

    /// One more plane: its number.
    ///
    /// # Errors
    /// Too little memory.
    pub fn add_plane(&mut self, stream: Stream) -> Result<usize, Failure> {
        let _entered = self.device.enter()?;
        let length = self.laws.layout().length;
        self.add_memory(WallKind::Plane, length, stream)
    }

    /// One more wall, with copies of its parts: its number.
    ///
    /// # Errors
    /// A wall without parts, or with triangles that are lent; too little memory.
    pub fn add_wall(&mut self, wall: &Wall, stream: Stream) -> Result<usize, Failure> {
        let surfaces = match wall.surfaces() {
            Ok(surfaces) if surfaces.is_empty() => return argument("the wall has no parts"),
            Ok(surfaces) => surfaces,
            Err(_) => return self.add_wall_with_triangles(wall, stream),
        };
        let _entered = self.device.enter()?;
        // More than these there are not.
        let WallHistoryLayout {
            history, records, ..
        } = wall.histories(&self.laws);
        let layout = WallHistoryLayout::new(history, records.min(MOST_CONTACTS));
        assert!(history <= LONGEST_HISTORY);
        if self.wall_entry.is_none() {
            self.wall_entry = Some(WallEntry::new(&self.device)?);
        }
        let mut buffer = Buffer::new(&self.device);
        buffer.resize(surfaces.len())?;
        let driver = self.device.driver();
        driver.copy_in(buffer.address(), &surfaces, stream)?;
        driver.synchronise(stream)?;
        self.add_memory(WallKind::Surfaces(buffer, layout), layout.length(), stream)
    }

    fn add_wall_with_triangles(&mut self, wall: &Wall, stream: Stream) -> Result<usize, Failure> {
        let own = match wall.parts_with_triangles() {
            Ok(own) => own,
            Err(part) => {
                return argument(format!(
                    "part {part} of the wall, counted from 0, is of triangles that are lent, for which there is no kernel: add them as a \
                     mesh, or use the functions of ellgran.h on the host"
                ))
            }
        };
        let _entered = self.device.enter()?;
        let WallHistoryLayout {
            history, records, ..
        } = wall.histories(&self.laws);
        let layout = WallHistoryLayout::new(history, records.min(MOST_RECORDS));
        assert!(history <= LONGEST_HISTORY);
        if self.meshes.entries.is_none() {
            self.meshes.entries = Some(MeshEntries::new(&self.device)?);
        }
        let parts = PartsOnDevice::new(&self.device, &own, stream)?;
        self.meshes.resize(self.now.owned, stream)?;
        self.add_memory(
            WallKind::Parts(Box::new(parts), layout),
            layout.length(),
            stream,
        )
    }

    fn has_triangles(&self) -> bool {
        let is_of_triangles = |wall: &WallKind| matches!(wall, WallKind::Parts(..));
        self.walls.iter().any(is_of_triangles)
    }

    /// Memory of one more wall, which remembers `length` doubles of each grain: its number.
    fn add_memory(
        &mut self,
        kind: WallKind,
        length: usize,
        stream: Stream,
    ) -> Result<usize, Failure> {
        let mut wall = WallMemory::new(&self.device, length);
        wall.resize(self.now.owned)?;
        wall.states.clear(stream)?;
        wall.histories.clear(stream)?;
        self.now.walls.push(wall);
        self.other.walls.push(WallMemory::new(&self.device, length));
        self.walls.push(kind);
        Ok(self.walls.len() - 1)
    }

    fn wall(&self, number: i32) -> Result<(&WallKind, &WallMemory), Failure> {
        let found = usize::try_from(number).ok().and_then(|k| {
            let kind = self.walls.get(k)?;
            Some((kind, self.now.walls.get(k)?))
        });
        match found {
            Some(wall) => Ok(wall),
            None => argument(format!(
                "there is no wall {number}: ellgran_gpu_add_plane and ellgran_gpu_add_wall have made {}",
                self.walls.len()
            )),
        }
    }

    /// A type of a wall that is one of the laws.
    fn wall_type(&self, wall_type: i32) -> Result<u32, Failure> {
        let types = self.laws.types();
        match u32::try_from(wall_type) {
            Ok(t) if t >= 1 && t as usize <= types => Ok(t),
            _ => argument(format!(
                "wall_type = {wall_type} must be between 1 and {types}"
            )),
        }
    }

    /// Adds the loads of a plane.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    #[allow(clippy::too_many_arguments)]
    pub fn compute_plane(
        &mut self,
        g: &EllgranGpuGrains,
        number: i32,
        plane: &MovingPlane,
        wall_type: i32,
        step: &Step,
        loads: &EllgranGpuLoads,
        stream: Stream,
    ) -> Result<(), Failure> {
        let listed = self.listed_for(g)?;
        let (WallKind::Plane, wall) = self.wall(number)? else {
            return argument(format!(
                "wall {number} is no plane: call ellgran_gpu_compute_wall"
            ));
        };
        let wall_type = self.wall_type(wall_type)?;
        let _entered = self.device.enter()?;
        let arguments = PlaneArguments {
            scene: self.scene_arguments(g, step)?,
            point: plane.plane.point,
            normal: plane.plane.normal,
            velocity: plane.velocity,
            velocity_change: plane.velocity_change,
            states: wall.states.all(),
            histories: wall.histories.all(),
            forces: vectors(&loads.forces, listed.owned, "forces")?,
            torques: vectors(&loads.torques, listed.owned, "torques")?,
            wall_type,
        };
        let plane = &self.chosen()?.plane;
        plane.launch(&self.device, stream, listed.owned, &arguments)
    }

    /// Adds the loads of a wall.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    #[allow(clippy::too_many_arguments)]
    pub fn compute_wall(
        &mut self,
        g: &EllgranGpuGrains,
        number: i32,
        motion: &Motion,
        wall_type: i32,
        step: &Step,
        loads: &EllgranGpuLoads,
        stream: Stream,
    ) -> Result<(), Failure> {
        let listed = self.listed_for(g)?;
        let (surfaces, layout, wall) = match self.wall(number)? {
            (WallKind::Surfaces(surfaces, layout), wall) => (surfaces, layout, wall),
            (WallKind::Parts(parts, layout), wall) => {
                let arguments = MeshArguments {
                    scene: self.scene_arguments(g, step)?,
                    parts: parts.parts.all(),
                    triangles: parts.triangles.all(),
                    boxes: parts.boxes.all(),
                    widths: parts.widths.all(),
                    nodes: parts.nodes.all(),
                    order: parts.order.all(),
                    motion: WallMotion::from(motion),
                    states: wall.states.all(),
                    histories: wall.histories.all(),
                    forces: vectors(&loads.forces, listed.owned, "forces")?,
                    torques: vectors(&loads.torques, listed.owned, "torques")?,
                    faults: self.faults.all(),
                    notes: self.notes(),
                    near: self.meshes.near.all(),
                    crowded: self.meshes.crowded.all(),
                    counts: self.meshes.counts.all_as(),
                    rooms: self.meshes.rooms.all(),
                    large_rooms: self.meshes.large_rooms.all(),
                    room_bytes: size_of::<SmallRoom>() as u64,
                    large_room_bytes: size_of::<LargeRoom>() as u64,
                    ellipsoids: u32::from(self.chosen()?.shapes == Shapes::Ellipsoids),
                    is_crowded: 0,
                    wall_type: self.wall_type(wall_type)?,
                    records: layout.records as u32,
                };
                return self.launch_mesh(&listed, arguments, stream);
            }
            (WallKind::Plane, _) => {
                return argument(format!(
                    "wall {number} is a plane: call ellgran_gpu_compute_plane"
                ))
            }
        };
        let wall_type = self.wall_type(wall_type)?;
        let _entered = self.device.enter()?;
        let arguments = WallArguments {
            scene: self.scene_arguments(g, step)?,
            surfaces: surfaces.all(),
            motion: WallMotion::from(motion),
            states: wall.states.all(),
            histories: wall.histories.all(),
            forces: vectors(&loads.forces, listed.owned, "forces")?,
            torques: vectors(&loads.torques, listed.owned, "torques")?,
            faults: self.faults.all(),
            notes: self.notes(),
            ellipsoids: u32::from(self.chosen()?.shapes == Shapes::Ellipsoids),
            wall_type,
            records: layout.records as u32,
        };
        let Some(WallEntry(entry)) = &self.wall_entry else {
            return argument("the scene has no such wall");
        };
        entry.launch(&self.device, stream, listed.owned, &arguments)
    }

    /// Which grains are near a wall with triangles, and then their contacts.
    fn launch_mesh(
        &self,
        listed: &Listed,
        mut arguments: MeshArguments<OnDevice>,
        stream: Stream,
    ) -> Result<(), Failure> {
        let _entered = self.device.enter()?;
        self.meshes.counts.clear(stream)?;
        let (device, meshes) = (&self.device, &self.meshes);
        let Some(entries) = &meshes.entries else {
            return argument("the scene has no wall with triangles");
        };
        let near = entries.near(self.chosen()?.shapes);
        near.launch(device, stream, listed.owned, &arguments)?;
        let mesh = &entries.contacts;
        mesh.launch_spread(device, stream, meshes.rooms.len(), &arguments)?;
        arguments.is_crowded = 1;
        mesh.launch_spread(device, stream, meshes.large_rooms.len(), &arguments)
    }

    fn motion_arguments(
        &self,
        m: &EllgranGpuMotion,
        time_step: f64,
    ) -> Result<MotionArguments<OnDevice>, Failure> {
        let n = m.count;
        match self.listed {
            Some(listed) if listed.owned == n => {}
            _ => {
                return argument(format!(
                    "count = {n} of the motion is not the number of owned grains of a list: call ellgran_gpu_new_list first"
                ))
            }
        }
        let in_range = |t: f64| (0.0..=LONGEST_TIME_STEP).contains(&t);
        for (t, name) in [
            (time_step, "time_step"),
            (m.time_step_before, "time_step_before"),
        ] {
            if !in_range(t) {
                return argument(format!(
                    "{name} = {t:?} must be a finite number, 0 or greater, at most {LONGEST_TIME_STEP:e}"
                ));
            }
        }
        let before = if m.time_step_before == 0.0 {
            time_step
        } else {
            m.time_step_before
        };
        let loads_before = if m.velocity_changes.is_null() {
            Array::EMPTY
        } else {
            array(m.loads_before, n, "loads_before")?
        };
        let body_count = if m.body_places.is_null() {
            n
        } else {
            m.body_count
        };
        Ok(MotionArguments {
            positions: vectors(&m.positions, n, "positions")?,
            velocities: vectors(&m.velocities, n, "velocities")?,
            angular_momenta: vectors(&m.angular_momenta, n, "angular_momenta")?,
            places: optional(m.body_places, n),
            quaternions: vectors(&m.quaternions, body_count, "quaternions")?,
            semi_axes: vectors(&m.semi_axes, body_count, "semi_axes")?,
            masses: array(m.masses, n, "masses")?,
            forces: vectors(&m.forces, n, "forces")?,
            torques: vectors(&m.torques, n, "torques")?,
            changes: optional(m.velocity_changes, n),
            loads_before,
            faults: self.motion_faults.all(),
            notes: self.notes(),
            step_ratio: if time_step > 0.0 {
                time_step / before
            } else {
                1.0
            },
            time_step,
        })
    }

    /// The first half of a step.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    pub fn start_step(
        &mut self,
        m: &EllgranGpuMotion,
        time_step: f64,
        stream: Stream,
    ) -> Result<(), Failure> {
        let arguments = self.motion_arguments(m, time_step)?;
        let _entered = self.device.enter()?;
        let start = &self.common.start_step;
        start.launch(&self.device, stream, m.count, &arguments)
    }

    /// The second half of a step.
    ///
    /// # Errors
    /// What is wrong with the arguments; a status of a GPU.
    pub fn finish_step(
        &mut self,
        m: &EllgranGpuMotion,
        time_step: f64,
        stream: Stream,
    ) -> Result<(), Failure> {
        let arguments = self.motion_arguments(m, time_step)?;
        let _entered = self.device.enter()?;
        let finish = &self.common.finish_step;
        finish.launch(&self.device, stream, m.count, &arguments)
    }

    /// Waits for what was started, and tells of the first grain with which something is wrong since the last call of this or of
    /// [`Scene::new_list`].
    ///
    /// # Errors
    /// That grain; a status of a GPU.
    pub fn check(&mut self, g: &EllgranGpuGrains, stream: Stream) -> Result<(), Failure> {
        self.listed_for(g)?;
        let _entered = self.device.enter()?;
        self.report_faults(Some(g), stream)
    }

    /// `g` are the grains for which faults were found; without them their values have been lost.
    fn report_faults(&self, g: Option<&EllgranGpuGrains>, stream: Stream) -> Result<(), Failure> {
        if self.read_notes(stream)?[FAULT] == 0 {
            return Ok(());
        }
        let driver = self.device.driver();
        let first = |faults: &Buffer<u32>| -> Result<Option<(usize, u32)>, Failure> {
            let mut read = vec![0u32; faults.len()];
            driver.copy_out(&mut read, faults.address(), stream)?;
            Ok(read.into_iter().enumerate().find(|(_, fault)| *fault != 0))
        };
        let (moving, prepared) = (first(&self.motion_faults)?, first(&self.faults)?);
        self.motion_faults.clear(stream)?;
        self.faults.clear(stream)?;
        self.clear_note(FAULT, stream)?;
        // A grain that could not be moved is what was wrong first.
        let found = match (moving, prepared) {
            (Some((k, fault)), _) => Some((k, motion_words(fault).to_owned())),
            (None, Some((k, fault))) => Some((k, self.prepared_words(k, fault, g, stream)?)),
            (None, None) => None,
        };
        let Some((k, what)) = found else {
            return Ok(());
        };
        let identifier = match g {
            Some(g) => self.read::<i32, 1>(g.identifiers.addr(), k, stream)?,
            None => self.read(self.now.identifiers.address() as usize, k, stream)?,
        };
        Err(Failure::new(
            ELLGRAN_ERROR_PARTICLE,
            format!("particle {}: {what}", identifier[0]),
        ))
    }

    /// Entry `k` of an array of the device.
    fn read<T: crate::driver_library::Number + Default, const N: usize>(
        &self,
        address: usize,
        k: usize,
        stream: Stream,
    ) -> Result<[T; N], Failure> {
        let mut values = [T::default(); N];
        let at = address as u64 + (k * N * size_of::<T>()) as u64;
        self.device.driver().copy_out(&mut values, at, stream)?;
        Ok(values)
    }

    /// What is wrong with a grain that cannot be prepared, or with its row, with the values that it has now.
    fn prepared_words(
        &self,
        k: usize,
        fault: u32,
        g: Option<&EllgranGpuGrains>,
        stream: Stream,
    ) -> Result<String, Failure> {
        let is = |of: Fault| fault == of as u32;
        // Where the vectors of this grain are, or only what they are called.
        let value = |name: &str, place: &dyn Fn(&EllgranGpuGrains) -> Found| {
            let Some(g) = g else {
                return Ok(name.to_owned());
            };
            let places = place(g)?;
            let read = |at: u64| Ok::<_, Failure>(self.read::<f64, 1>(at as usize, 0, stream)?[0]);
            let numbers: Vec<f64> = places.into_iter().map(read).collect::<Result<_, _>>()?;
            Ok::<_, Failure>(format!("{name} = {numbers:?}"))
        };
        let named = |table: *const i32, k: usize| -> Result<usize, Failure> {
            if table.is_null() {
                return Ok(k);
            }
            Ok(self.read::<i32, 1>(table.addr(), k, stream)?[0] as usize)
        };
        let owner = |g: &EllgranGpuGrains| named(g.owners, k);
        let body = |g: &EllgranGpuGrains| named(g.body_places, owner(g)?);
        let velocity = |g: &EllgranGpuGrains| components::<3>(&g.velocities, owner(g)?);
        let momentum = |g: &EllgranGpuGrains| components::<3>(&g.angular_momenta, owner(g)?);
        let semi_axes = |g: &EllgranGpuGrains| components::<3>(&g.semi_axes, body(g)?);
        Ok(if is(Fault::Position) {
            format!(
                "{}: components must be finite and at most {LARGEST_COORDINATE:e}",
                value("position", &|g| components::<3>(&g.positions, k))?
            )
        } else if is(Fault::Velocity) {
            format!(
                "{}: components at the half step must be finite and at most {LARGEST_VELOCITY:e}",
                value("velocity", &velocity)?
            )
        } else if is(Fault::AngularVelocity) {
            format!(
                "{}: the angular velocity that goes with it must be finite, its components at most {LARGEST_VELOCITY:e}",
                value("angular momentum", &momentum)?
            )
        } else if is(Fault::Mass) {
            format!(
                "{} must be finite and within the range of masses",
                value("mass", &|g| Ok(vec![
                    g.masses.addr() as u64 + (owner(g)? * size_of::<f64>()) as u64
                ]))?
            )
        } else if is(Fault::Type) {
            let given = match g {
                Some(g) => format!(" = {}", self.read::<i32, 1>(g.types.addr(), k, stream)?[0]),
                None => String::new(),
            };
            format!(
                "type{given} must be between 1 and {}, the number of types of the laws",
                self.laws.types()
            )
        } else if is(Fault::SemiAxis) {
            format!(
                "{} must be finite, greater than 0 and within the range of semi-axes",
                value("semi-axes", &semi_axes)?
            )
        } else if is(Fault::AspectRatio) {
            format!(
                "{}: the largest must be at most 1e6 times the smallest",
                value("semi-axes", &semi_axes)?
            )
        } else if is(Fault::Quaternion) {
            format!(
                "{} must be finite and not zero",
                value("quaternion (w, x, y, z)", &|g| components::<4>(
                    &g.quaternions,
                    body(g)?
                ))?
            )
        } else if is(Fault::Kind) {
            format!(
                "{} are not of the shapes that the scene was made for: make it with ELLGRAN_GPU_ANY_SHAPES",
                value("semi-axes", &semi_axes)?
            )
        } else if is(Fault::Place) {
            "its entry in owners is no owned grain, or its entry in body_places is not below body_count".to_owned()
        } else if fault == TOO_MANY_CONTACTS {
            format!("it touches one wall in more than {MOST_CONTACTS} places, for which a kernel has no room: use the host")
        } else if fault == TOO_MANY_TRIANGLES {
            format!(
                "it is near more than {MOST_TRIANGLES} triangles of one wall, or touches so many of their faces, edges and corners that a kernel has \
                 no room: use larger triangles, or the host"
            )
        } else if fault == WRONG_ROW {
            format!("starts[{k}] and starts[{}] are no row of the list", k + 1)
        } else if fault == WRONG_NEIGHBOUR {
            "its row names a neighbour that is not one of the grains, or itself".to_owned()
        } else if fault == NAMED_TWICE {
            "its row names a neighbour twice".to_owned()
        } else if fault == HALF_LIST {
            "its row names a grain whose row does not name it: the list must be full, with each pair of owned grains twice".to_owned()
        } else {
            format!("fault {fault}")
        })
    }

    /// What is remembered of pairs, or of a plane or wall.
    ///
    /// # Errors
    /// There is no such wall, or no list.
    pub fn histories(&self, wall: Option<i32>) -> Result<EllgranGpuHistories, Failure> {
        if self.listed.is_none() {
            return argument("there is no list yet: call ellgran_gpu_new_list first");
        }
        let (states, histories, length) = match wall {
            None => (
                &self.now.states,
                &self.now.histories,
                self.laws.layout().length,
            ),
            Some(number) => {
                let (_, wall) = self.wall(number)?;
                (&wall.states, &wall.histories, wall.length)
            }
        };
        let pointer = |address: u64| core::ptr::without_provenance_mut::<f64>(address as usize);
        Ok(EllgranGpuHistories {
            size: size_of::<EllgranGpuHistories>(),
            count: states.len(),
            length,
            touching: pointer(states.address()).cast(),
            histories: pointer(histories.address()),
        })
    }

    /// Copies what is remembered of pairs, or of a plane, to the host. Waits for what was started.
    ///
    /// # Errors
    /// There is no such plane, or no list; arrays of another length; a status of a GPU.
    pub fn read_histories(
        &self,
        plane: Option<i32>,
        touching: &mut [u32],
        histories: &mut [f64],
        stream: Stream,
    ) -> Result<(), Failure> {
        let held = self.histories(plane)?;
        let (states, values) = require_lengths(&held, touching.len(), histories.len())?;
        let _entered = self.device.enter()?;
        let driver = self.device.driver();
        driver.synchronise(stream)?;
        if !touching.is_empty() {
            driver.copy_out(touching, states, stream)?;
        }
        if !histories.is_empty() {
            driver.copy_out(histories, values, stream)?;
        }
        Ok(())
    }

    /// Takes what is remembered of pairs, or of a plane, from the host, in place of all that there was. What a pair remembers that cannot
    /// touch is forgotten.
    ///
    /// # Errors
    /// There is no such plane, or no list; arrays of another length; other grains than those of the list; a status of a GPU.
    pub fn write_histories(
        &mut self,
        g: &EllgranGpuGrains,
        plane: Option<i32>,
        touching: &[u32],
        histories: &[f64],
        stream: Stream,
    ) -> Result<(), Failure> {
        let listed = self.listed_for(g)?;
        let held = self.histories(plane)?;
        let (states, values) = require_lengths(&held, touching.len(), histories.len())?;
        if let Some(k) = touching.iter().position(|&state| state > 1) {
            return argument(format!("touching[{k}] = {} must be 0 or 1", touching[k]));
        }
        if plane.is_none() {
            require_written(&self.laws, touching, histories, held.length)?;
        }
        let _entered = self.device.enter()?;
        let driver = self.device.driver();
        driver.synchronise(stream)?;
        driver.copy_in(states, touching, stream)?;
        driver.copy_in(values, histories, stream)?;
        // Before the caller's arrays go.
        driver.synchronise(stream)?;
        if plane.is_some() {
            return Ok(());
        }
        self.launch_candidates(g, &self.now, &listed, true, stream)?;
        let (found, kept) = (
            self.read_notes(stream)?[CANDIDATES] as usize,
            self.candidates.len(),
        );
        self.contact_threads = (found + found / 8).max(FEWEST_CONTACT_THREADS).min(kept);
        Ok(())
    }

    /// How the host and this scene keep what is remembered of a wall; `part` is that of a plane of the scene.
    ///
    /// # Errors
    /// There is no such wall; a part that is no plane.
    pub fn wall_histories(
        &self,
        number: i32,
        host: (&Wall, &Laws),
        part: i32,
    ) -> Result<WallHistories, Failure> {
        let layout = match self.wall(number)?.0 {
            WallKind::Plane => None,
            WallKind::Surfaces(_, layout) | WallKind::Parts(_, layout) => Some(*layout),
        };
        let part = usize::try_from(part).unwrap_or(usize::MAX);
        WallHistories::new(host, (&self.laws, layout), part)
            .map_err(|what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what))
    }

    /// How many grains the list has of its own.
    ///
    /// # Errors
    /// There is no list yet.
    pub fn owned(&self) -> Result<usize, Failure> {
        match &self.listed {
            Some(_) => Ok(self.now.owned),
            None => argument("there is no list yet: call ellgran_gpu_new_list first"),
        }
    }

    /// Adds what is remembered of a wall to histories of the host. Waits for what was started.
    ///
    /// # Errors
    /// There is no such wall, or no list; a status of a GPU.
    pub fn read_wall_histories(
        &self,
        number: i32,
        forms: &WallHistories,
        histories: &mut [f64],
        stream: Stream,
    ) -> Result<(), Failure> {
        let held = self.histories(Some(number))?;
        let mut states = vec![0; held.count];
        let mut values = vec![0.0; held.count * held.length];
        self.read_histories(Some(number), &mut states, &mut values, stream)?;
        if forms.length() == 0 || held.length == 0 {
            return Ok(());
        }
        let of_grains = values.chunks_exact(held.length);
        let to_grains = histories.chunks_exact_mut(forms.length());
        for ((&state, from), to) in states.iter().zip(of_grains).zip(to_grains) {
            forms.add_to_host(state, from, to);
        }
        Ok(())
    }

    /// Takes what is remembered of a wall from histories of the host, in place of all that there was.
    ///
    /// # Errors
    /// There is no such wall, or no list; other grains than those of the list; a number that no call has written; a status of a GPU.
    pub fn write_wall_histories(
        &mut self,
        g: &EllgranGpuGrains,
        number: i32,
        forms: &WallHistories,
        histories: &[f64],
        stream: Stream,
    ) -> Result<(), Failure> {
        let held = self.histories(Some(number))?;
        let mut states = vec![0; held.count];
        let mut values = vec![0.0; held.count * held.length];
        if forms.length() > 0 && held.length > 0 {
            let of_grains = histories.chunks_exact(forms.length());
            let to_grains = values.chunks_exact_mut(held.length);
            for (k, ((state, from), to)) in
                states.iter_mut().zip(of_grains).zip(to_grains).enumerate()
            {
                if let Some((place, value)) = forms.first_wrong(from) {
                    return argument(format!(
                        "histories[{}] = {value} of grain {k}, counted from 0, with wall {number}: ellgran_gpu_read_wall_histories and \
                         ellgran_compute_wall write no such number",
                        k * forms.length() + place
                    ));
                }
                *state = forms.to_scene(from, to);
            }
        }
        self.write_histories(g, Some(number), &states, &values, stream)
    }

    /// What was done, and what is held. Waits for what was started.
    ///
    /// # Errors
    /// A status of a GPU.
    pub fn counts(&self, stream: Stream) -> Result<EllgranGpuCounts, Failure> {
        let _entered = self.device.enter()?;
        let bytes = self.table.bytes()
            + self.grains.bytes()
            + self.changes.bytes()
            + self.inverse_masses.bytes()
            + self.poses.bytes()
            + self.candidates.bytes()
            + self.contact_loads.bytes()
            + self.marked.bytes()
            + self.places.bytes()
            + self.firsts.bytes()
            + self.counts.bytes()
            + self.load_terms.bytes()
            + self.load_term_counts.bytes()
            + self.faults.bytes()
            + self.motion_faults.bytes()
            + self.notes.bytes()
            + self.slots.bytes()
            + (self.walls.iter())
                .map(|wall| match wall {
                    WallKind::Plane => 0,
                    WallKind::Surfaces(surfaces, _) => surfaces.bytes(),
                    WallKind::Parts(parts, _) => parts.bytes(),
                })
                .sum::<usize>()
            + self.meshes.bytes()
            + self.tallies.as_ref().map_or(0, |(_, sums)| sums.bytes())
            + self.now.bytes()
            + self.other.bytes();
        Ok(EllgranGpuCounts {
            size: size_of::<EllgranGpuCounts>(),
            selections: u64::from(self.read_notes(stream)?[SELECTIONS]),
            bytes: bytes as u64,
            shapes: match self.chosen.as_ref().map(|c| c.shapes) {
                None => 0,
                Some(Shapes::Spheres) => i64::from(crate::arrays::ELLGRAN_GPU_SPHERES),
                Some(Shapes::Spheroids) => i64::from(crate::arrays::ELLGRAN_GPU_SPHEROIDS),
                Some(Shapes::Ellipsoids) => i64::from(crate::arrays::ELLGRAN_GPU_ELLIPSOIDS),
            },
        })
    }
}

/// Where states and histories are, if arrays of the host are as long.
fn require_lengths(
    held: &EllgranGpuHistories,
    states: usize,
    values: usize,
) -> Result<(u64, u64), Failure> {
    let wanted = (held.count, held.count * held.length);
    if (states, values) != wanted {
        return argument(format!(
            "{states} states and {values} doubles of histories were given where there are {} and {}",
            wanted.0, wanted.1
        ));
    }
    Ok((held.touching.addr() as u64, held.histories.addr() as u64))
}

/// Whether the histories of pairs that touch are such as calls have written.
fn require_written(
    laws: &Laws,
    touching: &[u32],
    histories: &[f64],
    length: usize,
) -> Result<(), Failure> {
    let layout = laws.layout();
    for (k, _) in touching.iter().enumerate().filter(|(_, &t)| t == 1) {
        let of_pair = &histories[k * length..(k + 1) * length];
        if let Some((place, value)) = layout.first_wrong(of_pair) {
            return argument(format!(
                "histories[{}] = {value} of entry {k} of the list: ellgran_gpu_read_histories and ellgran_compute_pairs write no such \
                 number",
                k * length + place
            ));
        }
    }
    Ok(())
}

/// Addresses of the components of a vector.
type Found = Result<Vec<u64>, Failure>;

fn components<const N: usize>(given: &EllgranGpuVectors, k: usize) -> Found {
    let array = vectors::<N>(given, k + 1, "vectors")?;
    Ok((0..N).map(|c| array.place(k, c)).collect())
}

/// What is wrong with a grain that cannot be moved: the numbers are those of the kernel.
fn motion_words(fault: u32) -> &'static str {
    match fault {
        1 => "it has no shape",
        2 => "its quaternion must be finite and not zero",
        3 => "its mass must be a finite number greater than 0",
        4 => "it would turn by more than half a circle in a step: take a smaller time step",
        5 => "its rotation would grow within the step: take a smaller time step",
        6 => "a semi-axis must be finite, greater than 0 and within the range of semi-axes",
        _ => "it cannot be moved",
    }
}
