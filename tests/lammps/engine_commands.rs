// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does every row of the table "Commands of LAMMPS with these grains" in `lammps-plugin/README.md` hold?
//!
//! A row says that a command works, differs from what its name suggests, or is refused. A deck here shows it. Where it does not
//! fail, it prints lines `HELD a b tolerance`: two numbers from independent ways that must agree.

use std::collections::BTreeSet;

use crate::harness::{attempt, crowd, largest_difference, run, Deck, Engine, Outcome, Scene};
use crate::refusal;
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
    /// As `Numbers`; a LAMMPS without this package must say so.
    NumbersWithPackage(&'static str),
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

/// Grain 1 alone is moved: its displacement along x after the run, and the cosine of half the angle by which it has turned.
fn moved(motion: &str, displacement: &str, cosine: &str) -> Case {
    let leak = |text: String| -> &'static str { text.leak() };
    Case {
        integrator: leak(format!("variable d equal 1.5*1e-5*step\nvariable v equal 1.5\nset atom 1 angmom 0 0 0\ngroup a id 1\ngroup b subtract all a\nfix f a move {motion}\nfix move b nve/asphere")),
        before_data: "atom_modify map yes",
        ..held(
            "`fix move`",
            "compute d a displace/atom\ncompute s a reduce sum c_d[1]\ncompute q a property/atom quatw quati quatj quatk\ncompute r a reduce sum c_q[*]\nthermo_style custom step c_s c_r[*]\nrun 0\nvariable w equal $(c_r[1]:%.17g)\nvariable i equal $(c_r[2]:%.17g)\nvariable j equal $(c_r[3]:%.17g)\nvariable k equal $(c_r[4]:%.17g)",
            leak(format!("run 60\nprint \"HELD $(c_s:%.17g) $({displacement}:%.17g) 1e-9\"\nprint \"HELD $(v_w*c_r[1]+v_i*c_r[2]+v_j*c_r[3]+v_k*c_r[4]:%.17g) $({cosine}:%.17g) 1e-9\"")),
        )
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
        if self.before_data == "dimension 2" {
            // one layer in the plane z = 0, which must be within the box
            scene.low[2] = -scene.high[2];
            scene.grains.truncate(9);
            for grain in &mut scene.grains {
                grain.position[2] = 0.0;
            }
        }
        let name = self.row.replace(|c: char| !c.is_alphanumeric(), "_");
        attempt(engine, &name, &scene, &self.deck(), self.ranks)
    }

    /// What is wrong, if anything.
    fn fault(&self, engine: &Engine, reference: &Outcome) -> Option<String> {
        let outcome = self.run(engine);
        let words = match &self.expected {
            Expected::Refused(words) => {
                return refusal::fault(self.row, outcome.success, &outcome.output, words);
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
            Expected::NumbersWithPackage(package)
                if !outcome.success && outcome.output.contains(package) =>
            {
                return None;
            }
            Expected::Numbers | Expected::NumbersWithPackage(_) => {
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
        Case { integrator: "fix p all property/atom i_body ghost yes\ngroup a id 1:3\ngroup b subtract all a\nset group all i_body 0\nset group a i_body 1\nfix f a rigid/small custom i_body\nfix move b nve/asphere", ranks: 2,
            before_data: "atom_modify map yes",
            ..held("`fix rigid`, `fix rigid/small`", "variable d equal sqrt((x[1]-x[2])^2+(y[1]-y[2])^2+(z[1]-z[2])^2)\nrun 0\nvariable d0 equal $(v_d:%.17g)",
            "run 60\nprint \"HELD $(v_d:%.17g) ${d0} 1e-9\"") },
        Case { integrator: "group a id 1:3\ngroup b subtract all a\nfix f a move linear 1 0.5 0\nfix move b nve/asphere",
            ..held("`fix move`", "compute d a displace/atom\ncompute s a reduce min c_d[1]\ncompute t a reduce max c_d[1]",
            "thermo_style custom step c_s c_t\nrun 60\nprint \"HELD $(c_s:%.17g) 60e-5 1e-9\"\nprint \"HELD $(c_t:%.17g) 60e-5 1e-9\"") },
        moved("wiggle 0.001 0 0 0.012", "0.001*sin(0.1*PI)", "1"),
        moved("variable v_d NULL NULL v_v NULL NULL", "1.5*60e-5", "1"),
        moved("transrot 1.5 0 0 $(x[1]) $(y[1]) $(z[1]) 0 0 1 0.012", "1.5*60e-5", "cos(0.05*PI)"),
        held("`fix viscous`", "neigh_modify exclude group all all\nfix s all store/state 0 vx\nvariable r atom \"vx/f_s*exp(0.5*60e-5/mass)\"\ncompute least all reduce min v_r\ncompute most all reduce max v_r\ncompute l all property/atom angmomx\ncompute s all reduce sumsq c_l\nthermo_style custom step c_s\nrun 0\nvariable l0 equal $(c_s:%.17g)\nfix g all viscous 0.5",
            "thermo_style custom step c_s c_least c_most\nrun 60\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\"\nprint \"HELD $(c_least:%.17g) 1 1e-4\"\nprint \"HELD $(c_most:%.17g) 1 1e-4\""),
        Case { after_data: "set group all angmom 1e-4 2e-4 -1e-4", ..held("`fix langevin`", "neigh_modify exclude group all all\ncompute l all property/atom angmomx angmomy angmomz\ncompute s all reduce sumsq c_l[*]\nvariable l equal c_s[1]+c_s[2]+c_s[3]\nthermo_style custom step ke v_l\nrun 0\nvariable l0 equal $(v_l:%.17g)\nvariable k0 equal $(ke:%.17g)\nfix g all langevin 0 0 0.01 123",
            "thermo_style custom step ke v_l\nrun 60\nprint \"HELD $(v_l:%.17g) ${l0} 1e-12\"\nprint \"HELD $(ke:%.17g) $(v_k0*exp(-0.12):%.17g) 1e-3\"\nvariable k0 equal $(ke:%.17g)\nfix g all langevin 0 0 0.01 123 angmom 1.0\nrun 60\nprint \"HELD $(v_l<0.95*v_l0) 1 0\"\nprint \"HELD $(ke:%.17g) $(v_k0*exp(-0.12):%.17g) 1e-3\"") },
        held("`fix temp/berendsen`, `fix temp/rescale`", "neigh_modify exclude group all all\ncompute l all property/atom angmomx\ncompute s all reduce sumsq c_l\nthermo_style custom step temp c_s\nrun 0\nvariable l0 equal $(c_s:%.17g)\nvariable t0 equal $(temp:%.17g)\nfix g all temp/rescale 1 $(0.5*v_t0) $(0.5*v_t0) 0 1.0",
            "thermo_style custom step temp c_s\nrun 60\nprint \"HELD $(temp:%.17g) $(0.5*v_t0:%.17g) 1e-9\"\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\""),
        held("`velocity`, `fix momentum`", "compute l all property/atom angmomx\ncompute s all reduce sumsq c_l\nthermo_style custom step c_s\nrun 0\nvariable l0 equal $(c_s:%.17g)\nvelocity all create 1e20 4711 rot yes mom yes\nrun 0\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\"\nneigh_modify exclude group all all\nvelocity all set 1 2 3 sum yes\nfix g all momentum 1 linear 1 1 1 angular",
            "run 60\nprint \"HELD $(c_s:%.17g) ${l0} 1e-12\"\nprint \"HELD $(vcm(all,x)<1e-12) 1 0\""),
        held("`fix indent`", "neigh_modify exclude group all all\nset group all z 0.05\nvelocity all set 0 0 -20\nfix g all indent 1e9 plane z 0.04 lo",
            "run 60\nprint \"HELD $(bound(all,zmin)<0.041) 1 0\"\nprint \"HELD $(bound(all,zmin)>0.035) 1 0\""),
        refused("`fix adapt ... pair`", "variable e equal 1e7\nfix a all adapt 1 pair gran/ellipsoid E * * v_e", &["not supported"]),
        Case { boundary: "p p f", ..held("`fix wall/reflect`, `fix wall/region` and walls of points",
            "neigh_modify exclude group all all\nset group all z 0.005\nvelocity all set 0 0 -20\nfix w all wall/reflect zlo EDGE",
            "run 60\nprint \"HELD $(bound(all,zmin):%.17g) 0.007 1e-9\"\nprint \"HELD $(vcm(all,z)) 20 1e-9\"") },
    ]
}

/// Elastic grains from one temperature and pressure towards twice as much of what the integrator controls.
fn controlled(integrator: &str, held: &str) -> Case {
    let leak = |text: String| -> &'static str { text.leak() };
    Case {
        pair: "pair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3",
        integrator: leak(format!("thermo_style custom step temp press vol\nrun 0\nvariable t equal $(temp:%.17g)\nvariable p equal $(press:%.17g)\nvariable l equal $(vol:%.17g)\nfix move all {integrator}")),
        ..held_of_integrators(leak(held.to_string()))
    }
}

fn held_of_integrators(after: &'static str) -> Case {
    held(
        "`fix nvt/asphere`, `fix nph/asphere`, `fix npt/asphere`",
        "compute e all erotate/asphere\ncompute q all property/atom quatw\ncompute w all reduce sum c_q\nvariable sum equal econserve+c_e\nthermo_style custom step temp press vol econserve c_e c_w v_sum\nrun 0\nvariable s0 equal $(v_sum:%.17g)\nvariable w0 equal $(c_w:%.17g)",
        after,
    )
}

/// Integrators, barostats, the box.
fn integration() -> Vec<Case> {
    vec![
        works("`fix nve/asphere`"),
        // what the thermostat conserves, with the energy of rotation
        controlled("nvt/asphere temp $(2*v_t) $(2*v_t) 1e-3", "thermo_style custom step temp press vol econserve c_e c_w v_sum\nrun 200\nprint \"HELD $(v_sum:%.17g) ${s0} 1e-3\"\nprint \"HELD $(temp>1.05*v_t) 1 0\"\nprint \"HELD $(abs(c_w-v_w0)>1e-3) 1 0\""),
        controlled("nph/asphere iso $(2*v_p) $(2*v_p) 3e-3", "thermo_style custom step temp press vol econserve c_e c_w v_sum\nrun 200\nprint \"HELD $(vol<0.999*v_l) 1 0\"\nprint \"HELD $(abs(c_w-v_w0)>1e-3) 1 0\""),
        controlled("npt/asphere temp $(2*v_t) $(2*v_t) 1e-3 iso $(2*v_p) $(2*v_p) 3e-3", "thermo_style custom step temp press vol econserve c_e c_w v_sum\nrun 200\nprint \"HELD $(vol<0.999*v_l) 1 0\"\nprint \"HELD $(temp>1.05*v_t) 1 0\"\nprint \"HELD $(abs(c_w-v_w0)>1e-3) 1 0\""),
        held("`fix press/berendsen`", "fix p all press/berendsen iso 1e9 1e9 1.0 modulus 1e9\ncompute sh all property/atom shapex\ncompute s all reduce sum c_sh\nthermo_style custom step c_s\nrun 0\nvariable s0 equal $(c_s:%.17g)",
            "thermo_style custom step c_s press lx\nvariable l0 equal $(lx:%.17g)\nrun 1\nprint \"HELD $(lx/v_l0-1) $((1-1e-5*(1e9-press)/1e9)^(1/3)-1) 1e-3\"\nrun 59\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\""),
        Case { ranks: 4, ..held("`fix deform`", "variable l0 equal $(lx:%.17g)\nvariable v0 equal $(vol:%.17g)\nfix p all deform 1 x erate 10 remap v",
            "run 60\nprint \"HELD $(lx:%.17g) $(v_l0*(1+10*60e-5):%.17g) 1e-9\"") },
        Case { integrator: "fix move all nve/limit 1e-3", ..held("`fix nve/limit`, `fix nve/noforce`", "compute q all property/atom quatw\ncompute s all reduce sum c_q\nthermo_style custom step c_s\nrun 0\nvariable s0 equal $(c_s:%.17g)",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\"") },
        Case { integrator: "fix move all nve/noforce", ..held("`fix nve/limit`, `fix nve/noforce`", "compute q all property/atom quatw\ncompute s all reduce sum c_q\nthermo_style custom step c_s\nrun 0\nvariable s0 equal $(c_s:%.17g)",
            "thermo_style custom step c_s\nrun 60\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\"") },
        Case { integrator: "fix move all nvt temp 1 1 1", ..refused("`fix nve`, `fix nvt`, `fix nph`, `fix npt`", "", &["nvt", "/asphere", "turn"]) },
        Case { integrator: "fix move all npt temp 1 1 1 iso 0 0 1", ..refused("`fix nve`, `fix nvt`, `fix nph`, `fix npt`", "", &["npt", "/asphere", "turn"]) },
        Case { integrator: "fix move all nvt/sllod temp 1 1 1\nfix d all deform 1 xy erate 1 remap v", after_data: "change_box all triclinic", ..refused("`fix nvt/sllod`", "", &["nvt/sllod", "turn"]) },
        Case { pair: "pair_style gran/ellipsoid\npair_coeff * * LAW", ..held("`fix dt/reset`", "fix d all dt/reset 5 NULL 1e-5 1e-6 units box\ncompute e all erotate/asphere\ncompute p all pair gran/ellipsoid\nvariable sum equal pe+ke+c_e+c_p[3]\nthermo_style custom step dt pe ke c_e v_sum\nrun 0\nvariable s0 equal $(v_sum:%.17g)",
            "thermo_style custom step dt pe ke c_e v_sum\nrun 300\nprint \"HELD $(v_sum:%.17g) ${s0} 1e-4\"\nprint \"HELD $(dt<2e-6) 1 0\"") },
        Case { integrator: "fix move all nve/asphere\nfix flat all enforce2d", before_data: "dimension 2", pair: "pair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3",
            after_data: "set group all quat 0 0 1 30\nset group all angmom 0 0 1e-4\nvelocity all set NULL NULL 0",
            ..held("`dimension 2`", "compute e all erotate/asphere\ncompute q all property/atom quati quatj\ncompute m all reduce maxabs c_q[1] c_q[2]\nvariable sum equal pe+ke+c_e\nthermo_style custom step pe ke c_e v_sum c_m[*]\nrun 0\nvariable s0 equal $(v_sum:%.17g)\nvariable k0 equal $(ke:%.17g)",
            "thermo_style custom step pe ke c_e v_sum c_m[*]\nrun 200\nprint \"HELD $(v_sum:%.17g) ${s0} 2e-3\"\nprint \"HELD $(abs(ke-v_k0)>1e-3*v_k0) 1 0\"\nprint \"HELD $(c_m[1]) 0 0\"\nprint \"HELD $(bound(all,zmax)) 0 0\"") },
        Case { integrator: "fix move all nve", ..refused("`fix nve`, `fix nvt`, `fix nph`, `fix npt`", "", &["nve", "/asphere", "turn"]) },
        Case { integrator: "fix move all nve/sphere", ..refused("`fix nve/sphere` and its like", "", &["nve/sphere", "omega"]) },
        Case { runs: "run_style respa 2 2\nrun 60", ..refused("`run_style respa`", "", &["rRESPA", "verlet"]) },
        held("`minimize`", "compute q all property/atom quatw\ncompute s all reduce sum c_q\nthermo_style custom step c_s pe\nrun 0\nvariable s0 equal $(c_s:%.17g)\nvariable e0 equal $(pe:%.17g)\nmin_modify dmax 1e-5",
            "minimize 0 0 5 20\nprint \"HELD $(pe<v_e0) 1 0\"\nrun 0\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\""),
        Case { after_data: "change_box all triclinic", ..works("`change_box`, triclinic boxes") },
        held("`change_box`, triclinic boxes", "compute sh all property/atom shapex\ncompute s all reduce sum c_sh\nthermo_style custom step c_s pe\nrun 0\nvariable s0 equal $(c_s:%.17g)\nvariable e0 equal $(pe:%.17g)\nvariable l0 equal $(lx:%.17g)",
            "change_box all x scale 1.02 remap\nrun 0\nprint \"HELD $(c_s:%.17g) ${s0} 1e-12\"\nprint \"HELD $(lx:%.17g) $(1.02*v_l0:%.17g) 1e-12\"\nprint \"HELD $(pe<0.9*v_e0) 1 0\"\nchange_box all x scale $(1/1.02:%.17g) remap\nrun 0\nprint \"HELD $(pe:%.17g) ${e0} 1e-9\""),
        // the pressure is the derivative of the energy by the volume
        Case { pair: "pair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3",
            ..held("`compute stress/atom`, `compute pressure`", "compute v all pressure NULL virial\nthermo_style custom step pe vol c_v\nrun 0\nvariable e0 equal $(pe:%.17g)\nvariable v0 equal $(vol:%.17g)\nvariable p0 equal $(c_v:%.17g)",
            "change_box all x scale 1.00001 y scale 1.00001 z scale 1.00001 remap\nrun 0\nprint \"HELD $((v_e0-pe)/(vol-v_v0):%.17g) $(0.5*(v_p0+c_v):%.17g) 1e-7\"") },
        // a quarter turn of a cubic box about its centre
        held("`displace_atoms`", "compute q all property/atom quatk\ncompute s all reduce sum c_q\nthermo_style custom step pe c_s\nrun 0\nvariable e0 equal $(pe:%.17g)\nvariable q0 equal $(c_s:%.17g)",
            "displace_atoms all rotate $(0.5*lx) $(0.5*ly) $(0.5*lz) 0 0 1 90\nrun 0\nprint \"HELD $(pe:%.17g) ${e0} 1e-9\"\nprint \"HELD $(abs(c_s-v_q0)>1e-3) 1 0\"\ndisplace_atoms all move 0.01 0 0\nrun 0\nprint \"HELD $(pe:%.17g) ${e0} 1e-9\""),
        Case { runs: "run 30\nrun 30 pre no\nprint \"HELD $(step) 60 0\"", pair: "pair_style gran/ellipsoid\npair_coeff * * LAW", ..works("`run ... every`, `run ... pre no`") },
        Case { runs: "run 60 every 20 \"print goes\"\nprint \"HELD $(step) 60 0\"", expected: Expected::Numbers, ..works("`run ... every`, `run ... pre no`") },
    ]
}

/// Neighbours, communication, pair styles around ours, accelerators.
fn decomposition() -> Vec<Case> {
    vec![
        Case { ranks: 4, commands: "fix b all balance 20 1.0 shift xyz 5 1.0", ..works("`fix balance`, `balance`") },
        Case { ranks: 4, commands: "balance 1.0 shift xyz 5 1.0", ..works("`fix balance`, `balance`") },
        Case { ranks: 4, before_data: "comm_style tiled", newton: false, commands: "fix b all balance 20 1.0 rcb", ..works("`comm_style tiled`") },
        Case { ranks: 4, before_data: "comm_style tiled", commands: "fix b all balance 20 1.0 rcb", ..works("`comm_style tiled`") },
        Case { commands: "neighbor 2e-3 multi", ..works("`neighbor ... multi`, `neighbor ... nsq`") },
        Case { commands: "neighbor 2e-3 nsq", ..works("`neighbor ... multi`, `neighbor ... nsq`") },
        Case { newton: false, ranks: 2, ..works("`newton off`") },
        Case { before_data: "package omp 2\nsuffix omp", ..works("`suffix omp`, `suffix opt`") },
        Case { before_data: "suffix opt", ..works("`suffix omp`, `suffix opt`") },
        Case { before_data: "suffix intel", ..works("`suffix intel`, `suffix gpu`, `suffix kk`") },
        Case { before_data: "suffix gpu", ..works("`suffix intel`, `suffix gpu`, `suffix kk`") },
        Case { before_data: "suffix kk", ..works("`suffix intel`, `suffix gpu`, `suffix kk`") },
        Case { before_data: "package kokkos", ..refused("`package gpu`, `package kokkos`, `package intel` without that package", "", &["Package kokkos command without KOKKOS"]) },
        Case { before_data: "package gpu 1", ..refused("`package gpu`, `package kokkos`, `package intel` without that package", "", &["Package gpu command without GPU"]) },
        Case { before_data: "package intel 1", ..refused("`package gpu`, `package kokkos`, `package intel` without that package", "", &["Package intel command without INTEL"]) },
        Case { pair: "pair_style hybrid gran/ellipsoid\npair_coeff * * gran/ellipsoid LAW", ..works("`pair_style hybrid`, `pair_style hybrid/overlay`") },
        // modulus and viscosities twice as large, at half their force
        Case { pair: "pair_style hybrid/scaled 0.5 gran/ellipsoid\npair_coeff * * gran/ellipsoid nfd 2e7 0.3 400 400 tangential mindlin 0.5", ..works("`pair_style hybrid/scaled`") },
        Case { pair: "pair_style hybrid/scaled 0.5 gran/ellipsoid\npair_coeff * * gran/ellipsoid hertz 1e7 0.3", ..held("`pair_style hybrid/scaled`", "compute p all pair gran/ellipsoid\nthermo_style custom step pe c_p[1]", "run 0\nprint \"HELD $(pe:%.17g) $(0.5*c_p[1]:%.17g) 1e-12\"") },
        refused("`comm_modify group`", "group a id 1:9\natom_modify first a\ncomm_modify group a", &["comm_modify group", "ghost"]),
        Case { runs: "pair_write 1 1 10 r 0.001 0.02 table.txt key", ..refused("`pair_write`", "", &["pair_write", "distance of centres"]) },
        refused("`kspace_style`", "kspace_style zero 1e-4", &["zero"]),
        Case { pair: "pair_style hybrid/overlay gran/ellipsoid lj/cut 0.01\npair_coeff * * gran/ellipsoid LAW\npair_coeff * * lj/cut 0 1", ..works("`pair_style hybrid`, `pair_style hybrid/overlay`") },
        held("`neigh_modify exclude`", "variable k0 equal $(ke(all):%.17g)\nneigh_modify exclude group all all", "run 60\nprint \"HELD $(ke(all):%.17g) ${k0} 1e-12\""),
        Case { after_data: "replicate 2 1 1", commands: "compute e all pe/atom\ngroup a id 1:27\ngroup b subtract all a\ncompute s a reduce sum c_e\ncompute t b reduce sum c_e\nthermo_style custom step pe c_s c_t", runs: "run 0\nprint \"HELD $(atoms) 54 0\"\nprint \"HELD $(c_s:%.17g) $(c_t:%.17g) 1e-9\"\nprint \"HELD $(c_s>0) 1 0\"", expected: Expected::Numbers, ..works("`replicate` before the first run") },
        Case { runs: "run 1\nreplicate 2 1 1", ..refused("`replicate` after a run", "", &["Cannot replicate"]) },
        Case { runs: "run 1\nreset_atoms id", ..refused("`reset_atoms id` after a run", "", &["storing atom IDs"]) },
        Case { runs: "run 30\ngroup gone id 27\ndelete_atoms group gone compress yes\nrun 30\nprint \"HELD $(atoms) 26 0\"\nprint \"HELD $(vx[26]!=0) 1 0\"", expected: Expected::Numbers, before_data: "atom_modify map yes", ..works("`delete_atoms`") },
        Case { runs: "create_atoms 1 single 0.001 0.001 0.001\nrun 1", ..refused("`create_atoms` without `set ... shape`", "", &["particle 28", "set type 1 shape"]) },
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
        held("`compute reduce`, `fix ave/time`, `fix ave/atom`, `fix ave/chunk`, `fix ave/histo`", "compute p all pair gran/ellipsoid\nfix t all ave/time 1 1 60 c_p[1]\ncompute e all pe/atom\nfix a all ave/atom 1 1 60 c_e\ncompute s all reduce sum c_e f_a\ncompute k all chunk/atom bin/1d x lower 1 units reduced\nfix c all ave/chunk 1 1 60 k c_e norm none\nfix h all ave/histo 1 1 60 0 1 1 c_e mode vector\nthermo_style custom step c_p[*] c_s[*] f_t f_c[1][3] f_h[1][2]",
            "run 60\nprint \"HELD $(f_t:%.17g) $(c_p[1]:%.17g) 1e-12\"\nprint \"HELD $(c_s[2]:%.17g) $(c_s[1]:%.17g) 1e-12\"\nprint \"HELD $(f_c[1][3]:%.17g) $(c_s[1]:%.17g) 1e-5\"\nprint \"HELD $(f_h[1][2]) 27 0\""),
        // one grain: as a point it has no moments and no spin
        held("`compute gyration`, `compute inertia/chunk`, `compute angmom/chunk`, `compute torque/chunk`", "group a id 1\nset atom 1 angmom 1e-3 0 0\ncompute g a gyration\ncompute k a chunk/atom type\ncompute i a inertia/chunk k\ncompute l a angmom/chunk k\ncompute t a torque/chunk k",
            "thermo_style custom step c_g c_i[1][1] c_l[1][1] c_t[1][1]\nrun 60\nprint \"HELD $(c_g<1e-8) 1 0\"\nprint \"HELD $(abs(c_i[1][1])<1e-12) 1 0\"\nprint \"HELD $(abs(c_l[1][1])<1e-12) 1 0\"\nprint \"HELD $(abs(c_t[1][1])<1e-12) 1 0\""),
        Case { expected: Expected::NumbersWithPackage("GRAPHICS"), ..held("`dump image`, `dump movie`", "dump i all image 60 shot.*.ppm type type",
            "run 60\nprint \"HELD $(is_file(shot.60.ppm)) 1 0\"") },
        Case { boundary: "p p f", ..refused("`fix pour`, `fix deposit`", "region top block 0 0.05 0 0.05 0.04 0.06\nfix p all deposit 1 1 10 123 region top", &["deposit", "no shape"]) },
        refused("`compute temp/sphere`, `compute erotate/sphere`", "compute t all erotate/sphere", &["erotate/sphere", "omega"]),
        refused("`compute centroid/stress/atom`", "compute c all centroid/stress/atom NULL", &["does not support compute centroid/stress/atom"]),
        refused("`compute group/group`", "group a id 1:9\ncompute g a group/group all", &["group/group", "line of centres", "pair/local"]),
        refused("`compute temp/sphere`, `compute erotate/sphere`", "compute t all temp/sphere", &["temp/sphere", "omega"]),
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
        superellipsoid(refused("`compute contact/atom`, `compute fabric`, `compute rattlers/atom`", "compute c all contact/atom", &["contact/atom", "enclosing spheres", "contact/ellipsoid/atom"])),
        superellipsoid(refused("`compute contact/atom`, `compute fabric`, `compute rattlers/atom`", "compute c all fabric radius contact", &["fabric", "contact/ellipsoid/atom"])),
        superellipsoid(refused("`fix viscous/nonlinear`", "fix g all viscous/nonlinear 1.2 1.8e-5", &["viscous/nonlinear", "enclosing spheres"])),
        superellipsoid(refused("`fix damping/cundall`", "fix d all damping/cundall 0.5 0.5", &["damping/cundall", "omega"])),
        superellipsoid(refused("`fix adapt ... diameter`", "variable d equal 0.01\nfix a all adapt 1 atom diameter v_d", &["adapt", "shape"])),
        superellipsoid(Case { boundary: "p p f", ..refused("`fix pour`, `fix deposit`", "region top block 0 0.05 0 0.05 0.04 0.06\nfix p all pour 1 1 123 region top diam one 0.01", &["pour", "no shape"]) }),
        superellipsoid(Case { boundary: "p p f", ..refused("`fix wall/gran`, `fix wall/gran/region`", "fix w all wall/gran hertz/history 1e6 NULL 50 NULL 0.5 1 zplane 0 NULL", &["wall/gran", "omega"]) }),
        // By the package that they are in, or by LAMMPS without it.
        superellipsoid(refused("`fix surface/global`, `fix surface/local`", "fix w all surface/global input stl 1 wall.stl model 1 1 hooke 1 0 tangential linear_nohistory 0 0", &["surface/global"])),
        superellipsoid(refused("`fix surface/global`, `fix surface/local`", "fix w all surface/local input stl 1 wall.stl", &["surface/local"])),
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
