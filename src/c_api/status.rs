// SPDX-License-Identifier: MIT OR Apache-2.0
//! Status codes, the message of the last failure, and the border itself.

use core::cell::UnsafeCell;
use core::ffi::c_char;
use std::panic::{catch_unwind, AssertUnwindSafe};

/// The call succeeded.
pub const ELLGRAN_SUCCESS: i32 = 0;
/// Block 1 to 99, arguments: a pointer that must not be NULL is NULL.
pub const ELLGRAN_ERROR_NULL_POINTER: i32 = 1;
/// An argument is out of its range.
pub const ELLGRAN_ERROR_ARGUMENT: i32 = 2;
/// A text is not UTF-8.
pub const ELLGRAN_ERROR_TEXT: i32 = 3;
/// Block 100 to 199, laws: invalid words or constants of a law.
pub const ELLGRAN_ERROR_LAW: i32 = 100;
/// Hale's form of the Hertz factors is not defined at a contact with B/A above 25178: use `factors exact`.
pub const ELLGRAN_ERROR_HALE: i32 = 101;
/// Block 200 to 299, bodies: invalid particle input; the message names the particle and the value.
pub const ELLGRAN_ERROR_PARTICLE: i32 = 200;
/// Invalid history: that of a touching contact holds a number that no call writes, for example NaN. A normal that is not a
/// unit vector is no error: the search then begins anew.
pub const ELLGRAN_ERROR_HISTORY: i32 = 201;
/// The result is out of the range of double precision, although each input is within its own range.
pub const ELLGRAN_ERROR_RESULT: i32 = 202;
// Block 300 to 399, GPUs: gpu/driver/src/status.rs.
/// Block 900 to 999, the library itself: an internal error (a caught panic). Please report it.
pub const ELLGRAN_ERROR_PANIC: i32 = 900;

/// A failure on its way to the border. Public for that of `gpu/driver`, as the functions below; no interface for others.
#[doc(hidden)]
#[derive(Debug)]
pub struct Failure {
    /// One of the codes above, or of a GPU's.
    pub status: i32,
    /// What `ellgran_last_error` gives.
    pub message: String,
}

impl Failure {
    /// With its message.
    pub fn new(status: i32, message: impl Into<String>) -> Self {
        Failure {
            status,
            message: message.into(),
        }
    }
}

const CAPACITY: usize = 1024;

// A fixed array without destructor: a plugin may be unloaded while threads live on.
thread_local! {
    static LAST_ERROR: UnsafeCell<[u8; CAPACITY]> = const { UnsafeCell::new([0; CAPACITY]) };
}

fn store(message: &str) {
    // Cut at a character, so that the text stays UTF-8.
    let mut end = message.len().min(CAPACITY - 1);
    while !message.is_char_boundary(end) {
        end -= 1;
    }
    LAST_ERROR.with(|cell| {
        // SAFETY: the cell belongs to this thread and no reference to its content outlives this closure; callers of
        // `ellgran_last_error` read it between calls.
        let buffer = unsafe { &mut *cell.get() };
        buffer[..end].copy_from_slice(&message.as_bytes()[..end]);
        buffer[end] = 0;
    });
}

/// The message of the last failure in this thread, UTF-8, never NULL; empty if there was none. It is overwritten by the
/// next failing call of this thread.
#[no_mangle]
pub extern "C" fn ellgran_last_error() -> *const c_char {
    LAST_ERROR.with(|cell| cell.get().cast::<c_char>().cast_const())
}

/// Runs the body of a call: failures and panics become a status and a message.
#[doc(hidden)]
pub fn at_border(name: &str, body: impl FnOnce() -> Result<(), Failure>) -> i32 {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => ELLGRAN_SUCCESS,
        Ok(Err(failure)) => {
            store(&failure.message);
            failure.status
        }
        Err(payload) => {
            let text = payload
                .downcast_ref::<&str>()
                .map(|s| (*s).to_owned())
                .or_else(|| payload.downcast_ref::<String>().cloned())
                .unwrap_or_default();
            store(&format!("{name}: internal error: {text}"));
            ELLGRAN_ERROR_PANIC
        }
    }
}

/// A reference from a pointer that must not be NULL.
///
/// # Safety
/// `pointer` is NULL or valid for reads for the lifetime that the caller gives it.
#[doc(hidden)]
pub unsafe fn required<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    // SAFETY: promised by the caller.
    unsafe { pointer.as_ref() }.ok_or_else(|| null(name))
}

/// A mutable reference from a pointer that must not be NULL.
///
/// # Safety
/// `pointer` is NULL or valid for reads and writes, and not aliased, for the lifetime that the caller gives it.
#[doc(hidden)]
pub unsafe fn required_mut<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Failure> {
    // SAFETY: promised by the caller.
    unsafe { pointer.as_mut() }.ok_or_else(|| null(name))
}

/// A slice from a pointer that may be NULL only for length zero.
///
/// # Safety
/// `pointer` is NULL or valid for reads of `length` elements for the lifetime that the caller gives it.
pub(super) unsafe fn slice<'a, T>(
    pointer: *const T,
    length: usize,
    name: &str,
) -> Result<&'a [T], Failure> {
    if length == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: promised by the caller.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// A mutable slice from a pointer that may be NULL only for length zero.
///
/// # Safety
/// `pointer` is NULL or valid for reads and writes of `length` elements, and not aliased, for the lifetime that the
/// caller gives it.
pub(super) unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    name: &str,
) -> Result<&'a mut [T], Failure> {
    if length == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: promised by the caller.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, length) })
}

fn null(name: &str) -> Failure {
    Failure::new(
        ELLGRAN_ERROR_NULL_POINTER,
        format!("{name} must not be NULL"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    #[test]
    fn a_panic_becomes_a_status() {
        let status = at_border("ellgran_some_call", || panic!("row {}", 7));
        assert_eq!(status, ELLGRAN_ERROR_PANIC);
        // SAFETY: never NULL, and ends with NUL.
        let message = unsafe { CStr::from_ptr(ellgran_last_error()) };
        let message = message.to_str().unwrap();
        assert_eq!(message, "ellgran_some_call: internal error: row 7");
    }
}
