// SPDX-License-Identifier: MIT OR Apache-2.0
//! The choice of an instruction set by the environment. Each runs in a process of its own: an environment is for all threads.

use std::ffi::CStr;
use std::process::Stdio;
use std::ptr::null;

use ellgran::c_api::particles::*;
use ellgran::c_api::status::*;
use ellgran::simd::InstructionSet;

use crate::emulator;
use crate::scene::*;

const VARIABLE: &str = "ELLGRAN_INSTRUCTION_SET";

/// Runs a test of this program with a choice.
fn run(test: &str, choice: &str) {
    let program = std::env::current_exe().expect("this test");
    let output = emulator::program(&program)
        .args(["--exact", test])
        .env(VARIABLE, choice)
        .stdin(Stdio::null())
        .output()
        .expect("this test again");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && text.contains("1 passed"),
        "{choice}:\n{text}"
    );
}

#[test]
fn the_choice_is_obeyed_or_refused() {
    for choice in ["scalar", "baseline", "avx2", "avx512", "mmx", ""] {
        run("instruction_sets::the_choice_of_this_process", choice);
    }
}

#[test]
fn the_choice_of_this_process() {
    let chosen = std::env::var(VARIABLE).ok();
    let known = |name: &str| InstructionSet::ALL.iter().find(|set| set.name() == name);
    let expected = match &chosen {
        None => InstructionSet::widest(),
        Some(name) if name.is_empty() => InstructionSet::widest(),
        Some(name) => match known(name) {
            Some(set) if set.is_available() => *set,
            _ => {
                let mut out = Untouched::new();
                // SAFETY: valid for writes.
                let status = unsafe { ellgran_workspace_new(out.pointer()) };
                fails(status, ELLGRAN_ERROR_ARGUMENT, &[VARIABLE, name]);
                out.check();
                return;
            }
        },
    };
    let workspace = WorkspaceHandle::new();
    // SAFETY: valid; the name is static and ends with NUL.
    unsafe {
        let name = CStr::from_ptr(ellgran_workspace_instruction_set(workspace.0));
        assert_eq!(name.to_str(), Ok(expected.name()));
        assert!(ellgran_workspace_instruction_set(null()).is_null());
    }
}

#[test]
fn each_gives_the_numbers_of_single_contacts() {
    for set in InstructionSet::ALL {
        if set.is_available() {
            run("paths::a_longer_history", set.name());
            run("shapes::lists_of_each_kind", set.name());
            run("shapes::lists_that_change_kind", set.name());
            run("extreme_values::lists", set.name());
            run(
                "extreme_values::lists_at_the_ends_of_all_ranges",
                set.name(),
            );
            run("list_changes::entries_that_name_no_particle", set.name());
        }
    }
}
