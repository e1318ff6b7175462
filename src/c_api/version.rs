// SPDX-License-Identifier: MIT OR Apache-2.0
//! Versions of the library and of its binary interface.

use libc::c_char;

/// Version of the binary interface: changes whenever a field's place, a signature or the meaning of a value does. Fields that
/// are added at the end of a struct do not change it.
pub const ELLGRAN_ABI_VERSION: u32 = 1;

/// The interface version of the linked library; to be compared with `ELLGRAN_ABI_VERSION` of the header at load.
#[no_mangle]
pub extern "C" fn ellgran_abi_version() -> u32 {
    ELLGRAN_ABI_VERSION
}

/// The library's version as text, such as `0.1.0`; static.
#[no_mangle]
pub extern "C" fn ellgran_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
