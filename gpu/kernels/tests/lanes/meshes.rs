// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts with walls of triangles, at rest and in motion, against those of the library's walls.

use crate::device::Device;
use crate::scene::Scene;
use crate::walls::{compare_to, Kernel, Moves, MIDDLE};
use crate::{laws, ELASTIC, LINEAR, MINDLIN, TOTAL, VISCOELASTIC, WHOLE};
use ellgran::geometry::triangles::Triangle;
use ellgran::vector::Vector3;
use ellgran::walls::parts::{OwnParts, Parts, MOST_RECORDS};
use ellgran::walls::{End, Mesh, Motion, ShapeParameters, Side, Wall, WallHistoryLayout};
use ellgran_kernels::meshes::{
    contacts_with_mesh, is_near_mesh, LargeRoom, MovingMesh, SmallRoom, MOST_TRIANGLES,
};
use ellgran_kernels::shapes::{Ellipsoids, Kind, Spheroids};

fn lent(own: &OwnParts) -> Parts<'_> {
    Parts {
        parts: &own.parts,
        triangles: &own.triangles,
        boxes: &own.boxes,
        widths: &own.widths,
        nodes: &own.nodes,
        order: &own.order,
    }
}

/// What was seen in the steps of a scene.
#[derive(Debug, Default)]
struct Counts {
    touching: usize,
    /// Grains that needed large room.
    crowded: usize,
    /// Grains with more than one contact.
    several: usize,
}

fn compare<K: Kind>(words: &str, scene: Scene, wall: Wall, moves: Moves) -> Counts {
    let general = core::any::type_name::<K>() == core::any::type_name::<Ellipsoids>();
    let own = wall.parts_with_triangles().unwrap();
    let (mut room, mut large) = (Box::new(SmallRoom::EMPTY), Box::new(LargeRoom::EMPTY));
    let mut counts = Counts::default();
    let kernel: &mut Kernel<'_> = &mut |k, scene, motion, layout, state, histories| {
        let moving = MovingMesh {
            parts: lent(&own),
            motion,
            layout,
            wall_type: 1,
        };
        if !is_near_mesh::<K>(k, scene, &moving, state, histories) {
            return ellgran_kernels::contacts::Load::NONE;
        }
        let before = (*state, histories.to_vec());
        let found = contacts_with_mesh(k, scene, general, &moving, room.lend(), state, histories);
        let found = found.or_else(|lacking| {
            assert_eq!((*state, histories.to_vec()), before, "{lacking:?}");
            counts.crowded += 1;
            contacts_with_mesh(k, scene, general, &moving, large.lend(), state, histories)
        });
        counts.several += usize::from(*state > 1);
        found.unwrap()
    };
    let most = MOST_RECORDS;
    counts.touching = compare_to::<K>(words, scene, wall, moves, most, kernel);
    counts
}

fn of_triangles(triangles: Vec<Triangle>) -> Wall {
    let mut wall = Wall::new();
    wall.add_mesh(Mesh::new(triangles).unwrap());
    wall
}

/// A sheet of cells of two triangles each, about the middle.
fn sheet(cells: usize, half: f64, height: impl Fn(f64, f64) -> f64) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let along = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
        let (x, y) = (along(i), along(j));
        MIDDLE + Vector3::new(x, y, height(x, y))
    };
    let mut all = vec![];
    for i in 0..cells {
        for j in 0..cells {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            all.extend([[a, b, c], [a, c, d]]);
        }
    }
    all
}

/// A box about the middle, both of whose sides act.
fn block(half: [f64; 3]) -> Vec<Triangle> {
    let corner = |bits: usize| {
        let side = |k: usize| {
            if bits >> k & 1 == 1 {
                half[k]
            } else {
                -half[k]
            }
        };
        MIDDLE + Vector3::new(side(0), side(1), side(2))
    };
    let mut all = vec![];
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            let [a, b, c, d] = [side, side + u, side + u + v, side + v].map(corner);
            all.extend([[a, b, c], [a, c, d]]);
        }
    }
    all
}

#[test]
fn flat_sheets() {
    for cells in [1, 4, 9] {
        let floor = || of_triangles(sheet(cells, 5.0, |_, _| 0.0));
        let found = compare::<Spheroids>(WHOLE, Scene::spheroids(), floor(), Moves::No);
        assert!(found.touching > 300, "{cells} {found:?}");
        compare::<Ellipsoids>(MINDLIN, Scene::ellipsoids(), floor(), Moves::Yes);
        compare::<Spheroids>(VISCOELASTIC, Scene::spheres(), floor(), Moves::Yes);
        compare::<Spheroids>(ELASTIC, Scene::spheroids(), floor(), Moves::Yes);
    }
    // It ends among the grains.
    let found = compare::<Ellipsoids>(
        WHOLE,
        Scene::ellipsoids(),
        of_triangles(sheet(3, 2.1, |x, y| 0.2 * x - 0.3 * y)),
        Moves::Yes,
    );
    assert!(found.touching > 100, "{found:?}");
}

#[test]
fn edges_and_corners_of_a_block() {
    for half in [[2.0, 1.7, 1.4], [0.6, 0.5, 0.7], [3.0, 0.1, 2.0]] {
        let wall = || of_triangles(block(half));
        let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), wall(), Moves::Yes);
        assert!(found.touching > 50, "{half:?} {found:?}");
        compare::<Spheroids>(TOTAL, Scene::spheroids(), wall(), Moves::No);
        compare::<Spheroids>(LINEAR, Scene::spheres(), wall(), Moves::Yes);
    }
}

/// Both sides of a fold, with shares; velocities of the step.
#[test]
fn folds() {
    let valley = || of_triangles(sheet(8, 5.0, |x, _| 0.7 * x.abs()));
    let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), valley(), Moves::Yes);
    assert!(found.touching > 300 && found.several > 30, "{found:?}");
    let of_step = Scene {
        of_step: true,
        ..Scene::spheroids()
    };
    compare::<Spheroids>(WHOLE, of_step, valley(), Moves::Yes);
    let pit = of_triangles(sheet(2, 5.0, |x, y| 0.6 * (x.abs() + y.abs())));
    let found = compare::<Spheroids>(MINDLIN, Scene::spheroids(), pit, Moves::No);
    assert!(found.several > 30, "{found:?}");
}

/// Surfaces of which many triangles are near a grain: saddles, and uneven ones.
#[test]
fn fine_surfaces() {
    let saddle = |x: f64, y: f64| 0.08 * (x * x - y * y);
    let uneven = |x: f64, y: f64| 0.1 * (3.0 * x).sin() * (2.3 * y).cos();
    let mut crowded = 0;
    for cells in [12, 24] {
        for (words, wall) in [
            (WHOLE, of_triangles(sheet(cells, 4.5, saddle))),
            (MINDLIN, of_triangles(sheet(cells, 4.5, uneven))),
        ] {
            let found = compare::<Ellipsoids>(words, Scene::ellipsoids(), wall, Moves::Yes);
            assert!(found.touching > 300 && found.several > 30, "{found:?}");
            crowded += found.crowded;
        }
    }
    assert!(crowded > 100, "{crowded}");
}

/// Long triangles across the axes, whose boxes hold much that is far from them, with needles and discs beside them.
#[test]
fn narrow_triangles() {
    let centre = MIDDLE + Vector3::new(0.1, 0.2, -0.3);
    let at = |k: usize| {
        let angle = core::f64::consts::TAU * k as f64 / 60.0;
        centre + Vector3::new(5.0 * angle.cos(), 5.0 * angle.sin(), angle.sin())
    };
    let fan = || of_triangles((0..60).map(|k| [centre, at(k), at(k + 1)]).collect());
    let found = compare::<Spheroids>(WHOLE, Scene::spheroids(), fan(), Moves::Yes);
    assert!(found.touching > 300, "{found:?}");
    compare::<Ellipsoids>(TOTAL, Scene::flat_blocks(), fan(), Moves::Yes);
}

/// Parts of one wall, triangles and others, are told apart in the histories.
#[test]
fn several_parts() {
    let mut wall = Wall::new();
    let ball = ShapeParameters {
        point: MIDDLE,
        axis: Vector3::new(0.0, 0.0, 1.0),
        radii: [2.3, 0.0],
        bounds: [0.0; 2],
        ends: [End::None; 2],
        side: Side::OfCentre,
    };
    wall.add_mesh(Mesh::new(block([1.5; 3])).unwrap());
    wall.add_shape("sphere", &ball).unwrap();
    wall.add_mesh(Mesh::new(sheet(5, 4.0, |x, y| 0.1 * x + 0.2 * y)).unwrap());
    wall.add_shape("plane", &ball).unwrap();
    let found = compare::<Ellipsoids>(WHOLE, Scene::ellipsoids(), wall, Moves::Yes);
    assert!(found.touching > 1000 && found.several > 300, "{found:?}");
}

/// More triangles than there is room for are an error, and leave all as it was.
#[test]
fn too_many_triangles_are_an_error() {
    let wall = of_triangles(sheet(120, 4.5, |x, y| 0.02 * (5.0 * x).sin() * y));
    let own = wall.parts_with_triangles().unwrap();
    let laws = laws(WHOLE);
    let scene = Scene::ellipsoids();
    let mut device = Device::new(&scene, &laws);
    device.prepare::<Ellipsoids>(&scene);
    let layout = WallHistoryLayout::new(laws.layout().length, 8);
    let moving = MovingMesh {
        parts: lent(&own),
        motion: Motion::REST,
        layout,
        wall_type: 1,
    };
    let mut large = Box::new(LargeRoom::EMPTY);
    let mut wrong = 0;
    for k in 0..scene.count() {
        let (mut state, mut histories) = (0, vec![0.0; layout.length()]);
        let scene = device.lent(&laws);
        if !is_near_mesh::<Ellipsoids>(k, &scene, &moving, &mut state, &mut histories) {
            continue;
        }
        let found = contacts_with_mesh(
            k,
            &scene,
            true,
            &moving,
            large.lend(),
            &mut state,
            &mut histories,
        );
        if found.is_err() {
            assert!(state == 0 && histories.iter().all(|x| *x == 0.0));
            wrong += 1;
        }
    }
    assert!(wrong > 10, "{wrong} of {MOST_TRIANGLES}");
}

/// Those that an engine lends are on the host alone.
#[test]
fn lent_triangles_are_refused() {
    let mut wall = of_triangles(block([1.0; 3]));
    wall.lent_triangles();
    assert_eq!(wall.parts_with_triangles().unwrap_err(), 1);
}

/// As docs/gpu.md has it.
#[test]
fn how_much_memory_a_search_takes() {
    assert_eq!(size_of::<SmallRoom>().div_ceil(1000), 74);
    assert_eq!(size_of::<LargeRoom>().div_ceil(10_000), 97);
}
