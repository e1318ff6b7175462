// SPDX-License-Identifier: MIT OR Apache-2.0
//! Modules of kernels: their signatures, read from their text, and what runs in their place.

#![allow(unsafe_code)]

use crate::memory::{HostEntry, IllegalAddress};
use std::collections::BTreeMap;
use std::panic::{catch_unwind, AssertUnwindSafe};

/// Of each kernel, size and alignment of each parameter.
pub type Signatures = BTreeMap<String, Vec<(usize, usize)>>;

/// The generation that a text of PTX is for, and its kernels; `None` where it is no such text.
pub fn read(text: &str) -> Option<(i32, Signatures)> {
    let (_, rest) = text.split_once("\n.target sm_")?;
    let generation = rest.lines().next()?.trim().parse().ok()?;
    let mut signatures = Signatures::new();
    for rest in text.split("\n.visible .entry ").skip(1) {
        let (name, rest) = rest.split_once('(')?;
        let (list, _) = rest.split_once(')')?;
        let parameters: Option<Vec<_>> = list.split(',').map(parameter).collect();
        signatures.insert(name.to_owned(), parameters?);
    }
    Some((generation, signatures))
}

/// `.param .u32 name` or `.param .align 8 .b8 name[120]`.
fn parameter(line: &str) -> Option<(usize, usize)> {
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        [".param", kind, _] => {
            let bits: usize = kind.get(2..)?.parse().ok()?;
            Some((bits / 8, bits / 8))
        }
        [".param", ".align", alignment, ".b8", name] => {
            let (_, size) = name.strip_suffix(']')?.split_once('[')?;
            Some((size.parse().ok()?, alignment.parse().ok()?))
        }
        _ => None,
    }
}

/// A kernel.
pub struct Function {
    name: String,
    entry: &'static HostEntry,
    launches: std::sync::atomic::AtomicUsize,
}

/// Why a kernel cannot be had.
pub enum Lacking {
    /// The module has none of this name.
    Unknown,
    /// Its signature is another one than that of what would run.
    Different(String),
}

impl Function {
    /// A kernel of a module, for good.
    pub fn of(signatures: &Signatures, name: &str) -> Result<&'static Function, Lacking> {
        let of_device = signatures.get(name).ok_or(Lacking::Unknown)?;
        let entry = exported(name).ok_or(Lacking::Unknown)?;
        if of_device[..] != entry.parameters {
            return Err(Lacking::Different(format!(
                "{name}: sizes and alignments {of_device:?} in the text, {:?} here",
                entry.parameters
            )));
        }
        Ok(Box::leak(Box::new(Function {
            name: name.to_owned(),
            entry,
            launches: std::sync::atomic::AtomicUsize::new(0),
        })))
    }

    /// Runs threads; the result of the driver.
    ///
    /// # Safety
    /// The two parameters are as long as the kernel's signature says.
    pub unsafe fn run(&self, threads: usize, count: *const u8, arguments: *const u8) -> u32 {
        let (size, alignment) = self.entry.parameters[1];
        // The driver copies parameters when a kernel is started, wherever they are.
        let mut words = vec![0u64; size.div_ceil(8)];
        assert!(alignment <= 8);
        // SAFETY: promised by the caller.
        let count = unsafe {
            core::ptr::copy_nonoverlapping(arguments, words.as_mut_ptr().cast::<u8>(), size);
            count.cast::<u32>().read_unaligned()
        };
        let turn = self
            .launches
            .fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            for k in 0..threads {
                let index = if turn.is_multiple_of(2) {
                    k
                } else {
                    threads - 1 - k
                };
                // SAFETY: the copy is as long as the kernel takes it to be.
                unsafe { (self.entry.run)(index, count, words.as_ptr().cast()) };
            }
        }));
        match outcome {
            Ok(()) => 0,
            Err(payload) => match payload.downcast_ref::<IllegalAddress>() {
                Some(IllegalAddress(what)) => {
                    eprintln!("stand-in driver: {}: illegal address: {what}", self.name);
                    700
                }
                None => 715,
            },
        }
    }
}

/// What this library exports for a kernel.
#[cfg(unix)]
fn exported(name: &str) -> Option<&'static HostEntry> {
    let spelled = std::ffi::CString::new(format!("ellgran_stand_in_entry_{name}")).ok()?;
    // SAFETY: the library is this one, which is loaded; what it exports under such a name is a `HostEntry` that is there for good.
    unsafe {
        let mut about: libc::Dl_info = core::mem::zeroed();
        let here = read as fn(&str) -> Option<(i32, Signatures)>;
        if libc::dladdr(here as *const libc::c_void, &mut about) == 0 {
            return None;
        }
        let library = libc::dlopen(about.dli_fname, libc::RTLD_LAZY | libc::RTLD_NOLOAD);
        if library.is_null() {
            return None;
        }
        let found = libc::dlsym(library, spelled.as_ptr());
        libc::dlclose(library);
        found.cast::<HostEntry>().as_ref()
    }
}

/// Nothing: how a library finds its own exports is known here for POSIX alone, and the tests that need it are run there.
#[cfg(not(unix))]
fn exported(_: &str) -> Option<&'static HostEntry> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_are_read() {
        let text = "//\n.version 7.0\n.target sm_70\n.address_size 64\n\n.visible .entry a(\n\t.param .u32 a_param_0,\n\t.param .align 8 \
                    .b8 a_param_1[120]\n)   // @a\n{\n}\n.visible .entry b(\n\t.param .f64 b_param_0\n)\n{\n}\n";
        let (generation, signatures) = read(text).unwrap();
        assert_eq!(generation, 70);
        assert_eq!(signatures["a"], [(4, 4), (120, 8)]);
        assert_eq!(signatures["b"], [(8, 8)]);
        assert!(read("no text of PTX").is_none());
    }
}
