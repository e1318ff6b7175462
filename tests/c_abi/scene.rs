// SPDX-License-Identifier: MIT OR Apache-2.0
//! Laws, bodies, and the arrays of an engine.

use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::ptr;

use ellgran::c_api::contact::{
    ellgran_contact, EllgranBody, EllgranContactForce, EllgranContactGeometry,
};
use ellgran::c_api::growing::Growing;
use ellgran::c_api::law::*;
use ellgran::c_api::neighbour_list::{ellgran_compute_pairs, EllgranNeighbourList};
use ellgran::c_api::particles::*;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;
use ellgran::c_api::tallies::EllgranTallies;

pub use crate::formulas::Random;

/// Succeeds, or shows the library's own message.
#[track_caller]
pub fn ok(status: i32) {
    assert_eq!(status, ELLGRAN_SUCCESS, "{}", message());
}

/// Fails with this status and a message that holds these words.
#[track_caller]
pub fn fails(status: i32, expected: i32, words: &[&str]) {
    let message = message();
    assert_eq!(status, expected, "{message}");
    for word in words {
        assert!(message.contains(word), "'{word}' is not in: {message}");
    }
}

pub fn message() -> String {
    // SAFETY: never NULL and ends with NUL.
    let text = unsafe { CStr::from_ptr(ellgran_last_error()) };
    text.to_str().expect("UTF-8").to_owned()
}

/// Calls the parser with the words of a line.
pub fn parse_status(deck: &str, consumed: *mut usize, out: *mut EllgranLawParameters) -> i32 {
    let words: Vec<CString> = deck
        .split_whitespace()
        .map(|word| CString::new(word).unwrap())
        .collect();
    let pointers: Vec<_> = words.iter().map(|word| word.as_ptr()).collect();
    // SAFETY: the strings live to the end of the call; the outputs are the caller's.
    unsafe { ellgran_law_parameters_parse(pointers.len(), pointers.as_ptr(), consumed, out) }
}

pub fn parse(deck: &str) -> EllgranLawParameters {
    let mut out = Untouched::sized();
    ok(parse_status(deck, ptr::null_mut(), out.pointer()));
    // SAFETY: written on success.
    unsafe { *out.pointer() }
}

/// Laws of as many types as there are lines; pairs of types are mixed.
pub struct Laws(pub *mut EllgranLaws);

impl Laws {
    pub fn new(decks: &[&str]) -> Laws {
        Laws::with_options(decks, 0)
    }

    pub fn with_options(decks: &[&str], options: u32) -> Laws {
        let types = decks.len();
        let mut parameters = vec![parse(decks[0]); types * types];
        let mut set = vec![0; types * types];
        for (k, deck) in decks.iter().enumerate() {
            parameters[k * (types + 1)] = parse(deck);
            set[k * (types + 1)] = 1;
        }
        let mut laws = ptr::null_mut();
        // SAFETY: the arrays have types * types entries.
        ok(unsafe {
            ellgran_laws_new(
                types as i32,
                parameters.as_ptr(),
                set.as_ptr(),
                options,
                &mut laws,
            )
        });
        Laws(laws)
    }

    pub fn length(&self) -> usize {
        // SAFETY: valid since it was made.
        unsafe { ellgran_laws_history_length(self.0) as usize }
    }
}

impl Laws {
    /// One contact that succeeds; `history` is as long as one of these laws.
    #[track_caller]
    pub fn contact(
        &self,
        [i, j]: [&EllgranBody; 2],
        step: &EllgranStep,
        touching: &mut i32,
        history: &mut [f64],
    ) -> (EllgranContactGeometry, EllgranContactForce) {
        assert_eq!(history.len(), self.length());
        let (mut geometry, mut force) = (Untouched::sized(), Untouched::sized());
        let (g, f) = (geometry.pointer(), force.pointer());
        // SAFETY: all pointers are valid; both structs are written on success.
        unsafe {
            ok(ellgran_contact(
                self.0,
                i,
                j,
                step,
                touching,
                history.as_mut_ptr(),
                g,
                f,
            ));
            (*g, *f)
        }
    }

    /// Status of a call on a list. The arrays that the structs name must be as long as they say.
    pub fn pairs(
        &self,
        workspace: &WorkspaceHandle,
        particles: &EllgranParticles,
        list: &EllgranNeighbourList,
        step: &EllgranStep,
        tallies: *mut EllgranTallies,
    ) -> i32 {
        // SAFETY: as the caller promises.
        unsafe { ellgran_compute_pairs(self.0, workspace.0, particles, list, step, tallies) }
    }
}

impl Drop for Laws {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_laws_new and not used again.
        unsafe { ellgran_laws_free(self.0) }
    }
}

/// A wall.
pub struct WallHandle(pub *mut EllgranWall);

impl WallHandle {
    pub fn new() -> WallHandle {
        let mut wall = ptr::null_mut();
        // SAFETY: valid for writes.
        ok(unsafe { ellgran_wall_new(&mut wall) });
        WallHandle(wall)
    }

    /// A plane; the particles are on the side of its normal.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> WallHandle {
        let wall = WallHandle::new();
        let shape = EllgranWallShape {
            point,
            axis: normal,
            side: ELLGRAN_SIDE_INSIDE,
            ..shape(c"plane")
        };
        // SAFETY: valid pointers.
        ok(unsafe { ellgran_wall_add_shape(wall.0, &shape) });
        wall
    }

    /// What is remembered of these many particles at first.
    pub fn histories(&self, laws: &Laws, particles: usize) -> Vec<f64> {
        // SAFETY: valid pointers.
        vec![0.0; particles * unsafe { ellgran_wall_histories_length(self.0, laws.0) }]
    }
}

impl Drop for WallHandle {
    fn drop(&mut self) {
        // SAFETY: not used again.
        unsafe { ellgran_wall_free(self.0) }
    }
}

/// A shape at the origin along z of which nothing else is said.
pub fn shape(name: &CStr) -> EllgranWallShape {
    EllgranWallShape {
        size: size_of::<EllgranWallShape>(),
        name: name.as_ptr(),
        point: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radii: [0.0; 2],
        bounds: [0.0; 2],
        ends: [ELLGRAN_END_NONE; 2],
        side: ELLGRAN_SIDE_OF_CENTRE,
        unused: 0,
    }
}

/// A wall at rest where it was described.
pub const REST: EllgranWallMotion = EllgranWallMotion {
    size: size_of::<EllgranWallMotion>(),
    origin: [0.0; 3],
    displacement: [0.0; 3],
    quaternion: [0.0; 4],
    velocity: [0.0; 3],
    angular_velocity: [0.0; 3],
    along_itself: 0,
    unused: 0,
    velocity_change: [0.0; 3],
    angular_velocity_change: [0.0; 3],
};

/// To be written by a call.
pub const NO_LOAD: EllgranWallLoad = EllgranWallLoad {
    size: size_of::<EllgranWallLoad>(),
    force: [0.0; 3],
    torque: [0.0; 3],
    power: 0.0,
    contact_count: 0,
    stiffness: 0.0,
    damping: 0.0,
    crowded_particle: 0,
    viscous_force: [0.0; 3],
    viscous_torque: [0.0; 3],
    tangential_force: [0.0; 3],
    tangential_torque: [0.0; 3],
};

pub struct WorkspaceHandle(pub *mut EllgranWorkspace);

impl WorkspaceHandle {
    pub fn new() -> WorkspaceHandle {
        let mut workspace = ptr::null_mut();
        // SAFETY: valid for writes.
        ok(unsafe { ellgran_workspace_new(&mut workspace) });
        WorkspaceHandle(workspace)
    }
}

impl Drop for WorkspaceHandle {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_workspace_new and not used again.
        unsafe { ellgran_workspace_free(self.0) }
    }
}

/// Output filled with a pattern, to see that a failing call leaves it alone.
pub struct Untouched<T> {
    bytes: Box<MaybeUninit<T>>,
    /// Where the pattern begins: behind the size of a struct of the interface.
    first: usize,
}

const PATTERN: u8 = 0xA5;

impl<T> Untouched<T> {
    pub fn new() -> Untouched<T> {
        let mut out = Box::new(MaybeUninit::uninit());
        // SAFETY: any bytes may be there.
        unsafe { ptr::write_bytes(out.as_mut_ptr(), PATTERN, 1) };
        Untouched {
            bytes: out,
            first: 0,
        }
    }

    pub fn pointer(&mut self) -> *mut T {
        self.bytes.as_mut_ptr()
    }

    #[track_caller]
    pub fn check(&self) {
        // SAFETY: all bytes were written, padding included, and a failing call writes none.
        let bytes =
            unsafe { std::slice::from_raw_parts(self.bytes.as_ptr().cast::<u8>(), size_of::<T>()) };
        assert!(
            bytes[self.first..].iter().all(|b| *b == PATTERN),
            "output was written"
        );
    }
}

impl<T: Growing> Untouched<T> {
    /// A struct that has its size.
    pub fn sized() -> Untouched<T> {
        let mut out = Untouched::<T>::new();
        // SAFETY: the size is the first field.
        unsafe { out.pointer().cast::<usize>().write(size_of::<T>()) };
        out.first = size_of::<usize>();
        out
    }
}

pub const STEP: EllgranStep = EllgranStep {
    size: size_of::<EllgranStep>(),
    time_step: 1e-2,
    advance_history: 1,
};

/// A unit sphere of type 1 with a centre on the x axis.
pub fn sphere_at(x: f64) -> EllgranBody {
    EllgranBody {
        size: size_of::<EllgranBody>(),
        position: [x, 0.0, 0.0],
        quaternion: [1.0, 0.0, 0.0, 0.0],
        semi_axes: [1.0; 3],
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        mass: 1.0,
        particle_type: 1,
        identifier: 7,
        velocity_change: [0.0; 3],
        angular_velocity_change: [0.0; 3],
        velocities_of_step: 0,
    }
}

/// Sixty-four triaxial ellipsoids of two types about the points of a lattice, many of them touching.
pub fn random_bodies(seed: u64) -> Vec<EllgranBody> {
    let mut random = Random(seed);
    let mut bodies: Vec<EllgranBody> = (0..64)
        .map(|k| {
            let lattice = [k % 4, k / 4 % 4, k / 16].map(|c| 2.0 * c as f64);
            EllgranBody {
                position: lattice.map(|c| c + random.between(-0.1, 0.1)),
                quaternion: random.vector(-1.0, 1.0),
                semi_axes: random.vector(0.7, 1.35),
                velocity: random.vector(-0.5, 0.5),
                angular_velocity: random.vector(-0.5, 0.5),
                mass: random.between(0.5, 2.0),
                particle_type: 1 + (k % 2),
                identifier: 1000 + i64::from(k),
                ..sphere_at(0.0)
            }
        })
        .collect();
    // A frozen one, and two spheres that are neighbours.
    bodies[20].mass = f64::INFINITY;
    bodies[21].semi_axes = [1.05; 3];
    bodies[22].semi_axes = [1.1; 3];
    bodies
}

/// Moves bodies by their velocities.
pub fn advance(bodies: &mut [EllgranBody], time: f64) {
    for body in bodies {
        for (x, v) in body.position.iter_mut().zip(body.velocity) {
            *x += time * v;
        }
        let ([w, x, y, z], [a, b, c]) = (body.quaternion, body.angular_velocity);
        let rate = [
            -a * x - b * y - c * z,
            a * w + b * z - c * y,
            b * w + c * x - a * z,
            c * w + a * y - b * x,
        ];
        for (q, r) in body.quaternion.iter_mut().zip(rate) {
            *q += 0.5 * time * r;
        }
    }
}

/// An engine's arrays.
pub struct Arrays {
    pub owned: usize,
    pub positions: Vec<[f64; 3]>,
    pub velocities: Vec<[f64; 3]>,
    pub angular_velocities: Vec<[f64; 3]>,
    pub masses: Vec<f64>,
    pub types: Vec<i32>,
    pub semi_axes: Vec<[f64; 3]>,
    pub quaternions: Vec<[f64; 4]>,
    pub identifiers: Vec<i64>,
    pub forces: Vec<[f64; 3]>,
    pub torques: Vec<[f64; 3]>,
    /// Empty where the velocities of all bodies are those of the half step.
    pub velocity_changes: Vec<[f64; 6]>,
}

impl Arrays {
    pub fn new(bodies: &[EllgranBody], owned: usize) -> Arrays {
        fn all<T>(bodies: &[EllgranBody], of: impl Fn(&EllgranBody) -> T) -> Vec<T> {
            bodies.iter().map(of).collect()
        }
        Arrays {
            owned,
            positions: all(bodies, |b| b.position),
            velocities: all(bodies, |b| b.velocity),
            angular_velocities: all(bodies, |b| b.angular_velocity),
            masses: all(bodies, |b| b.mass),
            types: all(bodies, |b| b.particle_type),
            semi_axes: all(bodies, |b| b.semi_axes),
            quaternions: all(bodies, |b| b.quaternion),
            identifiers: all(bodies, |b| b.identifier),
            forces: vec![[0.0; 3]; bodies.len()],
            torques: vec![[0.0; 3]; bodies.len()],
            velocity_changes: bodies
                .iter()
                .filter(|b| b.velocities_of_step != 0)
                .map(|b| {
                    let ([x, y, z], [a, b, c]) = (b.velocity_change, b.angular_velocity_change);
                    [x, y, z, a, b, c]
                })
                .collect(),
        }
    }

    pub fn particles(&mut self) -> EllgranParticles {
        EllgranParticles {
            size: size_of::<EllgranParticles>(),
            owned_count: self.owned,
            count: self.positions.len(),
            positions: self.positions.as_ptr().cast(),
            velocities: self.velocities.as_ptr().cast(),
            angular_velocities: self.angular_velocities.as_ptr().cast(),
            angular_momenta: ptr::null(),
            masses: self.masses.as_ptr(),
            contact_masses: ptr::null(),
            types: self.types.as_ptr(),
            shape_indices: ptr::null(),
            semi_axes: self.semi_axes.as_ptr().cast(),
            semi_axes_stride: size_of::<[f64; 3]>(),
            quaternions: self.quaternions.as_ptr().cast(),
            quaternions_stride: size_of::<[f64; 4]>(),
            identifiers: self.identifiers.as_ptr().cast(),
            identifier_bytes: 8,
            forces: self.forces.as_mut_ptr().cast(),
            torques: self.torques.as_mut_ptr().cast(),
            velocity_changes: if self.velocity_changes.is_empty() {
                ptr::null()
            } else {
                assert_eq!(self.velocity_changes.len(), self.positions.len());
                self.velocity_changes.as_ptr().cast()
            },
            unchanged: 0,
            prepared_by: ptr::null(),
        }
    }
}

/// A neighbour list with its history.
pub struct List {
    pub central: Vec<i32>,
    counts: Vec<i32>,
    pub rows: Vec<Vec<i32>>,
    pub touching: Vec<Vec<i32>>,
    pub history: Vec<Vec<f64>>,
    row_pointers: Vec<*const i32>,
    touching_pointers: Vec<*mut i32>,
    history_pointers: Vec<*mut f64>,
}

impl List {
    /// Pairs of an owned particle with any other within reach, each once.
    pub fn near(bodies: &[EllgranBody], owned: usize, length: usize) -> List {
        let near = |a: &EllgranBody, b: &EllgranBody| {
            let radius = |x: &EllgranBody| x.semi_axes.iter().fold(0.0f64, |m, s| m.max(*s));
            let squared: f64 = (0..3)
                .map(|k| (a.position[k] - b.position[k]).powi(2))
                .sum();
            squared.sqrt() < radius(a) + radius(b) + 0.2
        };
        let rows = (0..owned)
            .map(|i| {
                (i + 1..bodies.len())
                    .filter(|j| near(&bodies[i], &bodies[*j]))
                    .map(|j| j as i32)
                    .collect()
            })
            .collect();
        List::new(rows, length)
    }

    pub fn new(rows: Vec<Vec<i32>>, length: usize) -> List {
        List {
            central: (0..rows.len() as i32).collect(),
            counts: rows.iter().map(|row| row.len() as i32).collect(),
            touching: rows.iter().map(|row| vec![0; row.len()]).collect(),
            history: rows
                .iter()
                .map(|row| vec![0.0; row.len() * length])
                .collect(),
            rows,
            row_pointers: Vec::new(),
            touching_pointers: Vec::new(),
            history_pointers: Vec::new(),
        }
    }

    pub fn view(&mut self, newton: bool) -> EllgranNeighbourList {
        self.row_pointers = self.rows.iter().map(|row| row.as_ptr()).collect();
        self.touching_pointers = self
            .touching
            .iter_mut()
            .map(|row| row.as_mut_ptr())
            .collect();
        self.history_pointers = self
            .history
            .iter_mut()
            .map(|row| row.as_mut_ptr())
            .collect();
        EllgranNeighbourList {
            size: size_of::<EllgranNeighbourList>(),
            count: self.central.len(),
            central: self.central.as_ptr(),
            neighbour_counts: self.counts.as_ptr(),
            neighbours: self.row_pointers.as_ptr(),
            index_mask: -1,
            special_shift: 0,
            special_factors: ptr::null(),
            newton: newton as i32,
            unchanged: 0,
            keep_history: 0,
            record_contacts: 0,
            touching: self.touching_pointers.as_ptr(),
            history: self.history_pointers.as_ptr(),
        }
    }
}

pub fn no_tallies() -> EllgranTallies {
    EllgranTallies {
        size: size_of::<EllgranTallies>(),
        particle_energies: ptr::null_mut(),
        particle_virials: ptr::null_mut(),
        inelastic_loads: ptr::null_mut(),
        wall_powers: [0.0; 2],
        viscous_dissipation: 0.0,
        tangential_work: 0.0,
        frictional_dissipation: 0.0,
        dissipated_energy: 0.0,
        normal_elastic_energy: 0.0,
        tangential_elastic_energy: 0.0,
        virial: [0.0; 6],
        touching_count: 0.0,
        pair_count: 0,
    }
}
