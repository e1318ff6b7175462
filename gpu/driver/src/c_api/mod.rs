// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything `extern "C"`: pointers, status codes, panics. The rules of this border are those of `ellgran::c_api`.

#![allow(unsafe_code)]

pub mod gpu;
pub mod scene;
pub mod step;

use crate::arrays::{
    EllgranGpuCounts, EllgranGpuGrains, EllgranGpuHistories, EllgranGpuList, EllgranGpuLoads,
    EllgranGpuMotion,
};
use ellgran::c_api::growing::Growing;

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

growing!(EllgranGpuGrains EllgranGpuList EllgranGpuLoads EllgranGpuMotion EllgranGpuHistories EllgranGpuCounts);
