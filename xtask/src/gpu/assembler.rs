// SPDX-License-Identifier: MIT OR Apache-2.0
//! NVIDIA's assembler on the PTX: what each kernel needs on each generation of GPUs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::progress::say;
use crate::python_environment::Environment;
use crate::workspace::root;

/// Generations that must take it: Volta, Turing, Ampere, Ada, Hopper, Blackwell.
pub const GENERATIONS: [u32; 8] = [70, 75, 80, 86, 89, 90, 100, 120];
/// The one whose figures are shown.
pub const SHOWN: u32 = 90;

/// What a kernel needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kernel {
    /// Registers of 32 bits a thread.
    pub registers: u32,
    /// Bytes of memory a thread that its calls and arrays take.
    pub stack: u32,
    /// Bytes of registers that do not fit, written once.
    pub spilled: u32,
    /// Instructions of 16 bytes.
    pub instructions: u64,
    /// Instructions of PTX on `f64`, conversions, divisions and roots among them.
    pub arithmetic: usize,
    /// Divisions and roots that are rounded right, of many instructions each.
    pub divisions: usize,
}

/// Kernels by name, for the generation that is shown; and the most that any kernel spills, by generation.
pub struct Figures {
    pub version: String,
    pub kernels: BTreeMap<String, Kernel>,
    pub most_spilled: Vec<(u32, u32)>,
}

/// Of several modules.
pub fn figures(modules: &[String]) -> Result<Figures> {
    let environment = Environment::pinned(&root().join("gpu/ptx/requirements.txt"))?;
    let script = "import nvidia.cuda_nvcc as m; print(list(m.__path__)[0])";
    let place = crate::process::output_of(environment.python().args(["-c", script]))?;
    let program = Path::new(place.trim()).join("bin/ptxas");
    let mut figures = Figures {
        version: version(&program)?,
        kernels: BTreeMap::new(),
        most_spilled: Vec::new(),
    };
    for generation in GENERATIONS {
        let assembled = std::thread::scope(|scope| {
            let all: Vec<_> = modules
                .iter()
                .map(|module| scope.spawn(|| assemble(&program, module, generation)))
                .collect();
            all.into_iter()
                .map(|one| one.join().expect("the thread ends with a result"))
                .collect::<Result<Vec<_>>>()
        })?;
        let kernels: BTreeMap<String, Kernel> = assembled.into_iter().flatten().collect();
        let contacts = kernels
            .iter()
            .filter(|(name, _)| name.starts_with("ellgran_contacts"));
        let spilled = contacts.map(|(_, k)| k.spilled).max().unwrap_or(0);
        figures.most_spilled.push((generation, spilled));
        if generation == SHOWN {
            figures.kernels = kernels;
        }
        say(format!(
            "sm_{generation}: taken, at most {spilled} bytes spilled in a contact"
        ));
    }
    Ok(figures)
}

/// The kernels of a module on a generation.
fn assemble(program: &Path, ptx: &str, generation: u32) -> Result<BTreeMap<String, Kernel>> {
    let directory = tempfile::tempdir()?;
    let (source, binary) = (
        directory.path().join("kernels.ptx"),
        directory.path().join("kernels.cubin"),
    );
    fs::write(&source, ptx)?;
    let began = std::time::Instant::now();
    let output = Command::new(program)
        .arg("-v")
        .arg(format!("-arch=sm_{generation}"))
        .arg(&source)
        .arg("-o")
        .arg(&binary)
        .output()
        .with_context(|| format!("cannot run {}", program.display()))?;
    let log = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        bail!("the assembler refuses the PTX for sm_{generation}\n{log}");
    }
    let mut kernels = read_log(&log);
    if kernels.is_empty() {
        bail!("the assembler says nothing of any kernel for sm_{generation}\n{log}");
    }
    if generation == SHOWN {
        // Beside the other modules, on as many cores as there are.
        let names: Vec<&str> = kernels.keys().map(String::as_str).take(2).collect();
        let (names, seconds) = (names.join(", "), began.elapsed().as_secs_f64());
        say(format!(
            "sm_{generation}: the module of {names} in {seconds:.0} s"
        ));
    }
    for (name, bytes) in code_sizes(&fs::read(&binary)?)? {
        if let Some(kernel) = kernels.get_mut(&name) {
            kernel.instructions = bytes / 16;
        }
    }
    for (name, kernel) in &mut kernels {
        (kernel.arithmetic, kernel.divisions) = arithmetic(ptx, name);
    }
    Ok(kernels)
}

fn version(program: &Path) -> Result<String> {
    let text = crate::process::output_of(Command::new(program).arg("--version"))?;
    text.lines()
        .find_map(|line| line.split_once("release "))
        .and_then(|(_, rest)| rest.split(',').next())
        .map(str::to_owned)
        .context("ptxas names no release")
}

/// What `ptxas -v` says of each entry.
fn read_log(log: &str) -> BTreeMap<String, Kernel> {
    let mut kernels = BTreeMap::new();
    let mut name: Option<String> = None;
    let number = |line: &str, after: &str| -> Option<u32> {
        let (left, _) = line.split_once(after)?;
        left.rsplit(|c: char| !c.is_ascii_digit())
            .next()?
            .parse()
            .ok()
    };
    for line in log.lines() {
        if let Some((_, rest)) = line.split_once("Compiling entry function '") {
            name = rest.split('\'').next().map(str::to_owned);
        } else if line.contains("Function properties for") {
            // Those of the entry come first; functions that it calls follow its registers.
            let of = line.rsplit(' ').next().map(str::to_owned);
            if of != name {
                continue;
            }
        } else if let Some(name) = &name {
            let kernel: &mut Kernel = kernels.entry(name.clone()).or_default();
            if let (Some(spilled), 0) = (number(line, " bytes spill stores"), kernel.registers) {
                kernel.spilled = spilled;
            }
            if let Some(registers) = number(line, " registers") {
                kernel.registers = registers;
                kernel.stack = number(line, " bytes cumulative stack size").unwrap_or(0);
            }
        }
    }
    kernels
}

/// Bytes of the code of each kernel of an ELF file.
fn code_sizes(file: &[u8]) -> Result<Vec<(String, u64)>> {
    let number = |at: usize, bytes: usize| -> Option<u64> {
        let mut all = [0; 8];
        all[..bytes].copy_from_slice(file.get(at..at + bytes)?);
        Some(u64::from_le_bytes(all))
    };
    let read = || -> Option<Vec<(String, u64)>> {
        let headers = number(0x28, 8)? as usize;
        let (size, count) = (number(0x3a, 2)? as usize, number(0x3c, 2)? as usize);
        let section = |k: usize| headers + k * size;
        let names = number(section(number(0x3e, 2)? as usize) + 0x18, 8)? as usize;
        let mut found = Vec::new();
        for k in 0..count {
            let start = names + number(section(k), 4)? as usize;
            let end = start + file.get(start..)?.iter().position(|&b| b == 0)?;
            let name = String::from_utf8_lossy(file.get(start..end)?);
            if let Some(kernel) = name.strip_prefix(".text.") {
                found.push((kernel.to_owned(), number(section(k) + 0x20, 8)?));
            }
        }
        Some(found)
    };
    read().context("the assembler's output is no ELF file")
}

/// Instructions on `f64` of the body of an entry, conversions too, and how many of them are divisions and roots that are rounded right.
fn arithmetic(ptx: &str, name: &str) -> (usize, usize) {
    let Some((_, rest)) = ptx.split_once(&format!(".visible .entry {name}(")) else {
        return (0, 0);
    };
    let body = rest.split("\n}").next().unwrap_or(rest);
    let operations = body.lines().filter_map(|line| {
        let operation = line.split_whitespace().next()?;
        let (kind, _) = operation.split_once('.')?;
        let counts = [
            "add", "sub", "mul", "fma", "div", "rcp", "sqrt", "rsqrt", "min", "max", "abs", "neg",
            "setp",
        ];
        let works = operation.ends_with("f64") && counts.contains(&kind);
        // From and to `f64`: at the same rate.
        let converts = kind == "cvt" && operation.contains(".f64");
        (works || converts).then_some(operation)
    });
    let all: Vec<&str> = operations.collect();
    let rounded = ["div.rn.f64", "rcp.rn.f64", "sqrt.rn.f64"];
    let divisions = all.iter().filter(|o| rounded.contains(o)).count();
    (all.len(), divisions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_assemblers_words_are_read() {
        let log = "ptxas info    : Compiling entry function 'a' for 'sm_90'\n\
                   ptxas info    : Function properties for a\n    \
                   48 bytes stack frame, 44 bytes spill stores, 40 bytes spill loads\n\
                   ptxas info    : Used 255 registers, used 0 barriers, 48 bytes cumulative stack size\n\
                   ptxas info    : Function properties for b\n    \
                   0 bytes stack frame, 986 bytes spill stores, 1780 bytes spill loads\n";
        let kernels = read_log(log);
        let wanted = Kernel {
            registers: 255,
            stack: 48,
            spilled: 44,
            ..Kernel::default()
        };
        assert_eq!(kernels["a"], wanted);
    }

    #[test]
    fn arithmetic_of_an_entry_is_counted() {
        let ptx = ".visible .entry a(\n)\n{\n\tfma.rn.f64 \t%fd1, 1, 2, 3;\n\tdiv.rn.f64 \t%fd1;\n\tadd.s64 \t%r;\n\tcvt.rn.f32.f64 \t%f1;\n\tcvt.f64.f32 \t%fd1;\n\tcvt.s64.s32 \t%r;\n\tadd.rn.f32 \t%f1;\n}\n\
                   .visible .entry b(\n)\n{\n\tadd.rn.f64 \t%fd;\n}\n";
        assert_eq!(arithmetic(ptx, "a"), (4, 1));
    }
}
