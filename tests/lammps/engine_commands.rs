// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does every row of the table "Commands of LAMMPS with these grains" in `lammps-plugin/README.md` hold?
//!
//! A row says that a command works, differs from what its name suggests, or is refused. A deck here shows it. Where it does not
//! fail, it prints lines `HELD a b tolerance`: two numbers from independent ways that must agree.

use std::collections::BTreeSet;

use crate::harness::{attempt, crowd, largest_difference, run, Deck, Engine, Outcome, Scene};
use crate::shapes::scale;

const LAW: &str = "nfd 1e7 0.3 200 200 tangential mindlin 0.5";
const TABLE: &str = include_str!("../../lammps-plugin/README.md");

/// Grains in contact with each other, in a periodic box.
fn packed() -> Scene {
    let mut scene = crowd(27);
    for grain in &mut scene.grains {
        grain.position = scale(0.85, grain.position);
    }
    scene.high = scale(0.85, scene.high);
    scene
}

#[derive(Clone)]
enum Expected {
    /// The motion is that of the plain deck.
    SameMotion,
    /// The lines `HELD a b tolerance` agree.
    Numbers,
    /// The run stops; all the words are in the message.
    Refused(&'static [&'static str]),
}

#[derive(Clone)]
struct Case {
    row: &'static str,
    /// Replaces the integrator when not empty.
    integrator: &'static str,
    commands: &'static str,
    runs: &'static str,
    before_data: &'static str,
    after_data: &'static str,
    pair: &'static str,
    boundary: &'static str,
    atom_style: &'static str,
    newton: bool,
    ranks: usize,
    expected: Expected,
}

fn works(row: &'static str) -> Case {
    Case {
        row,
        integrator: "fix move all nve/asphere",
        commands: "",
        runs: "run 60",
        before_data: "",
        after_data: "",
        pair: "",
        boundary: "p p p",
        atom_style: "ellipsoid",
        newton: true,
        ranks: 1,
        expected: Expected::SameMotion,
    }
}

/// Commands before the run, and what holds after it.
fn held(row: &'static str, commands: &'static str, runs: &'static str) -> Case {
    Case {
        commands,
        runs,
        expected: Expected::Numbers,
        ..works(row)
    }
}

fn refused(row: &'static str, commands: &'static str, words: &'static [&'static str]) -> Case {
    Case {
        commands,
        expected: Expected::Refused(words),
        ..works(row)
    }
}

fn lines(text: &str) -> Vec<String> {
    text.lines()
        .map(|l| l.trim().to_string())
        .filter(|l| !l.is_empty())
        .collect()
}

impl Case {
    fn deck(&self) -> Deck {
        let mut deck = Deck::new(LAW);
        if !self.pair.is_empty() {
            deck.pair = lines(&self.pair.replace("LAW", LAW));
        }
        deck.atom_style = self.atom_style.into();
        deck.newton = self.newton;
        deck.skin = 2e-3;
        deck.time_step = 1e-5;
        deck.steps = 60;
        deck.integrate = false;
        deck.before_data = lines(self.before_data);
        deck.pair.splice(0..0, lines(self.after_data));
        deck.fixes = lines(self.integrator);
        deck.fixes.extend(lines(self.commands));
        deck.runs = lines(self.runs);
        deck
    }

    fn run(&self, engine: &Engine) -> Outcome {
        let mut scene = packed();
        scene.boundary = self.boundary.into();
        let name = self.row.replace(|c: char| !c.is_alphanumeric(), "_");
        attempt(engine, &name, &scene, &self.deck(), self.ranks)
    }

    /// What is wrong, if anything.
    fn fault(&self, engine: &Engine, reference: &Outcome) -> Option<String> {
        let outcome = self.run(engine);
        let words = match &self.expected {
            Expected::Refused(words) => {
                let Some(from) = outcome.output.find("ERROR") else {
                    return Some("the run went on to its end".into());
                };
                return words
                    .iter()
                    .find(|w| !outcome.output[from..].contains(**w))
                    .map(|w| format!("'{w}' is not in {}", &outcome.output[from..]));
            }
            Expected::SameMotion => {
                if !outcome.success || outcome.frames.is_empty() {
                    return Some(crate::harness::last_lines(&outcome.output));
                }
                let (positions, velocities) = largest_difference(outcome.last(), reference.last());
                println!(
                    "{}: positions {positions:.1e}, velocities {velocities:.1e}",
                    self.row
                );
                return (positions > 1e-10 || velocities > 1e-10).then(|| {
                    format!("positions differ by {positions:e}, velocities by {velocities:e}")
                });
            }
            Expected::Numbers => {
                if !outcome.success {
                    return Some(crate::harness::last_lines(&outcome.output));
                }
                outcome
                    .output
                    .lines()
                    .filter_map(|l| l.strip_prefix("HELD "))
            }
        };
        let mut count = 0;
        for line in words {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(|w| w.parse().unwrap_or(f64::NAN))
                .collect();
            let [a, b, tolerance] = numbers[..] else {
                return Some(format!("HELD {line}"));
            };
            println!("{}: {a} {b}", self.row);
            count += 1;
            let agree = (a - b).abs() <= tolerance * a.abs().max(b.abs());
            if !agree {
                return Some(format!("{a} is not {b} within {tolerance}"));
            }
        }
        (count == 0).then(|| "nothing was held".into())
    }
}

/// Forces, prescribed motions, rigid bodies.
fn forces() -> Vec<Case> {
    vec![
        held("`fix gravity`", "variable v0 equal $(vcm(all,z):%.17g)\nfix g all gravity 9.81 vector 0 0 -1",
            "run 60\nprint \"HELD $(vcm(all,z)-v_v0:%.17g) $(-9.81*60e-5:%.17g) 1e-9\""),
        held("`fix addforce`", "variable v0 equal $(vcm(all,x):%.17g)\nfix g all addforce 3 0 0",
            "run 60\nprint \"HELD $(vcm(all,x)-v_v0:%.17g) $(3*count(all)*60e-5/mass(all):%.17g) 1e-9\""),
        held("`fix setforce`", "variable k0 equal $(ke(all):%.17g)\nfix g all setforce 0 0 0",
            "run 60\nprint \"HELD $(ke(all):%.17g) ${k0} 1e-12\""),
        held("`fix aveforce`", "variable k0 equal $(ke(all):%.17g)\nfix g all aveforce 0 0 0",
            "run 60\nprint \"HELD $(ke(all):%.17g) ${k0} 1e-9\""),
        Case { integrator: "group a id 1:9\ngroup b subtract all a\nvelocity a set 0 0 0\nset group a angmom 0 0 0\nfix f a freeze\nfix move b nve/asphere",
            ..held("`fix freeze`", "compute d a displace/atom\ncompute s a reduce max c_d[4]",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) 0 0\"\nprint \"HELD $(ke(a)) 0 0\"\nprint \"HELD $(fcm(a,x)) 0 0\"") },
        Case { integrator: "group a id 1:3\ngroup b subtract all a\nfix f a rigid single\nfix move b nve/asphere", ranks: 2,
            before_data: "atom_modify map yes",
            ..held("`fix rigid`, `fix rigid/small`", "variable d equal sqrt((x[1]-x[2])^2+(y[1]-y[2])^2+(z[1]-z[2])^2)\nvariable size equal $(sqrt(2*ke(all)*mass(all)):%.17g)\nvariable p equal vcm(all,x)*mass(all)+v_size\nrun 0\nvariable d0 equal $(v_d:%.17g)\nvariable p0 equal $(v_p:%.17g)",
            "run 60\nprint \"HELD $(v_d:%.17g) ${d0} 1e-9\"\nprint \"HELD $(v_p:%.17g) ${p0} 1e-9\"") },
        Case { integrator: "group a id 1:3\ngroup b subtract all a\nfix f a move linear 1 0.5 0\nfix move b nve/asphere",
            ..held("`fix move`", "compute d a displace/atom\ncompute s a reduce min c_d[1]\ncompute t a reduce max c_d[1]",
            "thermo_style custom step c_s c_t\nrun 60\nprint \"HELD $(c_s:%.17g) 60e-5 1e-9\"\nprint \"HELD $(c_t:%.17g) 60e-5 1e-9\"") },
        held("`fix viscous`", "neigh_modify exclude group all all\nvariable k0 equal $(vcm(all,x):%.17g)\nvariable m equal $(mass(all))\nfix g all viscous 0.0\ncompute l all property/atom angmomx\ncompute s all reduce sumsq c_l\nthermo_style custom step c_s\nrun 0\nvariable l0 equal $(c_s:%.17g)\nunfix g\nfix g all viscous 0.5",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\""),
        held("`fix langevin`", "neigh_modify exclude group all all\ncompute l all property/atom angmomx\ncompute s all reduce sumsq c_l\nthermo_style custom step c_s\nrun 0\nvariable l0 equal $(c_s:%.17g)\nfix g all langevin 1e20 1e20 0.01 123",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\""),
        Case { boundary: "p p f", ..held("`fix wall/reflect`, `fix wall/region` and walls of points",
            "neigh_modify exclude group all all\nset group all z 0.005\nvelocity all set 0 0 -20\nfix w all wall/reflect zlo EDGE",
            "run 60\nprint \"HELD $(bound(all,zmin):%.17g) 0.007 1e-9\"\nprint \"HELD $(vcm(all,z)) 20 1e-9\"") },
    ]
}

/// Integrators, barostats, the box.
fn integration() -> Vec<Case> {
    vec![
        works("`fix nve/asphere`"),
        Case { integrator: "fix move all nvt/asphere temp 1.0 1.0 1.0e12", ..works("`fix nvt/asphere`, `fix nph/asphere`, `fix npt/asphere`") },
        held("`fix press/berendsen`", "fix p all press/berendsen iso 1e9 1e9 1.0 modulus 1e9\ncompute sh all property/atom shapex\ncompute s all reduce sum c_sh\nthermo_style custom step c_s\nrun 0\nvariable s0 equal $(c_s:%.17g)",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\""),
        Case { ranks: 4, ..held("`fix deform`", "variable l0 equal $(lx:%.17g)\nvariable v0 equal $(vol:%.17g)\nfix p all deform 1 x erate 10 remap v",
            "run 60\nprint \"HELD $(lx:%.17g) $(v_l0*(1+10*60e-5):%.17g) 1e-9\"") },
        Case { integrator: "fix move all nve/limit 1e-3", ..held("`fix nve/limit`, `fix nve/noforce`", "compute q all property/atom quatw\ncompute s all reduce sum c_q\nthermo_style custom step c_s\nrun 0\nvariable s0 equal $(c_s:%.17g)",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\"") },
        Case { integrator: "fix move all nve", ..refused("`fix nve`, `fix nvt`, `fix nph`, `fix npt`", "", &["nve", "/asphere", "turn"]) },
        Case { integrator: "fix move all nve/sphere", ..refused("`fix nve/sphere` and its like", "", &["nve/sphere"]) },
        Case { runs: "run_style respa 2 2\nrun 60", ..refused("`run_style respa`", "", &["rRESPA", "verlet"]) },
        held("`minimize`", "compute q all property/atom quatw\ncompute s all reduce sum c_q\nthermo_style custom step c_s pe\nrun 0\nvariable s0 equal $(c_s:%.17g)\nvariable e0 equal $(pe:%.17g)\nmin_modify dmax 1e-5",
            "minimize 0 0 5 20\nprint \"HELD $(pe<v_e0) 1 0\"\nrun 0\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\""),
        Case { after_data: "change_box all triclinic", ..works("`change_box`, triclinic boxes") },
        Case { after_data: "displace_atoms all rotate 0.03 0.03 0.03 0 0 1 90\ndisplace_atoms all rotate 0.03 0.03 0.03 0 0 1 -90", ..works("`displace_atoms`") },
        Case { runs: "run 60 every 20 \"print goes\"\nprint \"HELD $(step) 60 0\"", expected: Expected::Numbers, ..works("`run ... every`, `run ... pre no`") },
    ]
}

/// Neighbours, communication, pair styles around ours, accelerators.
fn decomposition() -> Vec<Case> {
    vec![
        Case { ranks: 4, commands: "fix b all balance 20 1.0 shift xyz 5 1.0", ..works("`fix balance`, `balance`") },
        Case { ranks: 4, before_data: "comm_style tiled", commands: "fix b all balance 20 1.0 rcb", ..works("`comm_style tiled`") },
        Case { commands: "neighbor 2e-3 multi", ..works("`neighbor ... multi`, `neighbor ... nsq`") },
        Case { newton: false, ranks: 2, ..works("`newton off`") },
        Case { before_data: "package omp 2\nsuffix omp", ..works("`suffix omp`, `suffix opt`") },
        Case { pair: "pair_style hybrid/overlay gran/ellipsoid lj/cut 0.01\npair_coeff * * gran/ellipsoid LAW\npair_coeff * * lj/cut 0 1", ..works("`pair_style hybrid`, `pair_style hybrid/overlay`") },
        held("`neigh_modify exclude`", "variable k0 equal $(ke(all):%.17g)\nneigh_modify exclude group all all", "run 60\nprint \"HELD $(ke(all):%.17g) ${k0} 1e-12\""),
        Case { after_data: "replicate 2 1 1", runs: "run 0\nprint \"HELD $(atoms) 54 0\"", expected: Expected::Numbers, ..works("`replicate` before the first run") },
        Case { runs: "run 1\nreplicate 2 1 1", ..refused("`replicate` after a run", "", &["replicate"]) },
        Case { runs: "run 1\nreset_atoms id", ..refused("`reset_atoms id` after a run", "", &["storing atom IDs"]) },
        Case { runs: "run 30\ngroup gone id 27\ndelete_atoms group gone compress yes\nrun 30\nprint \"HELD $(atoms) 26 0\"\nprint \"HELD $(vx[26]!=0) 1 0\"", expected: Expected::Numbers, before_data: "atom_modify map yes", ..works("`delete_atoms`") },
        Case { runs: "create_atoms 1 single 0.001 0.001 0.001\nrun 1", ..refused("`create_atoms` without `set ... shape`", "", &["28", "shape"]) },
        held("`write_data`, `read_data`", "run 0\nvariable e0 equal $(pe:%.17g)", "write_data whole.data\nrun 0\nprint \"HELD $(pe:%.17g) ${e0} 1e-12\""),
    ]
}

/// Computes.
fn outputs() -> Vec<Case> {
    vec![
        held("`compute stress/atom`, `compute pressure`", "compute s all stress/atom NULL pair\ncompute r all reduce sum c_s[1] c_s[4]\ncompute p all pressure NULL pair",
            "thermo_style custom step c_r[*] c_p[1] c_p[4]\nrun 60\nprint \"HELD $(-c_r[1]/vol:%.17g) $(c_p[1]:%.17g) 1e-9\"\nprint \"HELD $(-c_r[2]/vol:%.17g) $(c_p[4]:%.17g) 1e-9\""),
        held("`compute pe/atom`", "compute s all pe/atom\ncompute r all reduce sum c_s",
            "thermo_style custom step c_r pe\nrun 60\nprint \"HELD $(c_r:%.17g) $(pe:%.17g) 1e-9\""),
        held("`compute erotate/asphere`", "compute e all erotate/asphere\ncompute b all property/atom angmomx angmomy angmomz\nthermo_style custom step c_e\nneigh_modify exclude group all all\nrun 0\nvariable e0 equal $(c_e:%.17g)",
            "run 60\nprint \"HELD $(c_e:%.17g) ${e0} 1e-3\""),
        held("`compute temp/asphere`", "compute t all temp/asphere dof all\ncompute e all erotate/asphere\nthermo_style custom step c_t c_e",
            "run 1\nprint \"HELD $(0.5*c_t*(6*count(all)-3)*1.380649e-23:%.17g) $(ke(all)+c_e:%.17g) 1e-3\""),
        held("`compute ke`, `compute temp`", "compute k all ke\ncompute m all property/atom mass\nthermo_style custom step c_k",
            "run 1\nset group all angmom 0 0 0\nvariable k1 equal $(c_k:%.17g)\nprint \"HELD $(ke(all):%.17g) ${k1} 1e-12\""),
        held("`compute coord/atom`, `compute cluster/atom`", "neigh_modify one 5000\ncompute c all coord/atom cutoff 0.02\ncompute s all reduce sum c_c\ncompute v all coord/atom cutoff 0.001\ncompute w all reduce sum c_v\nthermo_style custom step c_s c_w",
            "run 1\nprint \"HELD $(c_w) 0 0\"\nprint \"HELD $(c_s>0) 1 0\""),
        held("`compute pair/local`, `compute property/local`", "compute c all pair/local p12\ncompute n all reduce sum c_c inputs local\ncompute e all pair gran/ellipsoid\ncompute f all pair/local eng\ncompute g all reduce sum c_f inputs local\nthermo_style custom step c_n c_g pe",
            "run 1\nprint \"HELD $(c_n>0) 1 0\"\nprint \"HELD $(c_g:%.17g) $(pe:%.17g) 1e-6\""),
        refused("`compute centroid/stress/atom`", "compute c all centroid/stress/atom NULL", &["centroid/stress/atom"]),
        refused("`compute group/group`", "group a id 1:9\ncompute g a group/group all", &["group/group", "line of centres", "pair/local"]),
        refused("`compute temp/sphere`, `compute erotate/sphere`", "compute t all temp/sphere", &["temp/sphere"]),
        Case { runs: "rerun some.dump dump x y z", ..refused("`rerun`", "", &["rerun", "orientations", "read_restart"]) },
    ]
}

/// What the oldest supported LAMMPS cannot run: it lacks some styles, and evaluates per-atom sums only in steps with output.
fn newest() -> Vec<Case> {
    let superellipsoid = |case: Case| Case {
        atom_style: "ellipsoid superellipsoid",
        ..case
    };
    vec![
        held("`fix addtorque/atom`",
            "neigh_modify exclude group all all\ncompute l all property/atom angmomx\ncompute s all reduce sum c_l\nrun 0\nvariable l0 equal $(c_s:%.17g)\nfix g all addtorque/atom 1e-3 0 0",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s-v_l0:%.17g) $(1e-3*count(all)*60e-5:%.17g) 1e-9\""),
        held("`fix settorque/atom`",
            "compute l all property/atom angmomx angmomy angmomz\ncompute s all reduce sumsq c_l[*]\nthermo_style custom step c_s[*]\nrun 0\nvariable l0 equal $(c_s[1]+c_s[2]+c_s[3]:%.17g)\nfix g all settorque/atom 0 0 0",
            "thermo_style custom step c_s[*]\nrun 60\nprint \"HELD $(c_s[1]+c_s[2]+c_s[3]:%.17g) ${l0} 1e-12\""),
        held("`compute heat/flux`", "compute k all ke/atom\ncompute p all pe/atom\ncompute s all stress/atom NULL virial\ncompute h all heat/flux k p s\nset group all angmom 0 0 0\nthermo_style custom step c_h[1]\nrun 0\nvariable h0 equal $(c_h[1]:%.17g)\nset group all angmom 1e-3 0 0\nvariable same equal $(c_h[1]:%.17g)",
            "print \"HELD ${h0} ${same} 1e-12\""),
        superellipsoid(refused("`compute contact/atom`, `compute fabric`, `compute rattlers/atom`", "compute c all contact/atom", &["contact/atom", "enclosing spheres", "p12"])),
        superellipsoid(refused("`fix adapt ... diameter`", "variable d equal 0.01\nfix a all adapt 1 atom diameter v_d", &["adapt", "shape"])),
        superellipsoid(Case { boundary: "p p f", ..refused("`fix pour`, `fix deposit`", "region top block 0 0.05 0 0.05 0.04 0.06\nfix p all pour 1 1 123 region top diam one 0.01", &["pour", "no shape"]) }),
        superellipsoid(Case { boundary: "p p f", ..refused("`fix wall/gran`, `fix wall/gran/region`", "fix w all wall/gran hertz/history 1e6 NULL 50 NULL 0.5 1 zplane 0 NULL", &["wall/gran"]) }),
        refused("`fix heat/flow`", "fix t all property/atom temperature heatflow\nfix h all heat/flow constant 1", &["heat/flow", "conduct"]),
        Case { pair: "pair_style gran/ellipsoid 0.05\npair_coeff * * LAW", ..held("`fix set ... shape`", "compute sh all property/atom shapex\ncompute m all reduce sum c_sh\nvariable a atom 0.02+1e-5*step\nthermo_style custom step c_m\nfix grow all set 1 0 group all shape v_a v_a v_a",
            "run 10\nprint \"HELD $(c_m:%.17g) $(count(all)*(0.02+1e-4):%.17g) 1e-9\"") },
    ]
}

fn hold(cases: Vec<Case>) {
    let engine = Engine::from_environment();
    let reference = run(
        &engine,
        "reference",
        &packed(),
        &works("reference").deck(),
        1,
    );
    let faults: Vec<String> = cases
        .iter()
        .filter_map(|case| {
            Some(format!(
                "{}: {}",
                case.row,
                case.fault(&engine, &reference)?
            ))
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}

#[test]
fn both_versions_forces_and_motions_are_as_the_table_says() {
    hold(forces());
}

#[test]
fn both_versions_integrators_and_boxes_are_as_the_table_says() {
    hold(integration());
}

#[test]
fn both_versions_decomposition_is_as_the_table_says() {
    hold(decomposition());
}

#[test]
fn both_versions_outputs_are_as_the_table_says() {
    hold(outputs());
}

#[test]
fn commands_of_the_newest_lammps_are_as_the_table_says() {
    hold(newest());
}

/// A row without a deck, a deck without a row, or a verdict that the deck does not show.
#[test]
fn both_versions_the_table_has_a_deck_for_each_row() {
    let from = TABLE
        .find("## Commands of LAMMPS with these grains")
        .unwrap();
    let section = &TABLE[from..];
    let section = &section[..section[3..].find("\n## ").map_or(section.len(), |k| k + 3)];
    let rows: BTreeSet<(String, bool)> = section
        .lines()
        .filter(|l| l.starts_with("| `"))
        .map(|l| {
            let cells: Vec<&str> = l.split(" | ").collect();
            let verdict = cells[1].trim();
            assert!(["works", "differs", "refused"].contains(&verdict), "{l}");
            (
                cells[0].trim_start_matches("| ").trim().to_string(),
                verdict == "refused",
            )
        })
        .collect();
    let decks: BTreeSet<(String, bool)> = [
        forces(),
        integration(),
        decomposition(),
        outputs(),
        newest(),
    ]
    .concat()
    .iter()
    .map(|c| {
        (
            c.row.to_string(),
            matches!(c.expected, Expected::Refused(_)),
        )
    })
    .collect();
    assert_eq!(rows, decks);
}
