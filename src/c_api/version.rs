// SPDX-License-Identifier: MIT OR Apache-2.0
//! Versions of the library and of its binary interface.

use core::ffi::c_char;

/// Version of the binary interface. It is raised when the offset of a field, a signature or the meaning of a value changes.
/// A field that is added at the end of a struct does not raise it.
pub const ELLGRAN_ABI_VERSION: u32 = 1;

/// Version of the binary interface of the linked library. Compare it with `ELLGRAN_ABI_VERSION` of the header when the
/// program starts; if they differ, do not call anything else.
#[no_mangle]
pub extern "C" fn ellgran_abi_version() -> u32 {
    ELLGRAN_ABI_VERSION
}

/// The library's version as text, such as `0.1.0`; static.
#[no_mangle]
pub extern "C" fn ellgran_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
