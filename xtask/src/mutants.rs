// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the tests notice a changed formula? cargo-mutants says which mutants of the contact law and of the geometry there are. All
//! of them are compiled into one copy of the library, without lanes, and turned on one at a time; each is held against the
//! tests that see another value there. A run can be stopped and gone on with; what came out is stored.

mod copy;
mod examples;
mod list;
mod schemata;
mod stored;
mod trial;
mod watched;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{bail, Context, Result};

use crate::progress::{human_time, say, Progress};
use crate::workspace::target_directory;
use copy::{Copy, Switch};
use list::{mutants_of, Genre, Mutant};
use stored::{Outcome, Stored};
use trial::{mutated, Test, Verdict};
use watched::{names_kept, watch, Watched};

/// What is mutated.
const FILES: [&str; 2] = ["src/force/**", "src/geometry/**"];

/// Of the tests in one process.
const GROUP_SECONDS: f64 = 0.2;

/// How often outcomes are written.
const WRITTEN_EVERY: Duration = Duration::from_secs(30);

#[derive(clap::Args)]
pub struct Options {
    /// How long; then the run stops, to be gone on with
    #[arg(long, default_value_t = 60.0)]
    minutes: f64,
    /// Files to mutate [default: src/force/** and src/geometry/**]
    #[arg(long)]
    file: Vec<String>,
    /// Only those that survived, since tests have been added
    #[arg(long)]
    missed: bool,
    /// Mutants that are tried at once [default: one for each processor]
    #[arg(long)]
    jobs: Option<usize>,
    /// Tests that take longer, in seconds, are left out where a shorter one sees the mutant
    #[arg(long, default_value_t = 0.5)]
    longest_test: f64,
    /// Only tests with this in their name; may be given several times
    #[arg(long)]
    test: Vec<String>,
    /// Those that cannot be switched too, each compiled on its own
    #[arg(long)]
    one_by_one: bool,
    /// Those that survived, held against the tests that need lanes
    #[arg(long)]
    lanes: bool,
}

pub fn mutants(options: &Options) -> Result<()> {
    let started = Instant::now();
    let end = started + Duration::from_secs_f64(60.0 * options.minutes);
    let program = list::program()?;
    let all = mutants_of(&program, &FILES.map(str::to_string))?;
    let names: BTreeSet<&str> = all.iter().map(|m| m.name.as_str()).collect();
    let wanted: BTreeSet<String> = if options.file.is_empty() {
        names.iter().map(|name| name.to_string()).collect()
    } else {
        let of_files = mutants_of(&program, &options.file)?;
        of_files.into_iter().map(|m| m.name).collect()
    };
    let mut stored = Stored::read(&names);
    let survived = |m: &Mutant| stored.of(&m.name).is_some_and(Outcome::survived);
    // All are compiled, whichever are to be tried: the same programs as last time need not be compiled and watched again. Lanes are slow to
    // compile.
    let mut compiled = all.clone();
    if options.lanes {
        compiled.retain(|m| wanted.contains(&m.name) && survived(m));
    }
    let to_be_tried = |m: &Mutant| {
        if options.missed || options.lanes {
            survived(m)
        } else {
            stored.of(&m.name).is_none()
        }
    };
    let left: BTreeSet<usize> = (0..compiled.len())
        .filter(|k| wanted.contains(&compiled[*k].name) && to_be_tried(&compiled[*k]))
        .collect();
    say(format!(
        "{} mutants, {} of them to be tried",
        wanted.len(),
        left.len()
    ));
    if !left.is_empty() {
        try_all(&compiled, &left, options, end, &mut stored)?;
        stored.write()?;
    }
    println!("{}", stored.table(&names).markdown());
    say(format!(
        "the lists are in validation/mutants; done in {}",
        human_time(started.elapsed())
    ));
    Ok(())
}

fn try_all(
    mutants: &[Mutant],
    left: &BTreeSet<usize>,
    options: &Options,
    end: Instant,
    stored: &mut Stored,
) -> Result<()> {
    let without_lanes = target_directory()?.join("mutants");
    let place = if options.lanes {
        without_lanes.join("lanes")
    } else {
        without_lanes.clone()
    };
    fs::create_dir_all(&place)?;
    let (sources, build) = (place.join("sources"), without_lanes.join("build"));
    let mut copy = Copy::make(sources, build, mutants, options.lanes)?;
    let compiling = Progress::start("compiling all mutants into one library");
    copy.switch(mutants)?;
    say(format!(
        "{} can be switched, {} cannot be compiled, {} can only be compiled one by one",
        copy.switches.len(),
        copy.unviable.len(),
        copy.fixed.len()
    ));
    for &index in &copy.unviable {
        stored.set(&mutants[index].name, Outcome::Unviable);
    }
    stored.write()?;
    let programs = copy.tests()?.context("the tests cannot be compiled")?;
    compiling.finish();
    let mut tests = watch(&programs, &place, &options.test)?;
    if options.lanes {
        // The others have been tried.
        for program in &programs {
            let tried = names_kept(&without_lanes, &program.name);
            tests.retain(|t| t.of != program.name || !tried.contains(&t.test.name));
        }
    }
    tests.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let progress = Progress::start("mutants");
    let longest = options.longest_test;
    let switches = copy.switches.iter().filter(|(k, _)| left.contains(k));
    let trials = Mutex::new(Trials {
        stored,
        progress,
        written: Instant::now(),
    });
    let next = Mutex::new(switches);
    let killers = Mutex::new(Killers::default());
    let processors = thread::available_parallelism().map_or(1, |n| n.get());
    let jobs = options.jobs.unwrap_or(processors);
    let said = |job: usize| place.join(format!("said-{job}"));
    let work = |job: usize| -> Result<()> {
        while Instant::now() < end {
            let Some((&index, &switch)) = held(&next).next() else {
                break;
            };
            let mutant = &mutants[index];
            let outcome = judge(mutant, switch, &tests, longest, &killers, &said(job))?;
            held(&trials).add(mutant, outcome, (index, mutants.len()))?;
        }
        Ok(())
    };
    let work = &work;
    thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs)
            .map(|job| scope.spawn(move || work(job)))
            .collect();
        let done = workers.into_iter().map(|worker| {
            let done = worker.join();
            done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        // All of them are waited for.
        done.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
    })?;
    let Trials {
        stored, progress, ..
    } = trials.into_inner().unwrap_or_else(|e| e.into_inner());
    let said = said(0);
    progress.finish();
    if options.one_by_one {
        let fixed = &copy.fixed & left;
        one_by_one(
            mutants,
            &fixed,
            &copy,
            (&tests, options.longest_test),
            end,
            stored,
            &said,
        )?;
    }
    Ok(())
}

/// What came out so far.
struct Trials<'a> {
    stored: &'a mut Stored,
    progress: Progress,
    written: Instant,
}

impl Trials<'_> {
    fn add(&mut self, mutant: &Mutant, outcome: Outcome, (k, of): (usize, usize)) -> Result<()> {
        self.stored.set_unless_less(&mutant.name, outcome);
        let what = format!("{k} of {of}, {}", mutant.name);
        self.progress.update(Some(k as f64 / of as f64), &what);
        if self.written.elapsed() > WRITTEN_EVERY {
            self.stored.write()?;
            self.written = Instant::now();
        }
        Ok(())
    }
}

fn held<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(|e| e.into_inner())
}

/// How many mutants of a file each test has killed: what has killed its neighbours is likely to kill the next.
#[derive(Default)]
struct Killers(BTreeMap<(String, usize), usize>);

impl Killers {
    /// In the order of time per chance.
    fn order(&self, file: &str, tests: &[Watched], mut chosen: Vec<usize>) -> Vec<usize> {
        let cost = |k: &usize| {
            let kills = self.0.get(&(file.to_string(), *k)).copied().unwrap_or(0);
            // A process takes some milliseconds, whatever it runs.
            (0.003 + tests[*k].seconds) / (1.0 + kills as f64)
        };
        chosen.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        chosen
    }

    fn add(&mut self, file: &str, test: usize) {
        *self.0.entry((file.to_string(), test)).or_default() += 1;
    }
}

/// Runs the tests that see the mutant, until one fails.
fn judge(
    mutant: &Mutant,
    switch: Switch,
    tests: &[Watched],
    longest_test: f64,
    killers: &Mutex<Killers>,
    said: &Path,
) -> Result<Outcome> {
    if !tests.iter().any(|test| test.reaches(switch)) {
        return Ok(Outcome::Unreached);
    }
    let compared = is_compared(mutant);
    let mut seeing: Vec<usize> = (0..tests.len())
        .filter(|k| tests[*k].sees(switch, compared))
        .collect();
    if seeing.is_empty() {
        return Ok(Outcome::Same);
    }
    // Long tests where there is no shorter one.
    let short = |k: &usize| tests[*k].seconds <= longest_test;
    if seeing.iter().any(short) {
        seeing.retain(short);
    }
    let ordered = held(killers).order(&mutant.file, tests, seeing);
    for group in groups(&ordered, tests) {
        let of_group: Vec<&Test> = group.iter().map(|k| &tests[*k].test).collect();
        let seconds = group.iter().map(|k| tests[*k].seconds).sum();
        let (verdict, failed) = mutated(&of_group, Some(switch), seconds, said)?;
        if verdict != Verdict::Passed {
            let named = |k: &&usize| Some(&tests[**k].test.name) == failed.as_ref();
            if let Some(killer) = group.iter().find(named) {
                held(killers).add(&mutant.file, *killer);
            }
            return Ok(outcome_of(verdict));
        }
    }
    Ok(Outcome::Missed)
}

/// The likeliest tests alone, the others in processes of so many seconds: to start one costs more than most tests.
fn groups(ordered: &[usize], tests: &[Watched]) -> Vec<Vec<usize>> {
    let (alone, others) = ordered.split_at(ordered.len().min(3));
    let mut groups: Vec<Vec<usize>> = alone.iter().map(|k| vec![*k]).collect();
    let mut open = BTreeMap::<&Path, (Vec<usize>, f64)>::new();
    for &k in others {
        let (group, seconds) = open.entry(&tests[k].test.program).or_default();
        group.push(k);
        *seconds += tests[k].seconds;
        if *seconds > GROUP_SECONDS {
            groups.push(std::mem::take(group));
            *seconds = 0.0;
        }
    }
    let rest = open.into_values().map(|(group, _)| group);
    groups.extend(rest.filter(|group| !group.is_empty()));
    groups
}

fn outcome_of(verdict: Verdict) -> Outcome {
    match verdict {
        Verdict::Passed => Outcome::Missed,
        Verdict::Failed => Outcome::Caught,
        Verdict::NeverEnds => Outcome::NeverEnds,
    }
}

/// Whether the copy looks at the value of a mutant beside that of the original: of operators whose operands it can use twice.
fn is_compared(mutant: &Mutant) -> bool {
    let assigns = mutant.replacement.ends_with('=')
        && !matches!(mutant.replacement.as_str(), "==" | "!=" | "<=" | ">=");
    let lazy = matches!(mutant.replacement.as_str(), "&&" | "||");
    mutant.genre == Genre::BinaryOperator && !assigns && !lazy
}

/// Those that are constants and the like: each takes a compilation, and all tests, since nobody knows which see it.
fn one_by_one(
    mutants: &[Mutant],
    fixed: &BTreeSet<usize>,
    copy: &Copy,
    (tests, longest_test): (&[Watched], f64),
    end: Instant,
    stored: &mut Stored,
    said: &Path,
) -> Result<()> {
    for file in mutants.iter().map(|m| &m.file).collect::<BTreeSet<_>>() {
        copy.write_original(file)?;
    }
    let mut progress = Progress::start("mutants one by one");
    for (done, &index) in fixed.iter().enumerate() {
        if Instant::now() > end {
            break;
        }
        let mutant = &mutants[index];
        progress.update(
            Some(done as f64 / fixed.len() as f64),
            &format!("{done} of {}, {}", fixed.len(), mutant.name),
        );
        copy.write_alone(mutant)?;
        let programs = copy.tests()?;
        copy.write_original(&mutant.file)?;
        let outcome = match programs {
            None => Outcome::Unviable,
            Some(programs) => {
                let mut outcome = Outcome::Missed;
                for test in tests.iter().filter(|t| t.seconds <= longest_test) {
                    // The name of a program follows from the flags, not from the text: it is the same file.
                    if programs.iter().all(|p| p.path != test.test.program) {
                        bail!("cargo has made another program");
                    }
                    let (verdict, _) = mutated(&[&test.test], None, test.seconds, said)?;
                    outcome = outcome_of(verdict);
                    if outcome != Outcome::Missed {
                        break;
                    }
                }
                outcome
            }
        };
        stored.set(&mutant.name, outcome);
        stored.write()?;
    }
    progress.finish();
    Ok(())
}
