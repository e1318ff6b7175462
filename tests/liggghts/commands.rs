// SPDX-License-Identifier: MIT OR Apache-2.0
//! What do LIGGGHTS' own commands do with ellipsoids? Each row of the table in `liggghts-patch/README.md` runs here: those that work,
//! on ellipsoids that are spheres, against LIGGGHTS' own spheres under the same law; those that would be wrong, for their message.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::PathBuf;

use crate::harness::{
    attempt_in, execute, fresh_directory, last_lines, last_rows, Deck, Engine, Grain, Outcome,
    Scene, ELASTIC,
};
use crate::meshes::sheet;
use crate::shapes::{length, sub};

/// A command that LIGGGHTS' own spheres and ellipsoids that are spheres know alike.
struct Works {
    name: &'static str,
    /// The words after `model`, but for the surface.
    model: &'static str,
    /// Before the pair style.
    before: &'static [&'static str],
    /// Before the run.
    fixes: &'static [&'static str],
    /// Columns of the thermodynamic output that must agree.
    columns: &'static str,
    mesh: bool,
    boundary: &'static str,
    /// After the wall.
    wall_words: &'static str,
    tolerance: f64,
}

const fn works(name: &'static str, fixes: &'static [&'static str], columns: &'static str) -> Works {
    Works {
        name,
        model: "hertz tangential history",
        before: &[],
        fixes,
        columns,
        mesh: false,
        boundary: "f f f",
        wall_words: "",
        tolerance: 2e-3,
    }
}

const fn moves(name: &'static str, fixes: &'static [&'static str]) -> Works {
    Works {
        mesh: true,
        ..works(name, fixes, "")
    }
}

/// A contact model of LIGGGHTS' own.
const fn model(name: &'static str, model: &'static str) -> Works {
    Works {
        model,
        before: CONSTANTS,
        ..works(name, &[], "")
    }
}

const CONSTANTS: &[&str] = &[
    "fix c1 all property/global coefficientRollingFriction peratomtypepair 1 0.1",
    "fix c2 all property/global coefficientRollingViscousDamping peratomtypepair 1 0.3",
    "fix c3 all property/global rollingStiffness scalar 2.25",
    "fix c4 all property/global characteristicVelocity scalar 1.",
    "fix c5 all property/global kn peratomtypepair 1 1e4",
    "fix c6 all property/global kt peratomtypepair 1 3e3",
    "fix c7 all property/global gamman peratomtypepair 1 50",
    "fix c8 all property/global gammat peratomtypepair 1 20",
    "fix c9 all property/global coefficientMaxElasticStiffness peratomtypepair 1 4",
    "fix c10 all property/global coefficientAdhesionStiffness peratomtypepair 1 0.5",
    "fix c11 all property/global coefficientPlasticityDepth peratomtypepair 1 0.1",
];

const WORKS: &[Works] = &[
    model("model hertz", "hertz"),
    model("tangential history", "hertz tangential history"),
    model("tangential no_history", "hertz tangential no_history"),
    model("model hooke", "hooke tangential history"),
    model("model hertz/stiffness", "hertz/stiffness tangential history"),
    model("model hooke/stiffness", "hooke/stiffness tangential history"),
    model("model hooke/hysteresis", "hooke/hysteresis tangential history"),
    model("rolling_friction cdt", "hertz tangential history rolling_friction cdt"),
    model("rolling_friction epsd", "hertz tangential history rolling_friction epsd"),
    model("rolling_friction epsd2", "hertz tangential history rolling_friction epsd2"),
    model("rolling_friction epsd3", "hertz tangential history rolling_friction epsd3"),
    Works {
        boundary: "p p f",
        ..works("periodic boundaries", &["velocity all set 15 0.2 -0.1"], "")
    },
    Works {
        boundary: "p p f",
        ..works("fix deform", &["fix d all deform 1 x erate -20 remap v"], "")
    },
    Works {
        wall_words: "shear x 0.3",
        ..works("shear of a primitive wall", &[], "")
    },
    works("fix dt/reset", &["fix f all dt/reset 10 1e-6 1e-4 1e-4"], ""),
    works("compute displace/atom", &["compute x all displace/atom", "compute y all reduce sum c_x[4]"], "c_y"),
    works("compute gyration", &["compute x all gyration"], "c_x"),
    works("compute ke", &["compute x all ke"], "c_x"),
    works("compute ke/atom", &["compute x all ke/atom", "compute y all reduce sum c_x"], "c_y"),
    works("compute erotate", &["compute x all erotate"], "c_x"),
    works("compute com", &["compute x all com"], "c_x[1] c_x[3]"),
    works(
        "compute stress/atom",
        &["compute x all stress/atom", "compute y all reduce sum c_x[1] c_x[3] c_x[4]"],
        "c_y[1] c_y[2] c_y[3]",
    ),
    works(
        "compute pressure",
        &["compute t all temp", "compute x all pressure t"],
        "c_x[1] c_x[3]",
    ),
    works("compute coord/atom", &["compute x all coord/atom 0.012", "compute y all reduce sum c_x"], "c_y"),
    works("compute reduce", &["compute y all reduce max vx vz fx"], "c_y[1] c_y[2] c_y[3]"),
    works(
        "compute property/atom",
        &["compute x all property/atom vx fz", "compute y all reduce sum c_x[1] c_x[2]"],
        "c_y[1] c_y[2]",
    ),
    works("compute msd", &["compute x all msd"], "c_x[4]"),
    works("compute pe", &["compute x all pe"], "c_x"),
    works(
        "fix property/global given again",
        &[
            "run 60",
            "unfix coefficientFriction",
            "fix coefficientFriction all property/global coefficientFriction peratomtypepair 1 0.1",
            "unfix youngsModulus",
            "fix youngsModulus all property/global youngsModulus peratomtype 3e6",
        ],
        "",
    ),
    works("fix gravity", &["fix g all gravity 5 vector 1 0 -1"], ""),
    works("fix freeze", &["group cold id 1", "fix f cold freeze"], ""),
    works("fix viscous", &["fix f all viscous 1e-3"], ""),
    works("fix addforce", &["fix f all addforce 1e-3 0 0"], ""),
    works("fix setforce", &["fix f all setforce NULL 0 NULL"], ""),
    works("fix momentum", &["fix f all momentum 50 linear 1 1 0"], ""),
    works("fix spring", &["group one id 3", "fix f one spring tether 1 0 0 0 0"], ""),
    works("fix ave/time", &["compute x all ke", "fix f all ave/time 1 5 10 c_x"], "f_f"),
    works("fix ave/atom", &["fix f all ave/atom 1 5 10 vx vz", "compute y all reduce sum f_f[1] f_f[2]"], "c_y[1] c_y[2]"),
    works(
        "fix ave/euler",
        &["fix f all ave/euler nevery 10 cell_size_relative 8 parallel no"],
        // LIGGGHTS itself divided by zero where they are written
        "f_f[1][4] f_f[1][7]",
    ),
    works("fix drag", &["fix f all drag 0 0 0 1e-3 1e-4"], ""),
    works("fix aveforce", &["fix f all aveforce 1e-4 NULL NULL"], ""),
    works("fix lineforce", &["group one id 3", "fix f one lineforce 1 1 0"], ""),
    works("fix planeforce", &["group one id 3", "fix f one planeforce 0 0 1"], ""),
    works("fix spring/self", &["fix f all spring/self 5"], ""),
    works("fix print", &["fix f all print 50 \"step\""], ""),
    works(
        "fix property/atom",
        &["fix f all property/atom mark scalar yes no no 3.0", "compute y all reduce sum f_f"],
        "c_y",
    ),
    works("fix store/state", &["fix f all store/state 0 vx", "compute y all reduce sum f_f"], "c_y"),
    works(
        "fix check/timestep/gran",
        &["fix f all check/timestep/gran 10 0.9 0.9"],
        "f_f[1]",
    ),
    works(
        "fix heat/gran/conduction with contact_area constant",
        &[
            "fix k all property/global thermalConductivity peratomtype 50.",
            "fix c all property/global thermalCapacity peratomtype 0.01",
            "fix f all heat/gran/conduction initial_temperature 300. contact_area constant 1e-6",
            "run 0",
            "set atom 1 property/atom Temp 900.",
            "compute y all reduce max f_Temp",
            "compute z all reduce min f_Temp",
        ],
        "c_y c_z",
    ),
    works("dump custom", &["dump d all custom 50 dumped id x y z vx fx"], ""),
    works("restart, write_restart", &["restart 50 restarted.*"], ""),
    Works {
        before: &["fix sheet all mesh/surface/stress file sheet.stl type 1"],
        ..moves_columns("fix mesh/surface/stress", &[], "f_sheet[1] f_sheet[3]")
    },
    Works {
        before: &["fix sheet all mesh/surface/stress/servo file sheet.stl type 1 com 0 0 0 ctrlPV force axis 0 0 1 target_val 0.5 vel_max 0.1 kp 0.1"],
        ..moves_columns("fix mesh/surface/stress/servo", &[], "f_sheet[3] f_sheet[9]")
    },
    Works {
        before: &["fix sheet all mesh/surface file sheet.stl type 1 surface_vel 0.2 0 0"],
        ..moves("fix mesh/surface surface_vel", &[])
    },
    Works {
        before: &["fix sheet all mesh/surface file sheet.stl type 1 surface_ang_vel origin 0 0 0 axis 0 0 1 omega 5"],
        ..moves("fix mesh/surface surface_ang_vel", &[])
    },
    moves("fix move/mesh linear", &["fix m all move/mesh mesh sheet linear 0.2 0.1 0.05"]),
    moves(
        "fix move/mesh linear/variable",
        &["variable v equal 0.2", "variable w equal 0", "fix m all move/mesh mesh sheet linear/variable v_v v_w v_w"],
    ),
    moves("fix move/mesh wiggle", &["fix m all move/mesh mesh sheet wiggle amplitude 0 0 1e-4 period 1e-3"]),
    moves("fix move/mesh viblin", &["fix m all move/mesh mesh sheet viblin axis 0 0 1 order 1 amplitude 1e-4 phase 0 period 1e-3"]),
    moves("fix move/mesh rotate", &["fix m all move/mesh mesh sheet rotate origin 0 0 0 axis 0 0 1 period 1"]),
    moves(
        "fix move/mesh rotate/variable",
        &["variable v equal 5", "fix m all move/mesh mesh sheet rotate/variable origin 0 0 0 axis 0 0 1 omega v_v"],
    ),
    moves("fix move/mesh riggle", &["fix m all move/mesh mesh sheet riggle origin 0 0 0 axis 0 0 1 period 0.01 amplitude 2"]),
    moves("fix move/mesh vibrot", &["fix m all move/mesh mesh sheet vibrot origin 0 0 0 axis 0 0 1 order 1 amplitude 0.01 phase 0 period 0.01"]),
    moves("dump mesh/stl", &["dump d all mesh/stl 50 meshes*.stl"]),
    Works {
        before: &[
            "fix sheet all mesh/surface file sheet.stl type 1",
            "fix gate all mesh/surface file gate.stl type 1",
        ],
        ..moves_columns("fix massflow/mesh", &["fix f all massflow/mesh mesh gate vec_side 0. 0. -1. count once"], "f_f[1] f_f[2]")
    },
];

const fn moves_columns(
    name: &'static str,
    fixes: &'static [&'static str],
    columns: &'static str,
) -> Works {
    Works {
        mesh: true,
        ..works(name, fixes, columns)
    }
}

/// A command that is refused, and words of the message.
struct Refused {
    name: &'static str,
    model: &'static str,
    before: &'static [&'static str],
    fixes: &'static [&'static str],
    words: &'static [&'static str],
}

const OURS: &str = "nfd tangential tfd surface ellipsoid";

const fn refused(
    name: &'static str,
    fixes: &'static [&'static str],
    words: &'static [&'static str],
) -> Refused {
    Refused {
        name,
        model: OURS,
        before: &[],
        fixes,
        words,
    }
}

const CONDUCTIVITY: &str = "fix k all property/global thermalConductivity peratomtype 50.";
const CAPACITY: &str = "fix c all property/global thermalCapacity peratomtype 10.";

const REFUSED: &[Refused] = &[
    refused(
        "minimize",
        &["compute thermo_pe all pe", "minimize 0 1e-8 10 100"],
        &["minimize", "energy of contacts", "fix viscous"],
    ),
    refused(
        "fix particletemplate/sphere",
        &["fix t all particletemplate/sphere 10007 atom_type 1 density constant 2500 radius constant 0.002"],
        &["particletemplate/sphere", "semi-axes", "particletemplate/superquadric"],
    ),
    refused(
        "fix particletemplate/multisphere",
        &["fix t all particletemplate/multisphere 10007 atom_type 1 density constant 2500 nspheres 2 ntry 1000 spheres 0 0 0 0.002 0.001 0 0 0.002 type 1"],
        &["particletemplate/multisphere", "semi-axes"],
    ),
    refused(
        "fix particletemplate/multiplespheres",
        &["fix t all particletemplate/multiplespheres 10007 atom_type 1 density constant 2500 nspheres 2 ntry 1000 spheres 0 0 0 0.002 0.01 0 0 0.002"],
        &["particletemplate/multiplespheres", "semi-axes"],
    ),
    refused("fix multisphere", &["fix t all multisphere"], &["multisphere", "ellipsoids"]),
    refused("write_data", &["write_data grains.data"], &["write_data", "write_restart"]),
    refused("run_style respa", &["run_style respa 2 2"], &["run_style verlet", "respa"]),
    refused("neighbor multi", &["neighbor 0.001 multi"], &["neighbor ... multi", "bin"]),
    refused("fix rigid", &["fix t all rigid single"], &["rigid", "ellipsoids"]),
    refused("fix nve/sphere", &["unfix move", "fix t all nve/sphere"], &["nve/sphere"]),
    refused("fix nve/asphere", &["unfix move", "fix t all nve/asphere"], &["nve/asphere"]),
    refused(
        "fix adapt with pair",
        &["variable e equal 1e6", "fix t all adapt 1 pair gran youngsModulus * * v_e"],
        &["Fix adapt pair style param not supported"],
    ),
    refused(
        "fix adapt with diameter",
        &["variable d equal 0.002", "fix t all adapt 1 atom diameter v_d"],
        &["particle", "bounding radius", "shape"],
    ),
    refused(
        "fix spring/rg",
        &["fix t all spring/rg 1 0.02"],
        &["spring/rg", "masses of types"],
    ),
    refused(
        "fix buoyancy",
        &["fix t all buoyancy level 0.01 dim z density 1000."],
        &["buoyancy", "bounding sphere"],
    ),
    Refused {
        before: &["fix gate all mesh/surface file gate.stl type 1"],
        ..refused(
            "fix massflow/mesh/sieve",
            &["fix f all massflow/mesh/sieve mesh gate vec_side 0. 0. -1. count once sieveSize 0.004 sieveSpacing 0.01 sieveStiffness 10 sieveDamping 0.1"],
            &["massflow/mesh/sieve", "bounding sphere"],
        )
    },
    refused(
        "fix heat/gran/conduction with contact_area overlap or projection",
        &[CONDUCTIVITY, CAPACITY, "fix t all heat/gran/conduction initial_temperature 300."],
        &["heat/gran/conduction", "contact_area constant"],
    ),
    refused("compute contact/atom", &["compute x all contact/atom"], &["contact/atom", "pair/gran/local"]),
    refused("compute contact/atom/gran", &["compute x all contact/atom/gran"], &["contact/atom"]),
    refused("compute erotate/sphere", &["compute x all erotate/sphere"], &["erotate/sphere"]),
    refused("compute erotate/sphere/atom", &["compute x all erotate/sphere/atom"], &["erotate/sphere"]),
    refused(
        "compute group/group",
        &["compute x all group/group all", "thermo_style custom step c_x"],
        &["group/group"],
    ),
    refused("compute pair/gran/local with ms_id", &["compute x all pair/gran/local ms_id"], &["ms_id", "multisphere"]),
    Refused {
        model: "nfd tangential tfd cohesion sjkr surface ellipsoid",
        before: &["fix coh all property/global cohesionEnergyDensity peratomtypepair 1 1e5"],
        ..refused("cohesion sjkr", &[], &["cohesion off"])
    },
    Refused {
        model: "nfd tangential tfd cohesion sjkr2 surface ellipsoid",
        before: &["fix coh all property/global cohesionEnergyDensity peratomtypepair 1 1e5"],
        ..refused("cohesion sjkr2", &[], &["cohesion off"])
    },
    Refused {
        model: "hertz tangential history cohesion sjkr surface ellipsoid",
        before: &["fix coh all property/global cohesionEnergyDensity peratomtypepair 1 1e5"],
        ..refused("cohesion sjkr with model hertz", &[], &["cohesion off"])
    },
    Refused {
        model: "nfd tangential tfd cohesion easo/capillary/viscous surface ellipsoid",
        ..refused("cohesion easo/capillary/viscous", &[], &["cohesion off"])
    },
    Refused {
        model: "nfd tangential tfd cohesion washino/capillary/viscous surface ellipsoid",
        ..refused("cohesion washino/capillary/viscous", &[], &["cohesion off"])
    },
    Refused {
        model: "nfd tangential tfd rolling_friction luding surface ellipsoid",
        ..refused("rolling_friction luding", &[], &["rolling_friction luding", "cdt"])
    },
    Refused {
        model: "edinburgh tangential history surface ellipsoid",
        ..refused("model edinburgh", &[], &["edinburgh"])
    },
    Refused {
        model: "thornton_ning tangential no_history surface ellipsoid",
        ..refused("model thornton_ning", &[], &["thornton_ning"])
    },
    Refused {
        model: "nfd tangential tfd surface superquadric",
        ..refused("model nfd with surface superquadric", &[], &["surface ellipsoid"])
    },
    Refused {
        model: "nfd tangential tfd surface multicontact",
        ..refused(
            "model nfd with surface multicontact",
            &[],
            &["multicontact"],
        )
    },
    Refused {
        model: "nfd tangential tfd surface ellipsoid absolute_damping on",
        ..refused("absolute_damping", &[], &["absolute_damping"])
    },
    Refused {
        model: "hertz tangential history surface ellipsoid computeElasticPotential on",
        ..refused("computeElasticPotential with model hertz", &[], &["computeElasticPotential"])
    },
];

/// A command that spheres and ellipsoids do not share: what it says in the end must hold.
struct Alone {
    name: &'static str,
    verdict: &'static str,
    before: &'static [&'static str],
    fixes: &'static [&'static str],
    holds: fn(&Outcome) -> bool,
}

pub const TEMPLATE: &str = "fix t all particletemplate/superquadric 15485863 atom_type 1 density constant 2500 shape constant 0.003 0.002 0.0015 blockiness constant 2. 2.";
pub const DISTRIBUTION: &str = "fix pd all particledistribution/discrete 15485867 1 t 1.0";
const REGION: &str = "region fill block -0.05 0.05 -0.05 0.05 0.03 0.045 units box";

fn last_of(outcome: &Outcome, column: &str) -> f64 {
    outcome.thermo().last().map_or(f64::NAN, |row| row[column])
}

const ORIENTATIONS: &str = "dump turned all custom 200 turned quat1 quat2 quat3 quat4";

fn orientations(outcome: &Outcome) -> Vec<Vec<f64>> {
    last_rows(&outcome.directory.join("turned"))
}

fn not_turned(outcome: &Outcome) -> bool {
    orientations(outcome)
        .iter()
        .all(|quaternion| quaternion[0] == 1.0)
}

/// Forty grains came, none on another: they fall freely, so that their energy is that of their speed.
fn forty_came(outcome: &Outcome) -> bool {
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.003 * 0.002 * 0.0015;
    let energy = 0.5 * 40.0 * mass * 0.25;
    last_of(outcome, "Atoms") == 44.0 && (last_of(outcome, "KinEng") - energy).abs() < 0.01 * energy
}

const ALONE: &[Alone] = &[
    Alone {
        name: "fix insert/pack",
        verdict: "works",
        before: &[],
        fixes: &[
            TEMPLATE,
            DISTRIBUTION,
            REGION,
            "fix ins all insert/pack seed 32452843 distributiontemplate pd vel constant 0 0 -0.5 insert_every once overlapcheck yes orientation random all_in yes particles_in_region 40 region fill",
        ],
        holds: forty_came,
    },
    Alone {
        name: "fix insert/rate/region",
        verdict: "works",
        before: &[],
        fixes: &[
            TEMPLATE,
            DISTRIBUTION,
            REGION,
            "fix ins all insert/rate/region seed 32452843 distributiontemplate pd nparticles 40 particlerate 1000000 insert_every 20 overlapcheck yes orientation random all_in yes vel constant 0 0 -0.5 region fill",
        ],
        holds: forty_came,
    },
    Alone {
        name: "fix insert/stream",
        verdict: "works",
        before: &["fix face all mesh/surface/planar file gate.stl type 1"],
        fixes: &[
            TEMPLATE,
            DISTRIBUTION,
            "fix ins all insert/stream seed 32452843 distributiontemplate pd nparticles 40 particlerate 1000000 overlapcheck yes orientation random vel constant 0 0 0.5 insertion_face face extrude_length 0.02",
        ],
        holds: |outcome| last_of(outcome, "Atoms") == 44.0,
    },
    Alone {
        name: "fix nve",
        verdict: "differs",
        before: &[],
        fixes: &["unfix move", "fix move all nve", "set group all omegaz 300", ORIENTATIONS],
        holds: not_turned,
    },
    Alone {
        name: "fix nve/limit",
        verdict: "differs",
        before: &[],
        fixes: &["unfix move", "fix move all nve/limit absolute 1.0", "set group all omegaz 300", ORIENTATIONS],
        holds: not_turned,
    },
    Alone {
        name: "fix nve/noforce",
        verdict: "differs",
        before: &[],
        fixes: &["unfix move", "fix move all nve/noforce", "set group all omegaz 300", ORIENTATIONS],
        holds: not_turned,
    },
    Alone {
        name: "fix move",
        verdict: "differs",
        before: &[],
        fixes: &["unfix move", "fix move all move rotate 0 0 0 0 0 1 0.01", ORIENTATIONS],
        holds: |outcome| {
            not_turned(outcome)
                && outcome.output.matches("carries ellipsoids and does not turn them").count() == 1
        },
    },
    Alone {
        name: "displace_atoms with rotate",
        verdict: "differs",
        before: &[],
        fixes: &["displace_atoms all rotate 0 0 0 0 0 1 90 units box", ORIENTATIONS],
        holds: |outcome| {
            let [x, y, _] = outcome.first().states[0].position;
            not_turned(outcome) && (x + 0.0071).abs() < 1e-9 && (y - 0.0113).abs() < 1e-9
        },
    },
    Alone {
        name: "read_data",
        verdict: "works",
        before: &[],
        fixes: &[],
        holds: |outcome| outcome.first().states[0].position == [0.0113, 0.0071, 1e-2],
    },
    Alone {
        name: "fix nve/superquadric",
        verdict: "works",
        before: &[],
        fixes: &["set group all omegaz 300", ORIENTATIONS],
        // half of the angle of 300 * 200 * 1e-6
        holds: |outcome| orientations(outcome).iter().all(|quaternion| (quaternion[3] - 0.03f64.sin()).abs() < 1e-4),
    },
    Alone {
        name: "fix nve/ellipsoid",
        verdict: "works",
        before: &[],
        fixes: &["unfix move", "fix move all nve/ellipsoid", "set group all omegaz 300", ORIENTATIONS],
        // exact: what is left are the digits of the dump
        holds: |outcome| orientations(outcome).iter().all(|quaternion| (quaternion[3] - 0.03f64.sin()).abs() < 1e-7),
    },
];

#[test]
fn what_ellipsoids_have_alone() {
    let engine = Engine::from_environment();
    let mut failures = vec![];
    for row in ALONE {
        let mut grains = scene();
        for grain in &mut grains.grains {
            grain.velocity = [0.0; 3];
            grain.position[2] = 1e-2;
            grain.semi_axes = [4e-3, 3e-3, 2e-3];
        }
        let deck = Deck {
            before: lines(row.before),
            fixes: lines(row.fixes),
            time_step: 1e-6,
            steps: 200,
            thermo: "step atoms ke".into(),
            ..Deck::new(ELASTIC, 0.5)
        };
        let outcome = attempt_in(&engine, &directory(row.name), &grains, &deck, 1);
        let holds = outcome.success && (row.holds)(&outcome);
        println!(
            "{}: {} {:?}",
            row.name,
            if holds { row.verdict } else { "FAILS" },
            outcome.thermo().last()
        );
        if !holds {
            failures.push(format!("{}:\n{}", row.name, last_lines(&outcome.output)));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

fn scene() -> Scene {
    let sphere = |x: f64, y: f64, z: f64| Grain {
        density: 2500.0,
        ..Grain::sphere(5e-3, [x, y, z])
    };
    Scene {
        low: [-0.07, -0.07, -0.05],
        high: [0.07, 0.07, 0.05],
        ..Scene::open(
            1.0,
            vec![
                sphere(0.0113, 0.0071, 4.99e-3),
                sphere(0.0212, 0.0071, 5.02e-3).moving([-0.3, 0.02, -0.1]),
                sphere(-0.0227, 0.0113, 5.01e-3).moving([0.05, 0.1, -0.2]),
                sphere(-0.0227, -0.0213, 0.02).moving([0.0, 0.0, -3.0]),
            ],
        )
    }
}

/// A square at z = 14.9 mm, between the last grain and the sheet.
fn gate() -> String {
    sheet(1).replace(" 0\n", " 1.49e-2\n")
}

fn directory(name: &str) -> PathBuf {
    let directory = fresh_directory(&name.replace([' ', '/', ','], "_"));
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    fs::write(directory.join("gate.stl"), gate()).unwrap();
    directory
}

fn lines(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| word.to_string()).collect()
}

fn run_works(row: &Works, ours: bool) -> Outcome {
    let engine = Engine::from_environment();
    let mut before = lines(row.before);
    if row.mesh && before.is_empty() {
        before.push("fix sheet all mesh/surface file sheet.stl type 1".into());
    }
    let deck = Deck {
        model: if ours {
            format!("{} surface ellipsoid", row.model)
        } else {
            row.model.into()
        },
        atom_style: if ours { "superquadric" } else { "sphere" }.into(),
        wall_fix: if ours {
            "wall/gran/ellipsoid"
        } else {
            "wall/gran"
        }
        .into(),
        walls: vec![format!(
            "{} {}",
            if row.mesh {
                "mesh n_meshes 1 meshes sheet"
            } else {
                "primitive type 1 zplane 0.0"
            },
            row.wall_words
        )],
        before,
        fixes: lines(row.fixes),
        time_step: 1e-5,
        steps: 200,
        thermo: format!("step {}", row.columns),
        ..Deck::new(ELASTIC, 0.5)
    };
    let name = format!("{} {}", row.name, if ours { "ours" } else { "theirs" });
    let scene = Scene {
        boundary: row.boundary.into(),
        ..scene()
    };
    attempt_in(&engine, &directory(&name), &scene, &deck, 1)
}

#[test]
fn what_works_is_as_with_spheres() {
    let mut failures = vec![];
    for row in WORKS {
        let [ours, theirs] = [true, false].map(|ours| run_works(row, ours));
        for (who, outcome) in [("ours", &ours), ("theirs", &theirs)] {
            if !outcome.success {
                failures.push(format!(
                    "{}, {who}:\n{}",
                    row.name,
                    last_lines(&outcome.output)
                ));
            }
        }
        if !ours.success || !theirs.success {
            continue;
        }
        let mut worst = 0.0f64;
        for (a, b) in ours.last().states.iter().zip(&theirs.last().states) {
            worst = worst.max(length(sub(a.velocity, b.velocity)));
        }
        let last = |outcome: &Outcome| -> HashMap<String, f64> { outcome.thermo().pop().unwrap() };
        let (a, b) = (last(&ours), last(&theirs));
        let mut columns = 0.0f64;
        for (name, value) in &b {
            let apart = (a[name] - value).abs() / value.abs().max(1e-9);
            columns = columns.max(if apart.is_nan() { f64::INFINITY } else { apart });
        }
        println!(
            "{}: velocities apart by {worst:.1e}, columns by {columns:.1e}",
            row.name
        );
        if worst > row.tolerance || columns > 10.0 * row.tolerance {
            failures.push(format!("{}: {worst:e}, {a:?}, {b:?}", row.name));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn what_would_be_wrong_is_refused() {
    let engine = Engine::from_environment();
    let mut failures = vec![];
    for row in REFUSED {
        let mut grains = scene();
        grains.grains[0].semi_axes[2] = 4.99e-3;
        let (model, settings) = match row.model.split_once("ellipsoid ") {
            Some((model, settings)) => (format!("{model}ellipsoid"), settings),
            None => (row.model.into(), ""),
        };
        let deck = Deck {
            model,
            settings: settings.into(),
            before: lines(row.before),
            fixes: lines(row.fixes),
            steps: 20,
            ..Deck::new(ELASTIC, 0.5)
        };
        let outcome = attempt_in(&engine, &directory(row.name), &grains, &deck, 1);
        let output = outcome.output.to_lowercase();
        let said = output
            .lines()
            .find(|line| line.contains("error"))
            .unwrap_or("")
            .to_string();
        println!("{}: {said}", row.name);
        for word in row.words {
            if outcome.success || !said.contains(&word.to_lowercase()) {
                failures.push(format!(
                    "{}: no '{word}' in\n{}",
                    row.name,
                    last_lines(&outcome.output)
                ));
                break;
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

/// Spheres of `surface default` have their radius, which the cohesion models read.
#[test]
fn cohesion_of_spheres_is_that_under_hertz() {
    let engine = Engine::from_environment();
    let pull = |model: &str, cohesion: &str| {
        let deck = Deck {
            model: format!("{model} {cohesion}"),
            atom_style: "sphere".into(),
            before: vec![
                "fix coh all property/global cohesionEnergyDensity peratomtypepair 1 1e5".into(),
            ],
            time_step: 1e-9,
            ..Deck::new(ELASTIC, 0.5)
        };
        let mut grains = scene();
        for grain in &mut grains.grains {
            grain.velocity = [0.0; 3];
        }
        let name = format!("{model}{cohesion}");
        let outcome = attempt_in(&engine, &directory(&name), &grains, &deck, 1).succeeded();
        outcome.first().states[0].force
    };
    for cohesion in ["cohesion sjkr", "cohesion sjkr2"] {
        let [ours, theirs] =
            ["nfd", "hertz"].map(|model| sub(pull(model, cohesion), pull(model, "")));
        println!("{cohesion}: {ours:?}, {theirs:?}");
        assert!(theirs[0] > 0.0 && length(sub(ours, theirs)) < 1e-9 * length(theirs));
    }
}

/// LIGGGHTS has no superquadrics in two dimensions.
#[test]
fn two_dimensions_are_refused() {
    let engine = Engine::from_environment();
    let deck = "atom_style superquadric\ndimension 2\nboundary p p p\nunits si\n\
        region box block 0 1 0 1 -0.1 0.1 units box\ncreate_box 1 box\ncreate_atoms 1 single 0.5 0.5 0 units box\n";
    let (success, output) = execute(&engine, &directory("plane"), deck, 1);
    assert!(!success && output.contains("Superquadrics in 2D are not implemented"));
}

/// The table of the page names what runs here, and says of each what happens here.
#[test]
fn the_page_has_these_rows() {
    let page = fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/liggghts-patch/README.md"
    ))
    .unwrap();
    let section = page
        .split("## What LIGGGHTS' own commands do with ellipsoids")
        .nth(1)
        .expect("the page has the section");
    let mut told = BTreeMap::new();
    for line in section.split("\n## ").next().unwrap().lines() {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        if cells.len() < 4 || !cells[1].starts_with('`') {
            continue;
        }
        for name in cells[1].split("`, `") {
            told.insert(name.replace('`', ""), cells[2].to_string());
        }
    }
    let runs = WORKS
        .iter()
        .map(|row| (row.name, "works"))
        .chain(REFUSED.iter().map(|row| (row.name, "refused")))
        .chain([("dimension 2", "refused")])
        .chain(ALONE.iter().map(|row| (row.name, row.verdict)));
    for (name, verdict) in runs {
        assert_eq!(told.get(name).map(String::as_str), Some(verdict), "{name}");
    }
}
