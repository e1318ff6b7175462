// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entries for energies and virial, in a module of their own: who asks for none does not wait until they are assembled. Compiled twice, as
//! [`entries`](crate::entries).

use crate::memory::{entries, Here};
use crate::scene::scene_of;
use core::sync::atomic::Ordering;
use ellgran_kernels::arguments::{TallyArguments, CANDIDATES};
use ellgran_kernels::shapes::{Ellipsoids, Spheroids};
use ellgran_kernels::tallies::{tally_of_pair, TALLIES};

macro_rules! tallies {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Writes the sums of the thread's candidates: with the same candidates the same bits.
            fn $name(thread, arguments: TallyArguments<Here>) {
                let TallyArguments {
                    scene,
                    candidates,
                    states,
                    histories,
                    notes,
                    mut sums,
                    threads,
                    owned,
                } = arguments;
                let scene = scene_of(&scene, scene.tangential != 0);
                let length = scene.layout.length;
                let (candidates, states, histories) = (candidates.all(), states.all(), histories.all());
                let count = notes.all()[CANDIDATES].load(Ordering::Relaxed) as usize;
                let mut sum = [0.0; TALLIES];
                for candidate in candidates[..count].iter().skip(thread.index()).step_by(threads as usize) {
                    let entry = candidate.entry as usize;
                    let history = &histories[entry * length..(entry + 1) * length];
                    let state = states[entry];
                    let own = tally_of_pair::<$kind>(&scene, candidate, state, history, owned as usize);
                    for (sum, x) in sum.iter_mut().zip(own) {
                        *sum += x;
                    }
                }
                sums.part(&thread, TALLIES).copy_from_slice(&sum);
            }
        )*}
    };
}

// Spheres are spheroids to these.
tallies! {
    ellgran_tally_spheroids: Spheroids;
    ellgran_tally_ellipsoids: Ellipsoids;
}
