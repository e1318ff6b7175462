// SPDX-License-Identifier: MIT OR Apache-2.0
//! Energies, virial and counts that a caller may ask for.

use super::growing::{given, growing, Output};
use super::status::{slice_mut, Failure};
use crate::pairs::Tallies;
use libc::size_t;

/// What is asked for, and its sums over the contacts of this call. Pass NULL for nothing: it then costs nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranTallies {
    /// `sizeof(EllgranTallies)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// In: [count] or NULL; elastic energy per particle, added to, half to each body.
    pub particle_energies: *mut f64,
    /// In: [count][6] (xx yy zz xy xz yz) or NULL; virial per particle, added to, half to each body.
    pub particle_virials: *mut f64,
    /// In/out: time integral of the power of the viscous and of the tangential force. Set it to 0 before the first step
    /// and keep it between steps.
    pub accumulated_work: f64,
    /// Out: energy that left the elastic store since `accumulated_work` was 0.
    pub dissipated_energy: f64,
    /// Out: elastic energy of the normal deformation.
    pub normal_elastic_energy: f64,
    /// Out: elastic energy of the tangential deformation.
    pub tangential_elastic_energy: f64,
    /// Out: sum of d (x) F over pairs, d from i to j, F the force on j: xx yy zz xy xz yz.
    pub virial: [f64; 6],
    /// Out: touching pairs; one that another rank lists too counts one half.
    pub touching_count: f64,
    /// Out: neighbour pairs.
    pub pair_count: i64,
}

growing!(EllgranTallies);

/// # Safety
/// The arrays of `t` are NULL or have `count` entries.
pub(super) unsafe fn borrow<'a>(t: &EllgranTallies, count: usize) -> Result<Tallies<'a>, Failure> {
    // SAFETY: promised by the caller; NULL is not asked for.
    let particle_energies = if t.particle_energies.is_null() {
        None
    } else {
        Some(unsafe { slice_mut(t.particle_energies, count, "particle_energies") }?)
    };
    // SAFETY: as above.
    let particle_virials = if t.particle_virials.is_null() {
        None
    } else {
        Some(unsafe {
            slice_mut(
                t.particle_virials.cast::<[f64; 6]>(),
                count,
                "particle_virials",
            )
        }?)
    };
    Ok(Tallies {
        particle_energies,
        particle_virials,
        accumulated_work: t.accumulated_work,
        ..Tallies::default()
    })
}

/// What the caller asks for, and where it goes.
pub(super) struct Asked<'a> {
    pub given: EllgranTallies,
    output: Output<'a, EllgranTallies>,
}

impl Asked<'_> {
    /// # Safety
    /// `tallies` is NULL (then nothing is asked for) or valid, as long as the size in it says, for the lifetime that the
    /// caller gives it.
    pub(super) unsafe fn new(tallies: *mut EllgranTallies) -> Result<Option<Self>, Failure> {
        if tallies.is_null() {
            return Ok(None);
        }
        // SAFETY: promised by the caller; the reference ends before anything is written.
        let given = *unsafe { given(tallies.cast_const(), "tallies") }?;
        // SAFETY: promised by the caller.
        let output = unsafe { Output::new(tallies, "tallies") }?;
        Ok(Some(Asked { given, output }))
    }

    pub(super) fn write(&mut self, sums: &Tallies<'_>) {
        self.output.write(&EllgranTallies {
            accumulated_work: sums.accumulated_work,
            dissipated_energy: sums.dissipated_energy(),
            normal_elastic_energy: sums.normal_elastic_energy,
            tangential_elastic_energy: sums.tangential_elastic_energy,
            virial: sums.virial,
            touching_count: sums.touching,
            pair_count: sums.pairs as i64,
            ..self.given
        });
    }
}
