// SPDX-License-Identifier: MIT OR Apache-2.0
//! docs/gpu.md: what the kernels need, and the rates to be expected from that.

use std::fmt::Write as _;

use super::assembler::{Figures, Kernel, SHOWN};

/// What is known of a GPU: its makers' figures.
struct Card {
    name: &'static str,
    processors: f64,
    /// Cycles per second.
    clock: f64,
    /// Instructions on `f64` that a processor finishes in a cycle, over its threads.
    double: f64,
    /// The same of the others.
    other: f64,
    /// Bytes per second.
    bandwidth: f64,
}

const CARDS: [Card; 3] = [
    Card {
        name: "H100 SXM",
        processors: 132.0,
        clock: 1.755e9,
        double: 64.0,
        other: 128.0,
        bandwidth: 3.35e12,
    },
    Card {
        name: "A100 SXM",
        processors: 108.0,
        clock: 1.41e9,
        double: 32.0,
        other: 64.0,
        bandwidth: 2.04e12,
    },
    Card {
        name: "RTX 4090",
        processors: 128.0,
        clock: 2.52e9,
        double: 2.0,
        other: 128.0,
        bandwidth: 1.01e12,
    },
];

/// Registers of a processor.
const REGISTERS: u32 = 65_536;
/// Contacts of a grain in a dense packing, each counted once.
const CONTACTS_PER_GRAIN: f64 = 5.0;
/// Share of the cycles in which instructions are issued, assumed: two warps for each scheduler do not hide all latencies, and the
/// threads of a warp do not all take the same branches.
const BUSY: f64 = 0.4;

/// Instructions of the machine on `f64` that a division or a root takes, about: an approximation and steps of Newton's method.
const PER_DIVISION: f64 = 9.0;

/// Bytes that a contact reads and writes, where nothing of a grain is in a cache: the records, changes of motion and masses of both; the
/// candidate; its state and its history, read and written; its load, written, and read by both grains.
fn bytes_per_contact(history: u32) -> u32 {
    2 * (128 + 48 + 8) + 16 + 2 * 4 + 2 * 8 * history + 3 * 72
}

/// Rows of the predictions: kernel, what it is, doubles of history.
const PREDICTED: [(&str, &str, u32); 7] = [
    ("ellgran_contacts_spheres_friction", "spheres, friction", 4),
    (
        "ellgran_contacts_spheroids_conservative",
        "spheroids, no friction",
        3,
    ),
    (
        "ellgran_contacts_mixed_spheroids_conservative",
        "the same, mixed",
        3,
    ),
    (
        "ellgran_contacts_spheroids_friction_conservative",
        "spheroids, all terms",
        7,
    ),
    (
        "ellgran_contacts_mixed_spheroids_friction_conservative",
        "the same, mixed",
        7,
    ),
    (
        "ellgran_contacts_ellipsoids_friction_conservative",
        "ellipsoids, all terms",
        7,
    ),
    (
        "ellgran_contacts_mixed_ellipsoids_friction_conservative",
        "the same, mixed",
        7,
    ),
];

/// Grains per second, of the contact kernel alone.
fn rate(card: &Card, kernel: &Kernel, history: u32) -> f64 {
    let double = kernel.arithmetic as f64 + (PER_DIVISION - 1.0) * kernel.divisions as f64;
    let other = (kernel.instructions as f64 - double).max(0.0);
    let cycles = double / card.double + other / card.other;
    let of_arithmetic = BUSY * card.processors * card.clock / cycles;
    let of_memory = card.bandwidth / f64::from(bytes_per_contact(history));
    of_arithmetic.min(of_memory) / CONTACTS_PER_GRAIN
}

/// How the interface is used, and what it was tried with.
const FROM_C: &str = "\
## From C

An engine that has its grains in the memory of a GPU gives their addresses there, and a stream. What is on the device stays there.

```sh
cargo xtask install --prefix DIR --gpu
cc -std=c99 examples/c/gpu_two_grains.c $(PKG_CONFIG_PATH=DIR/lib/pkgconfig pkg-config --cflags --libs ellgran-gpu) -lcuda -o gpu_two_grains
```

With CMake: `find_package(ellgran REQUIRED)`, `find_package(CUDAToolkit REQUIRED)`, `target_link_libraries(app ellgran::gpu CUDA::cuda_driver)`.

- **One library.** `libellgran_gpu.a` has all of `libellgran.a`. `libellgran.a` itself has nothing of this, and no new dependency.
- **No toolkit.** It builds and links on any machine. NVIDIA's driver is loaded when a GPU is opened; `-lcuda` is for what the program \
itself calls. `ELLGRAN_GPU_DRIVER` names another file than `libcuda.so.1`.
- **The device and context** are those of the thread (`ellgran_gpu_open_current`), as KOKKOS has chosen them, or the primary context of a \
GPU by its number (`ellgran_gpu_open`).
- **Opening a GPU** has the driver assemble the kernels, where that has not been done before on the machine. The driver keeps the result in the user's home directory. Kernels of walls of cylinders and the like, \
of walls with triangles, and of energies are modules of their own, which are assembled when they are needed for the first time. `ptxas` takes \
17 s for the kernels of all scenes, 23 s for those walls, 49 s for triangles and 10 s for energies, on one core of an Intel Xeon.
- **Memory** is allocated by `ellgran_gpu_new_list`, when a wall is added, and when energies are asked for the first time. A grain takes about 250 bytes, an entry of the full neighbour list 24 bytes and \
16 for each double of a history (136 with friction), and each pair of the list 92 bytes; there is a quarter more room than that. The kernel \
for deep contacts needs 18 kB a thread, which the driver sets aside for as many threads as the GPU can hold. The driver takes some megabytes \
more when it starts a kernel for the first time.
- **Arrays** are the engine's own. Vectors are rows or columns (`EllgranGpuVectors`), shapes and attitudes may be in records in another \
order (`body_places`), images across a periodic boundary need centres alone where the engine says whose they are (`owners`), and loads are \
added to forces and torques where the engine asks for it (`EllgranGpuLoads`).
- **A step** starts kernels and returns: nothing is allocated, copied or waited for. Whether the candidates still hold is found on the \
device, which selects them anew by itself.
- **The neighbour list** is a full one: that a pair is in one row alone is found, and is an error that names the grain.
- **Histories** stay on the device. With a new list they are carried over by the identifiers of the grains, in whatever order the engine \
has them now. For those of a restart file, and of grains that come from another rank, there are `ellgran_gpu_read_histories` and `ellgran_gpu_write_histories`, and for what is remembered of a wall, in the form of the host's walls, `ellgran_gpu_read_wall_histories` and `ellgran_gpu_write_wall_histories`.
- **What is wrong with a grain** is kept on the device until `ellgran_gpu_check` asks for it, or the next list: an error with the grain's \
identifier and the value.
- **Shapes** choose the kernels: stated, or found with each list.
- **Walls** are planes, of which each call says where they are, or [any wall of ellgran.h](#walls) but one whose triangles an engine lends.
- **Energies**: `ellgran_gpu_tally_pairs` sums up elastic energies and virial of pairs, in the steps that ask for them.
- **Precision** is double, or mixed (`ellgran_gpu_scene_set_precision`): [below](#precision).

| status | what is to be done |
|---|---|
| `ELLGRAN_GPU_ERROR_NO_DRIVER` | install NVIDIA's driver |
| `ELLGRAN_GPU_ERROR_OLD_DRIVER` | install one of CUDA 11.0 or later |
| `ELLGRAN_GPU_ERROR_NO_DEVICE` | look at `CUDA_VISIBLE_DEVICES`, or at the number of the GPU |
| `ELLGRAN_GPU_ERROR_OLD_DEVICE` | use a GPU of sm_70 (Volta) or later |
| `ELLGRAN_GPU_ERROR_ASSEMBLER` | report it, with the words of the driver's assembler in the message |
| `ELLGRAN_GPU_ERROR_MEMORY` | fewer grains, or a larger GPU |
| `ELLGRAN_GPU_ERROR_KERNEL` | a list or an array has changed, or is shorter than was said; the process must begin anew |
| `ELLGRAN_GPU_ERROR_LAWS` | `factors hale`, `viscosity memory`, `displacement hysteretic`, `rolling`, `twisting`: use the host |
| `ELLGRAN_GPU_ERROR_POINTER` | an array of the host was given: copy it to the GPU |

A complete program, [gpu_two_grains.c](../examples/c/gpu_two_grains.c):

```{literalinclude} ../examples/c/gpu_two_grains.c
:language: c
:lines: 2-
```

`cargo test -p ellgran-gpu` runs this program, each status, and the scenes of the kernels' tests over 60 steps with five neighbour lists, \
in each of which the engine has its grains in another order: loads and histories agree with the lists in lanes to 1e-12, and no step \
allocates, copies or waits. That is on the stand-in for a driver, which runs one thread after the other. With \
`ELLGRAN_TEST_GPU_DRIVER=libcuda.so.1` the scenes of the kernels' tests run on the GPU of the machine, to the same bound \
(`cargo test -p ellgran-gpu --test steps -- --test-threads=1`).

What is not there: walls of triangles that an engine lends, output of the force on a wall or its triangles, motion of a part of the grains, contact masses of rigid bodies, energies \
of each grain and of walls, what contacts dissipate.

";

/// Which walls there are, and what they take.
const WALLS: &str = "\
## Walls

`ellgran_gpu_add_wall` takes a wall of `ellgran.h` (`ellgran_wall_add_shape`, `ellgran_wall_add_shape_words`, `ellgran_wall_add_triangles`, \
`ellgran_wall_add_stl`, and `ellgran_wall_add_block`, of which the triangles alone act there): planes, cylinders, cones and \
spheres, from within, from without or on both sides, with discs, rims and tips where they end, and triangles. `ellgran_gpu_compute_wall` takes its place and its \
motion in each step, rotation and `along_itself` included.

- One thread takes one grain, by the functions of the host: it looks for the contacts with each part that is near, finds what each goes on from, and \
applies the law. What is remembered is laid out as on the host.
- A grain may touch one wall without triangles in 8 places. One that touches it in more is an error of `ellgran_gpu_check` that names it.
- A grain takes 24 bytes and, with friction, 224 for each contact that a wall remembers: two for an endless cylinder or a sphere, one for a plane. Planes of \
`ellgran_gpu_add_plane` take 120, and less time.
- The kernel needs 22 kB of memory a thread, most of it for a sphere from without, which is found by the search with every safeguard.

A wall of which a part is triangles takes two kernels, in one call:

- The first finds the grains that are near the wall, by the host's tree of boxes. They are listed in the order in which threads come to them, which changes no result: \
each grain's loads are its own.
- The second takes one of these grains a thread, 8192 at a time, with the search of the host. Its lists are in memory that is set aside before, 74 kB a thread: for 32 \
triangles near the grain, and 48 faces, edges and corners that support it. It is started once more for grains that need more room, 128 at a time, 0.97 MB each.
- A grain that is near more than 512 triangles of one wall, or that 512 faces, edges and corners support, is an error of `ellgran_gpu_check` that names it. \
Nothing that did not fit is left out of a result.
- Such memory is set aside once a scene, 0.7 GB for 8192 owned grains or more, when a wall with triangles is added and with new lists. Of each contact 8 are remembered a mesh, as on the host.

`cargo test -p ellgran-kernels` compares loads and histories with those of the walls of the host, at rest and in motion, to 1e-12 of the largest; \
`cargo test -p ellgran-gpu` does so through the C interface, over a new list.

";

/// What mixed precision is, and how wrong. The numbers are those of `gpu/kernels/tests/lanes/mixed.rs`, which holds them to bounds.
const PRECISION: &str = "\
## Precision

All is in double precision, unless a scene is told otherwise (`ellgran_gpu_scene_set_precision` with `ELLGRAN_GPU_MIXED`). Mixed precision is for \
cards that are slow with `f64`. On one that is not it gains little, and double precision is to be preferred.

| in `f32` | in `f64` |
|---|---|
| the search: Newton's method and the proof that its minimum is the global one, in units of the pair's size | the way between the centres |
| curvatures and Hertz factors | support functions, witnesses and penetration, at the normal that was found and by one more step of Newton's method |
| the further terms of the conservative law, over the energy | the law: normal force, friction, viscosity |
| | histories, motion, planes, candidates, spheres, contacts that are marked |

- **The penetration** is a small difference of lengths: in `f32` alone it would be off by 1e-3 at an overlap of 1e-3 of the smallest semi-axis. It is \
stationary in the normal, so that in `f64` at a normal from `f32` its error is of second order.
- **No contact is missed.** What `f32` cannot tell is marked, and taken by the kernel with every safeguard: values within 1e-6 of the \
largest semi-axes go on to `f64`, and there a pair is apart only where a plane is found between the bodies. Pairs whose smallest semi-axis is less than 1e-5 of the \
pair's size are marked.
- **The law stays in `f64`.** The tangential force is a memory to which each step adds little: in `f32` an increment below 6e-8 of it would be lost. \
`displacement rescaled` compares energies in each step and gives up what is too much, so that a contact at rest would lose some 3e-8 of its force in each step, \
and 3 % in a million.

Errors, as shares of the force of the contact (torques over the largest semi-axis): the largest of 2000 random pairs for each overlap, and the largest of nine in ten. \
Needles are of semi-axes r:1:1, discs r:r:1, blades r:sqrt(r):1. Marked are those of overlaps up to 0.01; the others are so in double precision.

| aspect ratio r | overlap, smallest semi-axes | needles | discs | blades | marked in mixed precision, of 2000 |
|---|---|---|---|---|---|
| 1.2 | 1e-6 to 0.1 | 2.8e-7, 1.2e-7 | 2.3e-7, 1.2e-7 | 3.1e-7, 1.4e-7 | none |
| 2 | 1e-6 to 0.1 | 2.9e-7, 1.2e-7 | 2.7e-7, 1.2e-7 | 3.5e-7, 1.6e-7 | none |
| 5 | 1e-6 to 0.1 | 3.1e-7, 1.3e-7 | 5.1e-7, 1.6e-7 | 4.6e-7, 1.7e-7 | none |
| 10 | 1e-6 to 0.01 | 2.8e-7, 1.3e-7 | 1.9e-6, 2.6e-7 | 8.7e-7, 2.0e-7 | none |
| | 0.1 | 3.1e-6, 4.2e-7 | 1.8e-6, 2.9e-7 | 2.0e-6, 2.2e-7 | |
| 30 | 1e-6 to 0.01 | 2.4e-6, 5.5e-7 | 1.3e-5, 6.8e-7 | 3.2e-6, 3.1e-7 | at most 88, 10, 13; in double 29, 9, 4 |
| | 0.1 | 3.7e-5, 2.5e-6 | 3.2e-5, 5.5e-7 | 4.0e-5, 7.9e-7 | |
| 100 | 1e-6 and 1e-3 | 3.7e-6, 1.7e-7 | 1.0e-4, 7.1e-7 | 7.8e-6, 3.7e-7 | 1339, 72, 302; in double 1163, 55, 209 |
| 1000 | 1e-6 and 1e-3 | 6.2e-3, 1.2e-11 | 1.4e-3, 1.2e-6 | 1.3e-3, 4.6e-7 | 1933, 125, 1346; in double 1835, 76, 1041 |

In scenes over 60 steps loads and histories are those of the lists in lanes to 1e-5 of the largest of the scene, which is the bound of the tests. Flat bodies whose rims touch, \
beyond an aspect ratio of 30, are better computed in double precision.

In a dense packing the forces on a grain nearly cancel: their sum is off by more of itself than a contact is. `whole_step FILE --mixed` of `cargo xtask gpu --pack DIR` times packings in mixed \
precision, and computes the last step in both. On an H100, with 884 736 grains of aspect ratio 2: the largest difference of a load is 8.3e-6 of the largest load, the rate 4.07e8 grains a second, in double \
precision 4.23e8. With 128 000 needles of aspect ratio 10: 2.7e-5, 4.64e7 and 4.78e7.

";

fn significant(x: f64) -> String {
    let exponent = x.log10().floor();
    format!("{:.1}e{exponent}", x / 10f64.powf(exponent))
}

/// Columns of the stored results that the page shows, and what they are.
const SHOWN_COLUMNS: [(&str, &str); 9] = [
    ("packing", "packing"),
    ("grains", "grains"),
    ("contacts_per_grain", "contacts a grain"),
    ("start_ms", "first half of the step, ms"),
    ("prepare_ms", "preparation, ms"),
    ("pairs_ms", "contacts, ms"),
    ("finish_ms", "second half, ms"),
    ("step_ms", "whole step, ms"),
    ("grain_steps_per_second", "grains a second"),
];

/// What was measured, from what `cargo xtask gpu --bench` has printed.
fn measured(results: &str) -> String {
    let mut lines = results.lines();
    let (Some(about), Some(head)) = (lines.next(), lines.next()) else {
        return String::new();
    };
    let names: Vec<&str> = head.split(',').collect();
    let mut text = format!(
        "## Measured\n\n\
         `cargo xtask gpu --bench` ({}): whole steps on the device. Grains of a packing stand side by side in a layer of grains that do not \
         move, so that each has all its neighbours. That is no engine: its neighbour lists, its communication and its output are not in these \
         times. In this run 2^16 threads selected candidates, where there are 2^18 now: of 128 000 needles, which select in one step of six, preparation took 1.7 ms with a thread \
         for each.\n\n",
        about.trim_start_matches('#').trim()
    );
    let row = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
    text += &row(SHOWN_COLUMNS.iter().map(|(_, title)| *title).collect());
    text += &row(vec!["---"; SHOWN_COLUMNS.len()]);
    for line in lines.filter(|line| !line.is_empty()) {
        let values: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| {
            let at = names.iter().position(|n| *n == name);
            at.and_then(|k| values.get(k).copied()).unwrap_or("")
        };
        text += &row(SHOWN_COLUMNS.iter().map(|(name, _)| cell(name)).collect());
    }
    text + "\n"
}

pub fn page(figures: &Figures, results: &str) -> String {
    let mut text = String::from(
        "<!-- SPDX-License-Identifier: MIT OR Apache-2.0 -->\n\
         <!-- Made by `cargo xtask gpu` from xtask/src/gpu/page.rs; not to be edited. -->\n\
         # On a GPU\n\n\
         **State: run on an H100, where forces and histories agree with the host to 1e-12.** The kernels are compiled from the library's own \
         functions. They are started through a C interface, by an engine that has its grains in the memory of a GPU, or by \
         [LAMMPS with KOKKOS for CUDA](kokkos.md#on-a-gpu).\n\n\
         ## What there is\n\n\
         | place | what it is |\n|---|---|\n\
         | `gpu/core` | the library without `std`: the same sources, another manifest |\n\
         | `gpu/kernels` | what a thread does with one grain or one pair: preparation, candidates, contacts, planes, walls, motion; no formula, no `unsafe` |\n\
         | `gpu/ptx` | the entries, and the memory of the device; the nightly compiler is pinned by date |\n\
         | `gpu/ptx/ellgran.ptx`, `ellgran_walls.ptx`, `ellgran_meshes.ptx`, `ellgran_tallies.ptx` | what the compiler makes of it, with the hash of its sources: modules of all scenes, of walls of cylinders and the like, of walls with triangles, and of energies |\n\
         | `gpu/driver` | the C interface, [ellgran_gpu.h](../include/ellgran_gpu.h): device pointers and a stream in |\n\
         | `gpu/stand_in_driver` | NVIDIA's driver without a GPU, for tests: it runs the entries on the host, thread by thread |\n\n\
         - One thread computes one pair that may touch, for both of its grains. The row of the grain with the lower identifier keeps the pair.\n\
         - Then six threads for each grain sum the loads of its contacts, a component each, in the order of its row. No load is added to by an \
         atomic operation, and two runs give the same bits.\n\
         - A contact that the search in lanes hands back (deep, or a minimum without proof) is marked, and a second kernel takes it with \
         every safeguard. That kernel needs 18 kB of memory a thread.\n\
         - `factors hale`, `viscosity memory`, `displacement hysteretic`, `rolling` and `twisting` have no kernel.\n\
         - The contacts of spheroids and ellipsoids have a second form each, in [mixed precision](#precision).\n\n\
         `cargo test -p ellgran-kernels` runs the kernels on the host, index by index, and compares loads and histories with the \
         lists in lanes: 1e-12 of the largest load of the scene. `cargo xtask gpu` makes the PTX and this page, and `cargo xtask gpu --check` \
         compares them. `cargo xtask test` compares the hash of the sources alone, which needs no nightly.\n\n",
    );
    text += FROM_C;
    text += WALLS;
    text += PRECISION;
    text += &measured(results);
    let _ = write!(
        text,
        "## What the kernels need\n\n\
         By `ptxas` {} for sm_{SHOWN}. A processor of the GPU has {REGISTERS} registers. Instructions are those of the machine, \
         16 bytes each, of all branches and of the functions that it calls. Arithmetic is that of PTX on `f64` in the kernel itself, divisions \
         and roots among it.\n\n\
         | kernel | registers | stack, bytes | spilled, bytes | instructions | arithmetic | divisions, roots |\n\
         |---|---|---|---|---|---|---|\n",
        figures.version
    );
    for (name, k) in &figures.kernels {
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} | {} | {} | {} | {} |",
            k.registers, k.stack, k.spilled, k.instructions, k.arithmetic, k.divisions
        );
    }
    text += "\nThe assembler takes the PTX for all of these generations. Beside them, the most that a contact kernel spills:\n\n\
             | generation | spilled, bytes |\n|---|---|\n";
    for (generation, spilled) in &figures.most_spilled {
        let _ = writeln!(text, "| sm_{generation} | {spilled} |");
    }
    let _ = write!(
        text,
        "\n## Rates to be expected of other cards: predicted\n\n\
         Grains a second of the contact kernel alone, in a dense packing of {CONTACTS_PER_GRAIN} contacts for each grain, all of them touching. \
         The prediction assumes four things:\n\n\
         - A contact takes as many instructions as its kernel has. That counts branches that are not taken, and steps of the search after \
         the first only where the compiler has unrolled them.\n\
         - A division or a root takes {PER_DIVISION} instructions on `f64`.\n\
         - {:.0} % of the cycles issue an instruction.\n\
         - Nothing of a neighbour is found in a cache; the smaller of the rates by arithmetic and by memory counts.\n\n\
         | scene | bytes a contact |",
        100.0 * BUSY
    );
    for card in &CARDS {
        let _ = write!(text, " {} |", card.name);
    }
    text += "\n|---|---|";
    text += &"---|".repeat(CARDS.len());
    text += "\n";
    for (name, scene, history) in PREDICTED {
        let Some(kernel) = figures.kernels.get(name) else {
            continue;
        };
        let _ = write!(text, "| {scene} | {} |", bytes_per_contact(history));
        for card in &CARDS {
            let _ = write!(text, " {} |", significant(rate(card, kernel, history)));
        }
        text += "\n";
    }
    text += "\nOn the H100 the kernel for spheroids with all terms was measured: 6.3e8 (Nsight Compute: `ncu --metrics gpu__time_duration.sum ./whole_step dense.data --copies 6`, 1.40 ms for 884 736 grains of the dense packing). \
             A warp executed 2314 instructions, fewer than the kernel has, and a quarter of the cycles issued one: 43 % of the waiting is for memory. So the predictions are low.\n\n\
             The cards differ by their units for `f64`: an H100 finishes 64 such instructions a cycle and processor, an RTX 4090 two. Conversions from and to \
             `f64` are at the same rate. Mixed precision was timed on the H100 alone.\n";
    text
}
