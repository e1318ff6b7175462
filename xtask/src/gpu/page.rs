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
/// Contacts of a grain in a dense packing: both grains of a contact compute it.
const CONTACTS_PER_GRAIN: f64 = 10.0;
/// Share of the cycles in which instructions are issued, assumed: two warps for each scheduler do not hide all latencies, and the
/// threads of a warp do not all take the same branches.
const BUSY: f64 = 0.4;

/// Instructions of the machine on `f64` that a division or a root takes, about: an approximation and steps of Newton's method.
const PER_DIVISION: f64 = 9.0;

/// Bytes that a contact reads and writes, where nothing of a neighbour is in a cache: its record, type, identifier, mass; its place
/// in the row, its index and its state, read and written; the history, read and written.
fn bytes_per_contact(history: u32) -> u32 {
    128 + 4 + 4 + 8 + 4 + 4 + 2 * 4 + 2 * 8 * history
}

/// Rows of the predictions: kernel, what it is, doubles of history.
const PREDICTED: [(&str, &str, u32); 4] = [
    ("ellgran_contacts_spheres_friction", "spheres, friction", 4),
    (
        "ellgran_contacts_spheroids_conservative",
        "spheroids, no friction",
        3,
    ),
    (
        "ellgran_contacts_spheroids_friction",
        "spheroids, friction",
        7,
    ),
    (
        "ellgran_contacts_ellipsoids_friction_conservative",
        "ellipsoids, all terms",
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

fn significant(x: f64) -> String {
    let exponent = x.log10().floor();
    format!("{:.1}e{exponent}", x / 10f64.powf(exponent))
}

pub fn page(figures: &Figures) -> String {
    let mut text = String::from(
        "<!-- SPDX-License-Identifier: MIT OR Apache-2.0 -->\n\
         <!-- Made by `cargo xtask gpu` from xtask/src/gpu/page.rs; not to be edited. -->\n\
         # On a GPU\n\n\
         **State: kernels, not yet a run.** The kernels are compiled from the library's own functions and tested on the host. No \
         command of an engine starts them yet, and they have not run on a GPU. The styles for [LAMMPS with KOKKOS](kokkos.md) compute on the \
         host, and refuse a LAMMPS with KOKKOS for GPUs.\n\n\
         ## What there is\n\n\
         | place | what it is |\n|---|---|\n\
         | `gpu/core` | the library without `std`: the same sources, another manifest |\n\
         | `gpu/kernels` | what a thread does with one grain: preparation, candidates, contacts, planes, motion; no formula, no `unsafe` |\n\
         | `gpu/ptx` | the entries, and the memory of the device; the nightly compiler is pinned by date |\n\
         | `gpu/ptx/ellgran.ptx` | what the compiler makes of it, with the hash of its sources |\n\n\
         - One thread computes one grain. It goes through the grain's whole row of a full neighbour list and sums its loads itself, so no \
         atomic operation is needed, and two runs give the same bits.\n\
         - Each pair is computed twice. Both threads put the grain with the lower identifier first, so they find the same force to the last bit.\n\
         - A contact that the search in lanes hands back (deep, or a minimum without proof) is marked, and a second kernel takes it with \
         every safeguard. That kernel needs 18 kB of memory a thread.\n\
         - `factors hale`, `rolling`, `twisting`, curved walls and triangles have no kernel.\n\n\
         `cargo test -p ellgran-kernels` runs the kernels on the host, index by index, and compares loads and histories with the \
         lists in lanes: 1e-12 of the largest load of the scene. `cargo xtask gpu` makes the PTX and this page, and `cargo xtask gpu --check` \
         compares them. `cargo xtask test` compares the hash of the sources alone, which needs no nightly.\n\n",
    );
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
        "\n## Rates to be expected: predicted, not measured\n\n\
         Grains a second of the contact kernel alone, in a dense packing of {CONTACTS_PER_GRAIN} contacts a grain, all of them touching. \
         The prediction assumes four things, none of them measured:\n\n\
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
    text += "\nThe cards differ by their units for `f64`: an H100 finishes 64 such instructions a cycle and processor, an RTX 4090 two. There a \
             form in `f32` and `f64` together is what would help, which does not exist.\n";
    text
}
