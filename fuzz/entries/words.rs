// SPDX-License-Identifier: MIT OR Apache-2.0
//! `ellgran_law_parameters_parse`, `ellgran_wall_material_parse` and `ellgran_laws_describe`: any text as the words of a deck. What is
//! read can be made into laws, whose numbers are finite.

use std::ffi::{c_char, CStr, CString};
use std::ptr;

use ellgran::c_api::law::*;

use super::scene::*;

pub fn run(bytes: &[u8]) {
    let words: Vec<CString> = bytes
        .split(|byte| byte.is_ascii_whitespace() || *byte == 0)
        .filter(|word| !word.is_empty())
        .map(|word| CString::new(word).expect("no NUL"))
        .collect();
    let pointers: Vec<*const c_char> = words.iter().map(|word| word.as_ptr()).collect();
    let mut parameters = sized::<EllgranLawParameters>();
    let mut consumed = 0;
    // SAFETY: the strings live to the end of the function; the outputs are valid for writes.
    let status = unsafe {
        ellgran_law_parameters_parse(
            pointers.len(),
            pointers.as_ptr(),
            &mut consumed,
            &mut parameters,
        )
    };
    if !succeeded(status) {
        return;
    }
    assert!((1..=pointers.len()).contains(&consumed));
    let rest = &pointers[consumed..];
    let mut wall = sized::<EllgranLawParameters>();
    let mut of_wall = 0;
    // SAFETY: as above.
    let status = unsafe {
        ellgran_wall_material_parse(
            &parameters,
            rest.len(),
            rest.as_ptr(),
            &mut of_wall,
            &mut wall,
        )
    };
    if !succeeded(status) {
        return;
    }
    assert!(of_wall <= rest.len());
    laws(&[parameters, parameters, parameters, wall]);
}

/// Laws of two types, which are mixed. A law alone is sound, but its mixture may not be, as of the softest and the stiffest body.
fn laws(parameters: &[EllgranLawParameters; 4]) {
    let mut pointer = ptr::null_mut();
    // SAFETY: the arrays have an entry for each pair of types.
    let status = unsafe {
        ellgran_laws_new(
            2,
            parameters.as_ptr(),
            [1, 0, 0, 1].as_ptr(),
            0,
            &mut pointer,
        )
    };
    if !succeeded(status) {
        return;
    }
    for (i, j) in [(1, 1), (1, 2), (2, 2)] {
        let mut mixture = sized::<EllgranMixture>();
        // SAFETY: valid pointers.
        assert!(succeeded(unsafe {
            ellgran_laws_mixture(pointer, i, j, &mut mixture)
        }));
        assert_finite(
            "mixture",
            &[
                mixture.effective_modulus,
                mixture.effective_shear_modulus,
                mixture.normal_relaxation_time,
                mixture.tangential_relaxation_time,
                mixture.share_i,
            ],
        );
        let mut text = [1 as c_char; 40];
        // SAFETY: the buffer is as long as stated.
        assert!(succeeded(unsafe {
            ellgran_laws_describe(pointer, i, j, text.as_mut_ptr(), text.len())
        }));
        // SAFETY: a call that succeeded has ended it with NUL.
        let text = unsafe { CStr::from_ptr(text.as_ptr()) };
        assert!(!text.to_str().expect("UTF-8").is_empty());
    }
    // SAFETY: made above and not used again.
    unsafe { ellgran_laws_free(pointer) }
}
