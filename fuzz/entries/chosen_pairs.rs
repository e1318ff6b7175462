// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is asked of pairs that a caller names: contacts, gaps, energies, stiffnesses, collisions, Rayleigh's times and the stable step.

use ellgran::c_api::many_contacts::*;
use ellgran::c_api::neighbour_list::EllgranNeighbourList;
use ellgran::c_api::stable_step::*;
use ellgran::c_api::without_history::*;

use super::neighbour_list::{bodies, Arrays};
use super::scene::*;

pub fn run(bytes: &[u8]) {
    let u = &mut Bytes::new(bytes);
    if let Ok(Some(laws)) = Laws::read(u) {
        let _ = calls(u, &laws);
    }
}

/// Numbers of each pair, checked to be finite.
struct Column {
    name: &'static str,
    numbers: Vec<f64>,
}

impl Column {
    fn new(name: &'static str, length: usize) -> Column {
        Column {
            name,
            numbers: vec![0.0; length],
        }
    }

    fn pointer(&mut self) -> *mut f64 {
        self.numbers.as_mut_ptr()
    }

    fn check(&self) {
        assert_finite(self.name, &self.numbers);
    }
}

fn calls(u: &mut Bytes, laws: &Laws) -> arbitrary::Result<()> {
    let workspace = Workspace::read(u)?;
    let mut arrays = Arrays::new(bodies(u, laws.types, 5)?);
    let count = arrays.bodies.len();
    let mut pairs: Vec<[i32; 2]> = Vec::new();
    for i in 0..count as i32 {
        for j in i + 1..count as i32 {
            pairs.push(if u.arbitrary()? { [i, j] } else { [j, i] });
        }
    }
    if one_in(u, 16)? {
        pairs.push(u.arbitrary()?);
    }
    let step = step(u)?;
    let particles = arrays.particles(count);
    let (number, named) = (pairs.len(), pairs.as_ptr().cast::<i32>());

    let mut vectors: [Column; 11] = [
        "normal",
        "contact point",
        "witness of i",
        "witness of j",
        "major direction",
        "force",
        "torque on i",
        "torque on j",
        "tangential force",
        "displacement",
        "viscous force",
    ]
    .map(|name| Column::new(name, 3 * number));
    let mut numbers: [Column; 5] = [
        "penetration",
        "normal force",
        "penetration rate",
        "elastic energy",
        "tangential energy",
    ]
    .map(|name| Column::new(name, number));
    let mut contacts = sized::<EllgranContactArrays>();
    {
        let mut of = vectors.iter_mut().map(Column::pointer);
        for place in [
            &mut contacts.normal,
            &mut contacts.contact_point,
            &mut contacts.witness_i,
            &mut contacts.witness_j,
            &mut contacts.major_direction,
            &mut contacts.force,
            &mut contacts.torque_i,
            &mut contacts.torque_j,
            &mut contacts.tangential_force,
            &mut contacts.displacement,
            &mut contacts.viscous_force,
        ] {
            *place = of.next().expect("one for each");
        }
        let mut of = numbers.iter_mut().map(Column::pointer);
        for place in [
            &mut contacts.penetration,
            &mut contacts.normal_force,
            &mut contacts.penetration_rate,
            &mut contacts.elastic_energy,
            &mut contacts.tangential_energy,
        ] {
            *place = of.next().expect("one for each");
        }
    }
    let mut touching = vec![0; number];
    let mut history = vec![0.0; number * laws.length];
    for _ in 0..2 {
        // SAFETY: the arrays are as long as the structs and the counts say.
        succeeded(unsafe {
            ellgran_pair_contacts(
                laws.pointer,
                workspace.0,
                &particles,
                &step,
                number,
                named,
                touching.as_mut_ptr(),
                history.as_mut_ptr(),
                &contacts,
            )
        });
        // Those before one that fails are written.
        vectors.iter().chain(&numbers).for_each(Column::check);
        assert_finite("history", &history);
    }

    let (mut gaps, mut normals) = (
        Column::new("gaps", number),
        Column::new("normals", 3 * number),
    );
    let mut energies = Column::new("energies", number);
    let mut stiffness = ["normal stiffness", "normal damping", "critical step"]
        .map(|name| Column::new(name, number));
    let mut tangential =
        ["tangential stiffness", "tangential damping"].map(|name| Column::new(name, 2 * number));
    let speeds = (0..number)
        .map(|_| {
            if one_in(u, 8)? {
                super::scene::number(u)
            } else {
                Ok(usual(u)?.abs())
            }
        })
        .collect::<arbitrary::Result<Vec<_>>>()?;
    let mut collisions = ["times", "penetrations"].map(|name| Column::new(name, number));
    let mut rayleigh = Column::new("Rayleigh's times", count);
    // SAFETY: as above, for all of these.
    unsafe {
        succeeded(ellgran_pair_gaps(
            workspace.0,
            &particles,
            number,
            named,
            gaps.pointer(),
            normals.pointer(),
        ));
        succeeded(ellgran_pair_energies(
            laws.pointer,
            workspace.0,
            &particles,
            number,
            named,
            energies.pointer(),
        ));
        let mut all = sized::<EllgranStiffnessArrays>();
        [all.normal_stiffness, all.normal_damping, all.critical_step] =
            stiffness.each_mut().map(Column::pointer);
        [all.tangential_stiffness, all.tangential_damping] =
            tangential.each_mut().map(Column::pointer);
        succeeded(ellgran_pair_stiffnesses(
            laws.pointer,
            workspace.0,
            &particles,
            number,
            named,
            &all,
        ));
        let [times, penetrations] = collisions.each_mut().map(Column::pointer);
        succeeded(ellgran_pair_collisions(
            laws.pointer,
            workspace.0,
            &particles,
            number,
            named,
            speeds.as_ptr(),
            times,
            penetrations,
        ));
        succeeded(ellgran_rayleigh_times(
            laws.given.len(),
            laws.given.as_ptr(),
            &particles,
            rayleigh.pointer(),
        ));
    }
    for column in [&gaps, &normals, &energies, &stiffness[0], &stiffness[1]] {
        column.check();
    }
    tangential.iter().for_each(Column::check);
    // Infinite of two fixed bodies, and of a law without a material.
    for column in [&stiffness[2], &rayleigh, &collisions[0], &collisions[1]] {
        let (name, numbers) = (column.name, &column.numbers);
        assert!(numbers.iter().all(|x| *x >= 0.0), "{name}: {numbers:?}");
    }
    // It takes milliseconds.
    let for_error = one_in(u, 16)?;
    stable(laws, &workspace, &particles, &pairs, for_error)
}

/// The stable step of the pairs, as a neighbour list.
fn stable(
    laws: &Laws,
    workspace: &Workspace,
    particles: &ellgran::c_api::particles::EllgranParticles,
    pairs: &[[i32; 2]],
    for_error: bool,
) -> arbitrary::Result<()> {
    let mut rows = vec![Vec::new(); particles.count];
    for [i, j] in pairs {
        if let Some(row) = usize::try_from(*i).ok().and_then(|i| rows.get_mut(i)) {
            row.push(*j);
        }
    }
    let central: Vec<i32> = (0..particles.count as i32).collect();
    let counts: Vec<i32> = rows.iter().map(|row| row.len() as i32).collect();
    let pointers: Vec<_> = rows.iter().map(|row| row.as_ptr()).collect();
    let mut list = sized::<EllgranNeighbourList>();
    list.count = particles.count;
    list.central = central.as_ptr();
    list.neighbour_counts = counts.as_ptr();
    list.neighbours = pointers.as_ptr();
    list.index_mask = -1;
    list.newton = 1;
    let mut sums = vec![0.0; particles.count * ELLGRAN_STEP_SUMS_LENGTH];
    let mut extremes = sized::<EllgranContactExtremes>();
    // SAFETY: the arrays are as long as the structs say.
    let added = unsafe {
        ellgran_add_pairs_to_step_sums(
            laws.pointer,
            workspace.0,
            particles,
            &list,
            sums.as_mut_ptr(),
            &mut extremes,
        )
    };
    if !succeeded(added) {
        return Ok(());
    }
    let (mut step, mut limiting) = (f64::NAN, -2);
    // SAFETY: as above.
    let found =
        unsafe { ellgran_stable_step(sums.as_ptr(), particles.count, &mut step, &mut limiting) };
    if succeeded(found) {
        assert!(step >= 0.0, "{step}");
        assert!((-1..particles.count as i64).contains(&limiting));
    }
    if !for_error {
        return Ok(());
    }
    // SAFETY: as above.
    let found = unsafe { ellgran_step_for_error(laws.pointer, &extremes, 1e-2, &mut step) };
    if succeeded(found) {
        assert!(step > 0.0, "{step}");
    }
    Ok(())
}
