// SPDX-License-Identifier: MIT OR Apache-2.0
//! A GPU, opened and closed.

use crate::device::Device;
use ellgran::c_api::status::{at_border, required_mut};
use std::sync::Arc;

/// A GPU with the kernels on it. Opaque. Threads may share it.
pub struct EllgranGpu {
    pub(super) device: Arc<Device>,
}

/// Opens the GPU number `ordinal`, counted from 0 as CUDA does, in the context that all libraries share (the primary one): memory that
/// the CUDA runtime has allocated on it can be given to the functions below.
///
/// NVIDIA's driver is loaded by this call, and is asked to assemble the kernels, for which it may need some time; it keeps on disk what
/// it has assembled. The environment variable `ELLGRAN_GPU_DRIVER` names another file than `libcuda.so.1`.
///
/// # Safety
/// `gpu` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_open(ordinal: i32, gpu: *mut *mut EllgranGpu) -> i32 {
    at_border("ellgran_gpu_open", || {
        // SAFETY: `gpu` is NULL or valid for writes, by this function's safety section.
        let out = unsafe { required_mut(gpu, "gpu") }?;
        let device = Device::open(ordinal)?;
        *out = Box::into_raw(Box::new(EllgranGpu { device }));
        Ok(())
    })
}

/// The same for the GPU and the context that this thread has, as an engine has chosen them. The context must be there until the GPU and
/// all its scenes are freed.
///
/// # Safety
/// `gpu` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_open_current(gpu: *mut *mut EllgranGpu) -> i32 {
    at_border("ellgran_gpu_open_current", || {
        // SAFETY: `gpu` is NULL or valid for writes, by this function's safety section.
        let out = unsafe { required_mut(gpu, "gpu") }?;
        let device = Device::of_this_thread()?;
        *out = Box::into_raw(Box::new(EllgranGpu { device }));
        Ok(())
    })
}

/// Closes a GPU; NULL is allowed. Its scenes can still be used, and keep it open.
///
/// # Safety
/// `gpu` is NULL or came from one of the functions above and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_gpu_free(gpu: *mut EllgranGpu) {
    if !gpu.is_null() {
        // SAFETY: made by `Box::into_raw`, and not freed before, by this function's safety section.
        drop(unsafe { Box::from_raw(gpu) });
    }
}
