// SPDX-License-Identifier: MIT OR Apache-2.0
//! The functions of the driver, by their names in cuda.h.

#![allow(unsafe_code)]
#![allow(non_snake_case)]
// They are as cuda.h has them: what callers must see to is there.
#![allow(clippy::missing_safety_doc)]

use crate::memory;
use crate::modules::{self, Function, Lacking, Signatures};
use crate::settings;
use crate::tally::{add, What};
use core::ffi::{c_char, c_int, c_uint, c_void, CStr};
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

const SUCCESS: u32 = 0;
const INVALID_VALUE: u32 = 1;
const OUT_OF_MEMORY: u32 = 2;
const NO_DEVICE: u32 = 100;
const INVALID_DEVICE: u32 = 101;
const INVALID_CONTEXT: u32 = 201;
const NO_BINARY_FOR_GPU: u32 = 209;
const INVALID_PTX: u32 = 218;
const INVALID_HANDLE: u32 = 400;
const NOT_FOUND: u32 = 500;

/// What a kernel ended in: all that follows fails with it.
static ENDED: AtomicU32 = AtomicU32::new(0);
/// How often the primary context is retained.
static RETAINED: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static CONTEXTS: RefCell<Vec<usize>> = const { RefCell::new(Vec::new()) };
}

/// The handle of the primary context of the one device whose contexts can be had.
const PRIMARY: usize = 0x1000;
/// The first handle of a stream.
const STREAMS: usize = 0x2000;
static MADE_STREAMS: AtomicUsize = AtomicUsize::new(0);

/// Runs a call that needs a context and a device that has not lost its memory.
fn in_context(body: impl FnOnce() -> u32) -> u32 {
    let ended = ENDED.load(Ordering::Relaxed);
    if ended != 0 {
        return ended;
    }
    let is_in = CONTEXTS.with(|c| !c.borrow().is_empty());
    if !is_in || RETAINED.load(Ordering::Relaxed) == 0 {
        return INVALID_CONTEXT;
    }
    body()
}

/// The same on a stream, which is the default one or one that was made.
fn on_stream(stream: *mut c_void, body: impl FnOnce() -> u32) -> u32 {
    in_context(|| {
        if stream.is_null() {
            add(What::OnDefaultStream, 1);
        } else if !(STREAMS..STREAMS + MADE_STREAMS.load(Ordering::Relaxed))
            .contains(&stream.addr())
        {
            return INVALID_HANDLE;
        }
        body()
    })
}

/// Writes through a pointer of the caller.
///
/// # Safety
/// The pointer is NULL or valid for writes.
unsafe fn write<T>(to: *mut T, value: T) -> u32 {
    if to.is_null() {
        return INVALID_VALUE;
    }
    // SAFETY: promised by the caller.
    unsafe { to.write(value) };
    SUCCESS
}

#[no_mangle]
pub extern "system" fn cuInit(flags: c_uint) -> u32 {
    match settings::init() {
        0 if flags != 0 => INVALID_VALUE,
        0 if settings::devices() == 0 => NO_DEVICE,
        code => code,
    }
}

#[no_mangle]
pub unsafe extern "system" fn cuDriverGetVersion(version: *mut c_int) -> u32 {
    // SAFETY: promised by the caller.
    unsafe { write(version, settings::version()) }
}

#[no_mangle]
pub unsafe extern "system" fn cuDeviceGetCount(count: *mut c_int) -> u32 {
    // SAFETY: promised by the caller.
    unsafe { write(count, settings::devices()) }
}

#[no_mangle]
pub unsafe extern "system" fn cuDeviceGet(device: *mut c_int, ordinal: c_int) -> u32 {
    if !(0..settings::devices()).contains(&ordinal) {
        return INVALID_DEVICE;
    }
    // SAFETY: promised by the caller.
    unsafe { write(device, ordinal) }
}

#[no_mangle]
pub unsafe extern "system" fn cuDeviceGetName(
    name: *mut c_char,
    length: c_int,
    _device: c_int,
) -> u32 {
    let text = c"Stand-in";
    let bytes = text.to_bytes_with_nul();
    if name.is_null() || (length as usize) < bytes.len() {
        return INVALID_VALUE;
    }
    // SAFETY: so many are there, as the caller promised.
    unsafe { core::ptr::copy_nonoverlapping(bytes.as_ptr(), name.cast(), bytes.len()) };
    SUCCESS
}

#[no_mangle]
pub unsafe extern "system" fn cuDeviceGetAttribute(
    value: *mut c_int,
    attribute: c_int,
    device: c_int,
) -> u32 {
    if !(0..settings::devices()).contains(&device) {
        return INVALID_DEVICE;
    }
    let found = match attribute {
        75 => settings::generation() / 10,
        76 => settings::generation() % 10,
        // It reads no memory of the host.
        88 => 0,
        _ => return INVALID_VALUE,
    };
    // SAFETY: promised by the caller.
    unsafe { write(value, found) }
}

#[no_mangle]
pub unsafe extern "system" fn cuDevicePrimaryCtxRetain(
    context: *mut *mut c_void,
    device: c_int,
) -> u32 {
    if !(0..settings::devices()).contains(&device) {
        return INVALID_DEVICE;
    }
    RETAINED.fetch_add(1, Ordering::Relaxed);
    // SAFETY: promised by the caller.
    unsafe { write(context, core::ptr::without_provenance_mut(PRIMARY)) }
}

#[no_mangle]
pub extern "system" fn cuDevicePrimaryCtxRelease_v2(_device: c_int) -> u32 {
    let fewer = RETAINED.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1));
    if fewer.is_ok() {
        SUCCESS
    } else {
        INVALID_CONTEXT
    }
}

#[no_mangle]
pub unsafe extern "system" fn cuCtxGetCurrent(context: *mut *mut c_void) -> u32 {
    let now = CONTEXTS.with(|c| c.borrow().last().copied().unwrap_or(0));
    // SAFETY: promised by the caller.
    unsafe { write(context, core::ptr::without_provenance_mut(now)) }
}

#[no_mangle]
pub unsafe extern "system" fn cuCtxGetDevice(device: *mut c_int) -> u32 {
    // SAFETY: promised by the caller.
    in_context(|| unsafe { write(device, 0) })
}

#[no_mangle]
pub extern "system" fn cuCtxPushCurrent_v2(context: *mut c_void) -> u32 {
    if context.addr() != PRIMARY {
        return INVALID_CONTEXT;
    }
    CONTEXTS.with(|c| c.borrow_mut().push(PRIMARY));
    SUCCESS
}

#[no_mangle]
pub unsafe extern "system" fn cuCtxPopCurrent_v2(context: *mut *mut c_void) -> u32 {
    match CONTEXTS.with(|c| c.borrow_mut().pop()) {
        // SAFETY: promised by the caller.
        Some(now) => unsafe { write(context, core::ptr::without_provenance_mut(now)) },
        None => INVALID_CONTEXT,
    }
}

#[no_mangle]
pub unsafe extern "system" fn cuModuleLoadDataEx(
    module: *mut *mut c_void,
    image: *const c_void,
    count: c_uint,
    options: *mut c_int,
    values: *mut *mut c_void,
) -> u32 {
    in_context(|| {
        // SAFETY: the caller gives a text that ends with NUL.
        let text = unsafe { CStr::from_ptr(image.cast()) }.to_string_lossy();
        let read = modules::read(&text);
        let code = match (settings::assembler(), &read) {
            (0, None) => INVALID_PTX,
            (0, Some((generation, _))) if *generation > settings::generation() => NO_BINARY_FOR_GPU,
            (code, _) => code,
        };
        if code != SUCCESS {
            // SAFETY: there are so many options, and so many values; 5 is a buffer for what the assembler says, 6 its size.
            unsafe { say(b"ptxas fatal : stand-in\0", count, options, values) };
            return code;
        }
        let Some((_, signatures)) = read else {
            return INVALID_PTX;
        };
        let handle = Box::into_raw(Box::new(signatures));
        // SAFETY: promised by the caller.
        unsafe { write(module, handle.cast()) }
    })
}

/// # Safety
/// As of `cuModuleLoadDataEx`.
unsafe fn say(text: &[u8], count: c_uint, options: *mut c_int, values: *mut *mut c_void) {
    let (mut to, mut room) = (core::ptr::null_mut::<u8>(), 0);
    for k in 0..count as usize {
        // SAFETY: promised by the caller.
        match unsafe { (*options.add(k), *values.add(k)) } {
            (5, buffer) => to = buffer.cast(),
            (6, size) => room = size.addr(),
            _ => {}
        }
    }
    if !to.is_null() && room >= text.len() {
        // SAFETY: the buffer has this room.
        unsafe { core::ptr::copy_nonoverlapping(text.as_ptr(), to, text.len()) };
    }
}

#[no_mangle]
pub unsafe extern "system" fn cuModuleUnload(module: *mut c_void) -> u32 {
    in_context(|| {
        // SAFETY: made by `cuModuleLoadDataEx`, and unloaded once, as the caller promises.
        drop(unsafe { Box::from_raw(module.cast::<Signatures>()) });
        SUCCESS
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuModuleGetFunction(
    function: *mut *mut c_void,
    module: *mut c_void,
    name: *const c_char,
) -> u32 {
    in_context(|| {
        // SAFETY: the module is loaded, the name ends with NUL, as the caller promises.
        let (signatures, name) = unsafe {
            (
                &*module.cast::<Signatures>().cast_const(),
                CStr::from_ptr(name).to_string_lossy(),
            )
        };
        match Function::of(signatures, &name) {
            Ok(found) => {
                let handle = core::ptr::from_ref(found).cast_mut().cast();
                // SAFETY: promised by the caller.
                unsafe { write(function, handle) }
            }
            Err(Lacking::Unknown) => NOT_FOUND,
            Err(Lacking::Different(how)) => {
                eprintln!("stand-in driver: {how}");
                INVALID_PTX
            }
        }
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuMemAlloc_v2(address: *mut u64, bytes: usize) -> u32 {
    in_context(|| {
        if bytes == 0 {
            return INVALID_VALUE;
        }
        add(What::Allocations, 1);
        match memory::allocate(bytes) {
            // SAFETY: promised by the caller.
            Some(found) => unsafe { write(address, found) },
            None => OUT_OF_MEMORY,
        }
    })
}

#[no_mangle]
pub extern "system" fn cuMemFree_v2(address: u64) -> u32 {
    in_context(|| {
        add(What::Frees, 1);
        if memory::free(address) {
            SUCCESS
        } else {
            INVALID_VALUE
        }
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuMemGetInfo_v2(free: *mut usize, all: *mut usize) -> u32 {
    in_context(|| {
        // SAFETY: promised by the caller.
        unsafe {
            write(free, memory::left());
            write(all, settings::memory())
        }
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuMemcpyHtoDAsync_v2(
    to: u64,
    from: *const c_void,
    bytes: usize,
    stream: *mut c_void,
) -> u32 {
    on_stream(stream, || {
        let Some(there) = memory::on_host(to, bytes) else {
            return INVALID_VALUE;
        };
        add(What::BytesIn, bytes);
        // SAFETY: so many are there on either side; the memory of the stand-in is its own.
        unsafe { core::ptr::copy_nonoverlapping(from.cast::<u8>(), there, bytes) };
        SUCCESS
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuMemcpyDtoHAsync_v2(
    to: *mut c_void,
    from: u64,
    bytes: usize,
    stream: *mut c_void,
) -> u32 {
    on_stream(stream, || {
        let Some(there) = memory::on_host(from, bytes) else {
            return INVALID_VALUE;
        };
        add(What::BytesOut, bytes);
        // SAFETY: as above.
        unsafe { core::ptr::copy_nonoverlapping(there, to.cast::<u8>(), bytes) };
        SUCCESS
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuMemcpyHtoD_v2(to: u64, from: *const c_void, bytes: usize) -> u32 {
    // SAFETY: promised by the caller.
    unsafe { cuMemcpyHtoDAsync_v2(to, from, bytes, core::ptr::null_mut()) }
}

#[no_mangle]
pub unsafe extern "system" fn cuMemcpyDtoH_v2(to: *mut c_void, from: u64, bytes: usize) -> u32 {
    // SAFETY: promised by the caller.
    unsafe { cuMemcpyDtoHAsync_v2(to, from, bytes, core::ptr::null_mut()) }
}

#[no_mangle]
pub extern "system" fn cuMemcpyDtoDAsync_v2(
    to: u64,
    from: u64,
    bytes: usize,
    stream: *mut c_void,
) -> u32 {
    on_stream(stream, || {
        let (Some(target), Some(source)) =
            (memory::on_host(to, bytes), memory::on_host(from, bytes))
        else {
            return INVALID_VALUE;
        };
        add(What::BytesWithin, bytes);
        // SAFETY: so many are there on either side; they may overlap.
        unsafe { core::ptr::copy(source, target, bytes) };
        SUCCESS
    })
}

#[no_mangle]
pub extern "system" fn cuMemsetD32Async(
    to: u64,
    word: c_uint,
    words: usize,
    stream: *mut c_void,
) -> u32 {
    on_stream(stream, || {
        let there = words
            .checked_mul(4)
            .and_then(|bytes| memory::on_host(to, bytes));
        match there {
            Some(there) if to.is_multiple_of(4) => {
                // SAFETY: so many are there, aligned to four bytes.
                unsafe { core::slice::from_raw_parts_mut(there.cast::<u32>(), words) }.fill(word);
                SUCCESS
            }
            _ => INVALID_VALUE,
        }
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuPointerGetAttribute(
    data: *mut c_void,
    attribute: c_int,
    pointer: u64,
) -> u32 {
    in_context(|| {
        if attribute != 2 || memory::on_host(pointer, 1).is_none() {
            return INVALID_VALUE;
        }
        // SAFETY: the type of memory is a number of four bytes; 2 is that of a device.
        unsafe { write(data.cast::<c_uint>(), 2) }
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuLaunchKernel(
    function: *mut c_void,
    grid_x: c_uint,
    grid_y: c_uint,
    grid_z: c_uint,
    block_x: c_uint,
    block_y: c_uint,
    block_z: c_uint,
    shared: c_uint,
    stream: *mut c_void,
    parameters: *mut *mut c_void,
    extra: *mut *mut c_void,
) -> u32 {
    on_stream(stream, || {
        let plain = [grid_y, grid_z, block_y, block_z] == [1; 4] && shared == 0 && extra.is_null();
        if !plain || grid_x == 0 || !(1..=1024).contains(&block_x) {
            return INVALID_VALUE;
        }
        add(What::Launches, 1);
        let threads = grid_x as usize * block_x as usize;
        // SAFETY: the function is one of `cuModuleGetFunction`, and there are pointers to its two parameters, as the caller promises.
        let code = unsafe {
            let function = &*function.cast::<Function>();
            function.run(
                threads,
                (*parameters).cast_const().cast(),
                (*parameters.add(1)).cast_const().cast(),
            )
        };
        if code != SUCCESS {
            ENDED.store(code, Ordering::Relaxed);
        }
        // As on a device, which tells of it later.
        SUCCESS
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuStreamCreate(stream: *mut *mut c_void, _flags: c_uint) -> u32 {
    in_context(|| {
        let made = STREAMS + MADE_STREAMS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: promised by the caller.
        unsafe { write(stream, core::ptr::without_provenance_mut(made)) }
    })
}

#[no_mangle]
pub extern "system" fn cuStreamSynchronize(stream: *mut c_void) -> u32 {
    on_stream(stream, || {
        add(What::Waits, 1);
        SUCCESS
    })
}

#[no_mangle]
pub unsafe extern "system" fn cuGetErrorName(code: u32, text: *mut *const c_char) -> u32 {
    let name = match code {
        INVALID_VALUE => c"CUDA_ERROR_INVALID_VALUE",
        OUT_OF_MEMORY => c"CUDA_ERROR_OUT_OF_MEMORY",
        NO_DEVICE => c"CUDA_ERROR_NO_DEVICE",
        INVALID_CONTEXT => c"CUDA_ERROR_INVALID_CONTEXT",
        INVALID_PTX => c"CUDA_ERROR_INVALID_PTX",
        INVALID_HANDLE => c"CUDA_ERROR_INVALID_HANDLE",
        700 => c"CUDA_ERROR_ILLEGAL_ADDRESS",
        715 => c"CUDA_ERROR_ILLEGAL_INSTRUCTION",
        _ => return INVALID_VALUE,
    };
    // SAFETY: promised by the caller.
    unsafe { write(text, name.as_ptr()) }
}

#[no_mangle]
pub unsafe extern "system" fn cuGetErrorString(code: u32, text: *mut *const c_char) -> u32 {
    // SAFETY: promised by the caller.
    unsafe { cuGetErrorName(code, text) }
}
