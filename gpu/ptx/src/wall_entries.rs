// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entry for walls of planes, cylinders, cones and spheres, in a module of its own: who has no such wall does not wait until it is assembled.
//! Compiled twice, as [`entries`](crate::entries).

use crate::memory::{entries, Here};
use crate::scene::{add, note, scene_of, wall_layout};
use ellgran::walls::Motion;
use ellgran_kernels::arguments::{WallArguments, FAULT};
use ellgran_kernels::shapes::{Ellipsoids, Spheroids};
use ellgran_kernels::walls::{contacts_with_wall, MovingWall, TOO_MANY_CONTACTS};

entries! {
    /// Adds the loads of a wall of surfaces. `faults` gets [`TOO_MANY_CONTACTS`].
    fn ellgran_wall(thread, arguments: WallArguments<Here>) {
        let WallArguments {
            scene,
            surfaces,
            motion,
            mut states,
            mut histories,
            mut forces,
            mut torques,
            mut faults,
            notes,
            ellipsoids,
            wall_type,
            records,
        } = arguments;
        let scene = scene_of(&scene, scene.tangential != 0);
        let wall = MovingWall {
            surfaces: surfaces.all(),
            motion: Motion::from(&motion),
            layout: wall_layout(&scene, records),
            wall_type,
        };
        let length = wall.layout.length();
        let state = states.at(&thread);
        let histories = histories.part(&thread, length);
        let k = thread.index();
        // Spheres are spheroids to it.
        let outcome = if ellipsoids != 0 {
            contacts_with_wall::<Ellipsoids>(k, &scene, &wall, state, histories)
        } else {
            contacts_with_wall::<Spheroids>(k, &scene, &wall, state, histories)
        };
        match outcome {
            Ok(load) => {
                if *state != 0 {
                    add(&mut forces, &thread, load.force);
                    add(&mut torques, &thread, load.torque);
                }
            }
            Err(_) => {
                let first = faults.at(&thread);
                if *first == 0 {
                    *first = TOO_MANY_CONTACTS;
                }
                note(notes.all(), FAULT);
            }
        }
    }
}
