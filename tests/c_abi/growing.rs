// SPDX-License-Identifier: MIT OR Apache-2.0
//! Programs and libraries of different versions: structs that are shorter, longer, or not set.

use std::ptr::{self, null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::growing::Growing;
use ellgran::c_api::law::*;
use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::staged::*;
use ellgran::c_api::status::*;
use ellgran::c_api::tallies::EllgranTallies;

use crate::scene::*;

const LAW: &str = "nfd 1e4 0.3 20 20 tangential tfd 0.5";

/// Room that a newer header's struct would take.
const NEWER: usize = 40;

/// A struct with the size of another version and something behind what this library knows of it.
struct Other<T> {
    bytes: Vec<u64>,
    size: usize,
    kind: std::marker::PhantomData<T>,
}

impl<T: Growing> Other<T> {
    fn new(value: &T, size: usize, behind: u8) -> Other<T> {
        let known = size_of::<T>();
        let mut bytes = vec![0u64; (known + NEWER).div_ceil(8) + 1];
        let start = bytes.as_mut_ptr().cast::<u8>();
        // SAFETY: there is room for the struct and what is behind it; the size is its first field.
        unsafe {
            ptr::write_bytes(start, behind, bytes.len() * 8);
            ptr::copy_nonoverlapping(ptr::from_ref(value).cast(), start, known.min(size));
            start.cast::<usize>().write(size);
        }
        Other {
            bytes,
            size,
            kind: std::marker::PhantomData,
        }
    }

    fn pointer(&mut self) -> *mut T {
        self.bytes.as_mut_ptr().cast()
    }

    /// What stands behind the struct of this version, and behind that of the library's.
    fn behind(&self) -> Vec<u8> {
        let first = self.size.min(size_of::<T>());
        let start = self.bytes.as_ptr().cast::<u8>();
        // SAFETY: there are so many bytes, and from `first` on all were set; before it a struct may have padding, which was not.
        unsafe { std::slice::from_raw_parts(start.add(first), self.bytes.len() * 8 - first) }
            .to_vec()
    }
}

/// Sizes that no version has had, and the name of the struct.
fn wrong_sizes<T: Growing>() -> Vec<usize> {
    let known = size_of::<T>();
    vec![
        0,
        1,
        T::FIRST_SIZE - 8,
        known + 4,
        known + (1 << 20),
        usize::MAX,
    ]
}

#[track_caller]
fn refused<T: Growing>(name: &str, mut call: impl FnMut(usize) -> i32) {
    for size in wrong_sizes::<T>() {
        let start = format!("ELLGRAN_INIT({})", T::NAME);
        let told = format!("{name}: size = {size} ");
        fails(call(size), ELLGRAN_ERROR_ARGUMENT, &[&told, &start]);
    }
}

fn geometry_of(i: *const EllgranBody, out: *mut EllgranContactGeometry) -> i32 {
    let j = sphere_at(1.5);
    // SAFETY: the bodies are valid, the output as long as its size says where that is possible.
    unsafe { ellgran_contact_geometry(null(), i, &j, null(), out) }
}

fn body_of_size(size: usize) -> EllgranBody {
    EllgranBody {
        size,
        ..sphere_at(0.0)
    }
}

#[test]
fn a_size_that_is_not_set_is_named_with_its_cure() {
    let mut geometry = Untouched::<EllgranContactGeometry>::sized();
    refused::<EllgranBody>("i", |size| {
        geometry_of(&body_of_size(size), geometry.pointer())
    });
    geometry.check();
    let mut force = Untouched::<EllgranContactForce>::sized();
    let mut parameters = parse(LAW);
    let laws = Laws::new(&[LAW]);
    let (mut touching, mut history) = (0, vec![0.0; laws.length()]);
    let (i, j) = (sphere_at(0.0), sphere_at(1.9));
    // SAFETY: all pointers are valid; a struct whose size is refused is not looked at.
    unsafe {
        refused::<EllgranContactGeometry>("geometry", |size| {
            let g = geometry.pointer();
            (*g).size = size;
            geometry_of(&i, g)
        });
        (*geometry.pointer()).size = size_of::<EllgranContactGeometry>();
        let mut contact = |step: &EllgranStep, f: *mut EllgranContactForce| {
            ellgran_contact(
                laws.0,
                &i,
                &j,
                step,
                &mut touching,
                history.as_mut_ptr(),
                geometry.pointer(),
                f,
            )
        };
        refused::<EllgranStep>("step", |size| {
            contact(&EllgranStep { size, ..STEP }, force.pointer())
        });
        force.check();
        refused::<EllgranContactForce>("force", |size| {
            let f = force.pointer();
            (*f).size = size;
            contact(&STEP, f)
        });
        let mut made = null_mut();
        refused::<EllgranLawParameters>("parameters[0]", |size| {
            parameters.size = size;
            ellgran_laws_new(1, &parameters, &1, 0, &mut made)
        });
        refused::<EllgranLawParameters>("parameters", |size| {
            parameters.size = size;
            ellgran_law_parameters_default(&mut parameters)
        });
        assert!(made.is_null());

        let mut staged = null_mut();
        ok(ellgran_staged_new(&mut staged));
        let (mut wall, mut normal) = (no_surface(), [0.0; 3]);
        let mut found = Untouched::<EllgranStagedGeometry>::sized();
        refused::<EllgranWallSurface>("wall", |size| {
            wall.size = size;
            ellgran_staged_wall(staged, &i, &wall, 0.5, found.pointer())
        });
        refused::<EllgranStagedGeometry>("geometry", |size| {
            let g = found.pointer();
            (*g).size = size;
            ellgran_staged_pair(staged, &i, &j, 0.5, normal.as_mut_ptr(), g)
        });
        (*found.pointer()).size = size_of::<EllgranStagedGeometry>();
        let pair = ellgran_staged_pair(staged, &i, &j, 0.5, normal.as_mut_ptr(), found.pointer());
        ok(pair);
        let mut history = EllgranStagedHistory {
            size: 0,
            friction: 0.5,
            touched: 0,
            normal,
        };
        (*force.pointer()).size = size_of::<EllgranContactForce>();
        let memory = normal.as_mut_ptr();
        refused::<EllgranStagedHistory>("history", |size| {
            history.size = size;
            let f = force.pointer();
            ellgran_staged_forces(staged, laws.0, 1, 1, 1.0, &STEP, &history, memory, f)
        });
        ellgran_staged_free(staged);
    }
}

fn no_surface() -> EllgranWallSurface {
    EllgranWallSurface {
        size: size_of::<EllgranWallSurface>(),
        point: [-0.9, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
        direction: [0.0; 3],
        curvatures: [0.0; 2],
        turning_radii: [f64::INFINITY; 2],
        velocity: [0.0; 3],
        others_share: 0.0,
        others_share_by_position: [0.0; 3],
        others_share_by_rotation: [0.0; 3],
        velocity_change: [0.0; 3],
    }
}

/// A list of two spheres.
struct Two {
    laws: Laws,
    workspace: WorkspaceHandle,
    arrays: Arrays,
    list: List,
}

impl Two {
    fn new() -> Two {
        let bodies = [sphere_at(0.0), sphere_at(1.9)];
        let laws = Laws::new(&[LAW]);
        let length = laws.length();
        Two {
            workspace: WorkspaceHandle::new(),
            arrays: Arrays::new(&bodies, 2),
            list: List::new(vec![vec![1], vec![]], length),
            laws,
        }
    }

    fn pairs(
        &mut self,
        change: impl FnOnce(&mut EllgranParticles, &mut EllgranNeighbourList),
        tallies: *mut EllgranTallies,
    ) -> i32 {
        let mut particles = self.arrays.particles();
        let mut list = self.list.view(true);
        change(&mut particles, &mut list);
        self.laws
            .pairs(&self.workspace, &particles, &list, &STEP, tallies)
    }
}

#[test]
fn sizes_of_lists_and_tallies_are_checked() {
    let mut two = Two::new();
    refused::<EllgranParticles>("particles", |size| {
        two.pairs(|p, _| p.size = size, null_mut())
    });
    refused::<EllgranNeighbourList>("list", |size| two.pairs(|_, l| l.size = size, null_mut()));
    let mut tallies = no_tallies();
    refused::<EllgranTallies>("tallies", |size| {
        tallies.size = size;
        two.pairs(|_, _| (), &mut tallies)
    });
    assert!(two.arrays.forces.iter().flatten().all(|f| *f == 0.0));
}

#[test]
fn a_newer_struct_is_read_and_written_as_far_as_it_is_known() {
    let known = size_of::<EllgranBody>();
    let expected = {
        let mut out = Untouched::<EllgranContactGeometry>::sized();
        ok(geometry_of(&sphere_at(0.0), out.pointer()));
        // SAFETY: written.
        unsafe { *out.pointer() }
    };
    for (behind, read) in [(0, true), (1, false)] {
        let mut i = Other::new(&sphere_at(0.0), known + NEWER, behind);
        let size = size_of::<EllgranContactGeometry>() + NEWER;
        let mut out = Other::new(&expected, size, 0x5A);
        let status = geometry_of(i.pointer(), out.pointer());
        if read {
            ok(status);
            // SAFETY: written.
            let got = unsafe { *out.pointer() };
            assert_eq!(got.size, size);
            assert_eq!(got.penetration.to_bits(), expected.penetration.to_bits());
            assert_eq!(got.major_direction, expected.major_direction);
        } else {
            fails(status, ELLGRAN_ERROR_ARGUMENT, &["i", "newer EllgranBody"]);
        }
        assert!(out.behind().iter().all(|b| *b == 0x5A));
    }
}
