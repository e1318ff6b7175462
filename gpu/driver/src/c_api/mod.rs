// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything `extern "C"`: pointers, status codes, panics. The rules of this border are those of `ellgran::c_api`.

#![allow(unsafe_code)]

pub mod gpu;
pub mod scene;
pub mod step;

use crate::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuLoads,
    EllgranGpuMotion, EllgranGpuTallies,
};
use ellgran::c_api::growing::Growing;
use ellgran::c_api::status::{Failure, ELLGRAN_ERROR_NULL_POINTER};

fn required_array(is_null: bool, length: usize, name: &str) -> Result<(), Failure> {
    if is_null && length > 0 {
        return Err(Failure::new(
            ELLGRAN_ERROR_NULL_POINTER,
            format!("{name} must not be NULL"),
        ));
    }
    Ok(())
}

/// An array of the host, which may be NULL only where it has no elements.
///
/// # Safety
/// `pointer` is NULL or valid for reads of `length` elements for the lifetime that the caller gives it.
unsafe fn slice<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Failure> {
    required_array(pointer.is_null(), length, name)?;
    if length == 0 {
        return Ok(&[]);
    }
    // SAFETY: promised by the caller.
    Ok(unsafe { core::slice::from_raw_parts(pointer, length) })
}

/// The same, to be written.
///
/// # Safety
/// `pointer` is NULL or valid for reads and writes of `length` elements, and not aliased, for the lifetime that the caller gives it.
unsafe fn slice_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    name: &str,
) -> Result<&'a mut [T], Failure> {
    required_array(pointer.is_null(), length, name)?;
    if length == 0 {
        return Ok(&mut []);
    }
    // SAFETY: promised by the caller.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, length) })
}

macro_rules! growing {
    ($($name:ident)*) => {$(
        const _: () = assert!(core::mem::offset_of!($name, size) == 0);
        // SAFETY: `repr(C)`; `size` is the first field; all fields are numbers and pointers of eight bytes, so there is no padding.
        unsafe impl Growing for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = size_of::<$name>();
        }
    )*};
}

growing!(EllgranGpuGrains EllgranGpuList EllgranGpuLoads EllgranGpuMotion EllgranGpuHistories EllgranGpuCounts EllgranGpuTallies);
