// SPDX-License-Identifier: MIT OR Apache-2.0
//! The functions of NVIDIA's driver that are used here, and all `unsafe` towards it.
//!
//! The library is opened when the first device is asked for, and stays open until the process ends: the driver has threads of its own.
//! Results are numbers, since a newer driver may have some that are not known here.

#![allow(unsafe_code)]

use crate::status::{
    ELLGRAN_GPU_ERROR_ASSEMBLER, ELLGRAN_GPU_ERROR_DRIVER, ELLGRAN_GPU_ERROR_KERNEL,
    ELLGRAN_GPU_ERROR_MEMORY, ELLGRAN_GPU_ERROR_NO_DEVICE, ELLGRAN_GPU_ERROR_NO_DRIVER,
    ELLGRAN_GPU_ERROR_OLD_DRIVER, ELLGRAN_GPU_ERROR_POINTER,
};
use core::ffi::{c_char, c_int, c_uint, c_void, CStr};
use ellgran::c_api::status::Failure;
use libloading::Library;
use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

/// A path to the driver's library, in place of the names that the loader looks for.
pub const ENVIRONMENT_VARIABLE: &str = "ELLGRAN_GPU_DRIVER";

#[cfg(windows)]
const NAMES: [&str; 1] = ["nvcuda.dll"];
#[cfg(not(windows))]
const NAMES: [&str; 2] = ["libcuda.so.1", "libcuda.so"];

/// The numbers of the driver's results (cuda.h) that mean something here.
mod results {
    pub const OUT_OF_MEMORY: u32 = 2;
    pub const STUB_LIBRARY: u32 = 34;
    pub const NO_DEVICE: u32 = 100;
    pub const INVALID_DEVICE: u32 = 101;
    pub const NO_BINARY_FOR_GPU: u32 = 209;
    pub const INVALID_PTX: u32 = 218;
    pub const JIT_COMPILER_NOT_FOUND: u32 = 221;
    pub const UNSUPPORTED_PTX_VERSION: u32 = 222;
    /// What a kernel ends in: illegal address; stack error, illegal instruction, misaligned address, invalid address space, invalid
    /// program counter, launch failed. The context is lost.
    pub const ENDED: [u32; 7] = [700, 714, 715, 716, 717, 718, 719];
    pub const LAUNCH_OUT_OF_RESOURCES: u32 = 701;
    pub const SYSTEM_DRIVER_MISMATCH: u32 = 803;
}

const COMPUTE_CAPABILITY_MAJOR: c_int = 75;
const COMPUTE_CAPABILITY_MINOR: c_int = 76;
/// The device reads memory of the host that was not given to the driver.
const PAGEABLE_MEMORY_ACCESS: c_int = 88;
const POINTER_MEMORY_TYPE: c_int = 2;
const JIT_ERROR_LOG_BUFFER: c_int = 5;
const JIT_ERROR_LOG_BUFFER_SIZE: c_int = 6;

/// What the driver knows things by.
pub type Handle = *mut c_void;

macro_rules! functions {
    ($($field:ident = $name:literal ($($argument:ty),*);)*) => {
        /// The functions.
        struct Functions {
            $( $field: unsafe extern "system" fn($($argument),*) -> u32, )*
        }

        impl Functions {
            /// # Safety
            /// The library is a driver of NVIDIA, or has the same interface; it is not closed.
            unsafe fn of(library: &Library) -> Result<Functions, &'static str> {
                Ok(Functions {
                    // SAFETY: promised by the caller; the types are those of cuda.h.
                    $( $field: *unsafe { library.get($name) }.map_err(|_| $name)?, )*
                })
            }
        }
    };
}

functions! {
    init = "cuInit" (c_uint);
    driver_version = "cuDriverGetVersion" (*mut c_int);
    device_count = "cuDeviceGetCount" (*mut c_int);
    device = "cuDeviceGet" (*mut c_int, c_int);
    device_name = "cuDeviceGetName" (*mut c_char, c_int, c_int);
    device_attribute = "cuDeviceGetAttribute" (*mut c_int, c_int, c_int);
    retain_primary = "cuDevicePrimaryCtxRetain" (*mut Handle, c_int);
    release_primary = "cuDevicePrimaryCtxRelease_v2" (c_int);
    current_context = "cuCtxGetCurrent" (*mut Handle);
    device_of_context = "cuCtxGetDevice" (*mut c_int);
    push_context = "cuCtxPushCurrent_v2" (Handle);
    pop_context = "cuCtxPopCurrent_v2" (*mut Handle);
    load_module = "cuModuleLoadDataEx" (*mut Handle, *const c_void, c_uint, *mut c_int, *mut *mut c_void);
    unload_module = "cuModuleUnload" (Handle);
    function = "cuModuleGetFunction" (*mut Handle, Handle, *const c_char);
    allocate = "cuMemAlloc_v2" (*mut u64, usize);
    free = "cuMemFree_v2" (u64);
    memory_info = "cuMemGetInfo_v2" (*mut usize, *mut usize);
    copy_in = "cuMemcpyHtoDAsync_v2" (u64, *const c_void, usize, Handle);
    copy_out = "cuMemcpyDtoHAsync_v2" (*mut c_void, u64, usize, Handle);
    copy_within = "cuMemcpyDtoDAsync_v2" (u64, u64, usize, Handle);
    fill = "cuMemsetD32Async" (u64, c_uint, usize, Handle);
    pointer_attribute = "cuPointerGetAttribute" (*mut c_void, c_int, u64);
    launch = "cuLaunchKernel" (
        Handle, c_uint, c_uint, c_uint, c_uint, c_uint, c_uint, c_uint, Handle, *mut *mut c_void, *mut *mut c_void
    );
    synchronise = "cuStreamSynchronize" (Handle);
    error_name = "cuGetErrorName" (u32, *mut *const c_char);
    error_text = "cuGetErrorString" (u32, *mut *const c_char);
}

/// The driver, ready to be asked.
pub struct Driver {
    functions: Functions,
    version: i32,
}

/// A context, with what else the driver needs to be given.
#[derive(Clone, Copy)]
pub struct Context(Handle);

/// A module of kernels.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Module(Handle);

/// A kernel.
#[derive(Clone, Copy)]
pub struct Function(Handle);

/// A stream of the caller, NULL for the default one.
#[derive(Clone, Copy)]
pub struct Stream(pub Handle);

// SAFETY: the driver's functions may be called from any thread with any of these; each is a number to this process.
unsafe impl Send for Context {}
// SAFETY: as above.
unsafe impl Sync for Context {}
// SAFETY: as above.
unsafe impl Send for Module {}
// SAFETY: as above.
unsafe impl Sync for Module {}
// SAFETY: as above.
unsafe impl Send for Function {}
// SAFETY: as above.
unsafe impl Sync for Function {}

fn fail<T>(status: i32, message: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::new(status, message))
}

/// The driver of this machine. A failure is not remembered: the next call tries again.
pub fn driver() -> Result<&'static Driver, Failure> {
    static LOADED: Mutex<Option<&'static Driver>> = Mutex::new(None);
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(driver) = *loaded {
        return Ok(driver);
    }
    let driver: &'static Driver = Box::leak(Box::new(load()?));
    *loaded = Some(driver);
    Ok(driver)
}

/// An error with what has caused it, which for the loader's is all that it says.
fn in_full(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(cause) => format!("{error}: {}", in_full(cause)),
        None => error.to_string(),
    }
}

fn load() -> Result<Driver, Failure> {
    let given = std::env::var_os(ENVIRONMENT_VARIABLE).filter(|path| !path.is_empty());
    let open = |name: &std::ffi::OsStr| {
        // SAFETY: the driver's library may run what it likes when it is loaded; it is the one that this machine's administrator or
        // the caller has named.
        unsafe { Library::new(name) }
    };
    let opened = match &given {
        Some(path) => open(path),
        None => {
            let mut found = open(NAMES[0].as_ref());
            for name in &NAMES[1..] {
                found = found.or_else(|first| open(name.as_ref()).map_err(|_| first));
            }
            found
        }
    };
    let library = opened.or_else(|why| {
        let what = match &given {
            Some(path) => format!("{}, which {ENVIRONMENT_VARIABLE} names", path.display()),
            None => NAMES[0].to_owned(),
        };
        fail(
            ELLGRAN_GPU_ERROR_NO_DRIVER,
            format!(
                "NVIDIA's driver cannot be loaded: {what}: {}. Install the driver (no CUDA toolkit is needed), or set \
                 {ENVIRONMENT_VARIABLE} to the path of its library",
                in_full(&why)
            ),
        )
    })?;
    // SAFETY: the library is the driver's; it is never closed.
    let functions = unsafe { Functions::of(&library) }.or_else(|name| {
        fail(
            ELLGRAN_GPU_ERROR_OLD_DRIVER,
            format!(
                "NVIDIA's driver has no {name}: it is older than CUDA 11.0, install a newer one"
            ),
        )
    })?;
    core::mem::forget(library);
    let mut driver = Driver {
        functions,
        version: 0,
    };
    // SAFETY: the driver takes 0 and no other number.
    match unsafe { (driver.functions.init)(0) } {
        0 => {}
        results::NO_DEVICE => {
            return fail(
                ELLGRAN_GPU_ERROR_NO_DEVICE,
                "NVIDIA's driver finds no GPU: is there one, and is it hidden by CUDA_VISIBLE_DEVICES?",
            )
        }
        results::STUB_LIBRARY => {
            return fail(
                ELLGRAN_GPU_ERROR_NO_DRIVER,
                "the library found is the toolkit's stub for linking, not NVIDIA's driver: take its directory out of LD_LIBRARY_PATH",
            )
        }
        code => return Err(driver.failure(code, "cuInit")),
    }
    // SAFETY: a number is written.
    let code = unsafe { (driver.functions.driver_version)(&mut driver.version) };
    driver.checked(code, "cuDriverGetVersion")?;
    Ok(driver)
}

impl Driver {
    /// The version of CUDA that it knows: 12040 is 12.4.
    pub fn version(&self) -> i32 {
        self.version
    }

    /// Name and words of a result.
    fn words(&self, code: u32) -> String {
        let text = |function: unsafe extern "system" fn(u32, *mut *const c_char) -> u32| {
            let mut text = core::ptr::null();
            // SAFETY: the driver writes NULL or a text that is always there.
            unsafe {
                if function(code, &mut text) != 0 || text.is_null() {
                    return String::new();
                }
                CStr::from_ptr(text).to_string_lossy().into_owned()
            }
        };
        format!(
            "{} ({code}): {}",
            text(self.functions.error_name),
            text(self.functions.error_text)
        )
    }

    /// A result that is no success as a failure.
    fn failure(&self, code: u32, what: &str) -> Failure {
        let words = self.words(code);
        let (status, advice) = match code {
            results::OUT_OF_MEMORY | results::LAUNCH_OUT_OF_RESOURCES => (
                ELLGRAN_GPU_ERROR_MEMORY,
                "the GPU has too little memory: fewer grains, or a larger GPU. The kernel for deep contacts alone takes 18 kB for each \
                 thread that the GPU can hold",
            ),
            results::NO_DEVICE | results::INVALID_DEVICE => {
                (ELLGRAN_GPU_ERROR_NO_DEVICE, "there is no such GPU")
            }
            results::UNSUPPORTED_PTX_VERSION | results::SYSTEM_DRIVER_MISMATCH => (
                ELLGRAN_GPU_ERROR_OLD_DRIVER,
                "the driver is too old, or only a part of it was updated: install a newer one, then restart the machine",
            ),
            results::INVALID_PTX
            | results::NO_BINARY_FOR_GPU
            | results::JIT_COMPILER_NOT_FOUND => (
                ELLGRAN_GPU_ERROR_ASSEMBLER,
                "the driver does not assemble the kernels",
            ),
            code if results::ENDED.contains(&code) => (
                ELLGRAN_GPU_ERROR_KERNEL,
                "a kernel was ended by the GPU, and what was in its memory is lost: an array is shorter than was said, a list has \
                 changed since ellgran_gpu_new_list, or a pointer is not to the GPU's memory. Free the scene and the GPU; the process \
                 must begin anew",
            ),
            _ => (ELLGRAN_GPU_ERROR_DRIVER, "the driver has failed"),
        };
        Failure::new(status, format!("{what}: {advice}. {words}"))
    }

    fn checked(&self, code: u32, what: &str) -> Result<(), Failure> {
        if code == 0 {
            Ok(())
        } else {
            Err(self.failure(code, what))
        }
    }

    /// The device with this number, of those that there are.
    pub fn device(&self, ordinal: i32) -> Result<i32, Failure> {
        let mut count = 0;
        // SAFETY: a number is written.
        let code = unsafe { (self.functions.device_count)(&mut count) };
        self.checked(code, "cuDeviceGetCount")?;
        if !(0..count).contains(&ordinal) {
            return fail(
                ELLGRAN_GPU_ERROR_NO_DEVICE,
                format!(
                    "there is no GPU {ordinal}: NVIDIA's driver finds {count}, numbered from 0"
                ),
            );
        }
        let mut device = 0;
        // SAFETY: a number is written.
        let code = unsafe { (self.functions.device)(&mut device, ordinal) };
        self.checked(code, "cuDeviceGet")?;
        Ok(device)
    }

    /// What the maker calls a device.
    pub fn name(&self, device: i32) -> Result<String, Failure> {
        let mut text = [0 as c_char; 256];
        // SAFETY: as many characters are there, of which the last stays 0.
        let code = unsafe { (self.functions.device_name)(text.as_mut_ptr(), 255, device) };
        self.checked(code, "cuDeviceGetName")?;
        // SAFETY: the text ends with 0 within the array.
        let text = unsafe { CStr::from_ptr(text.as_ptr()) };
        Ok(text.to_string_lossy().into_owned())
    }

    fn attribute(&self, device: i32, which: c_int) -> Result<i32, Failure> {
        let mut value = 0;
        // SAFETY: a number is written.
        let code = unsafe { (self.functions.device_attribute)(&mut value, which, device) };
        self.checked(code, "cuDeviceGetAttribute")?;
        Ok(value)
    }

    /// The generation of a device: 70 for sm_70.
    pub fn generation(&self, device: i32) -> Result<i32, Failure> {
        Ok(10 * self.attribute(device, COMPUTE_CAPABILITY_MAJOR)?
            + self.attribute(device, COMPUTE_CAPABILITY_MINOR)?)
    }

    /// Whether a device reads any memory of the host.
    pub fn reads_memory_of_the_host(&self, device: i32) -> bool {
        self.attribute(device, PAGEABLE_MEMORY_ACCESS)
            .is_ok_and(|value| value != 0)
    }

    /// The context that all who use a device share, until [`Driver::release`].
    pub fn primary_context(&self, device: i32) -> Result<Context, Failure> {
        let mut context = core::ptr::null_mut();
        // SAFETY: a handle is written.
        let code = unsafe { (self.functions.retain_primary)(&mut context, device) };
        self.checked(code, "cuDevicePrimaryCtxRetain")?;
        Ok(Context(context))
    }

    /// Gives it back.
    pub fn release(&self, device: i32) {
        // SAFETY: retained once for each call of this.
        unsafe { (self.functions.release_primary)(device) };
    }

    /// The context of this thread, and its device.
    pub fn current_context(&self) -> Result<(Context, i32), Failure> {
        let mut context = core::ptr::null_mut();
        // SAFETY: a handle is written.
        let code = unsafe { (self.functions.current_context)(&mut context) };
        self.checked(code, "cuCtxGetCurrent")?;
        if context.is_null() {
            return fail(
                ELLGRAN_GPU_ERROR_NO_DEVICE,
                "this thread has no context of a GPU: call ellgran_gpu_open, or this after the engine has chosen its GPU",
            );
        }
        let mut device = 0;
        // SAFETY: a number is written.
        let code = unsafe { (self.functions.device_of_context)(&mut device) };
        self.checked(code, "cuCtxGetDevice")?;
        Ok((Context(context), device))
    }

    /// Makes a context that of this thread, for as long as what is returned is there.
    pub fn enter(&self, context: Context) -> Result<Entered<'_>, Failure> {
        // SAFETY: the context is there: it is kept by a device of this library, or by the caller as he promised.
        let code = unsafe { (self.functions.push_context)(context.0) };
        self.checked(code, "cuCtxPushCurrent")?;
        Ok(Entered(self))
    }

    /// Gives the text of a module to the driver's assembler. `text` ends with NUL.
    pub fn load(&self, text: &CStr) -> Result<Module, Failure> {
        let mut log = vec![0u8; 16 * 1024];
        let mut options = [JIT_ERROR_LOG_BUFFER, JIT_ERROR_LOG_BUFFER_SIZE];
        let mut values = [
            log.as_mut_ptr().cast::<c_void>(),
            // The size itself stands for a pointer.
            core::ptr::without_provenance_mut(log.len() - 1),
        ];
        let mut module = core::ptr::null_mut();
        // SAFETY: the text ends with NUL, and there are two options with their values, of the types that they have.
        let code = unsafe {
            (self.functions.load_module)(
                &mut module,
                text.as_ptr().cast(),
                2,
                options.as_mut_ptr(),
                values.as_mut_ptr(),
            )
        };
        if code == 0 {
            return Ok(Module(module));
        }
        let mut failure = self.failure(code, "the kernels of ellgran");
        let end = log.iter().position(|&b| b == 0).unwrap_or(log.len());
        let said = String::from_utf8_lossy(&log[..end]);
        if !said.trim().is_empty() {
            failure.message += &format!(". The assembler says: {}", said.trim());
        }
        Err(failure)
    }

    /// Unloads a module.
    pub fn unload(&self, module: Module) {
        // SAFETY: loaded once, unloaded once, by the device that owns it.
        unsafe { (self.functions.unload_module)(module.0) };
    }

    /// A kernel by its name.
    pub fn function(&self, module: Module, name: &str) -> Result<Function, Failure> {
        let spelled = CString::new(name).unwrap_or_default();
        let mut function = core::ptr::null_mut();
        // SAFETY: the module is loaded, the name ends with NUL.
        let code = unsafe { (self.functions.function)(&mut function, module.0, spelled.as_ptr()) };
        self.checked(code, name)?;
        Ok(Function(function))
    }

    /// Memory on the device of the present context.
    pub fn allocate(&self, bytes: usize) -> Result<u64, Failure> {
        let mut address = 0;
        // SAFETY: a number is written.
        let code = unsafe { (self.functions.allocate)(&mut address, bytes) };
        if code == results::OUT_OF_MEMORY {
            let (mut free, mut all) = (0, 0);
            // SAFETY: two numbers are written; left 0 where this fails.
            unsafe { (self.functions.memory_info)(&mut free, &mut all) };
            return fail(
                ELLGRAN_GPU_ERROR_MEMORY,
                format!(
                    "the GPU has too little memory: {bytes} bytes more are needed, {free} of {all} are free. Fewer grains, or a larger GPU"
                ),
            );
        }
        self.checked(code, "cuMemAlloc")?;
        Ok(address)
    }

    /// Gives it back, once all that is under way has ended.
    pub fn free(&self, address: u64) {
        // SAFETY: allocated once, freed once, by the buffer that owns it. The driver waits for kernels under way.
        unsafe { (self.functions.free)(address) };
    }

    /// Copies from the host.
    pub fn copy_in<T>(&self, address: u64, from: &[T], stream: Stream) -> Result<(), Failure> {
        if from.is_empty() {
            return Ok(());
        }
        let bytes = core::mem::size_of_val(from);
        // SAFETY: as many bytes are there; the driver has read pageable memory before it returns.
        let code =
            unsafe { (self.functions.copy_in)(address, from.as_ptr().cast(), bytes, stream.0) };
        self.checked(code, "copy to the GPU")
    }

    /// Copies to the host, and waits for it.
    pub fn copy_out<T: Number>(
        &self,
        to: &mut [T],
        address: u64,
        stream: Stream,
    ) -> Result<(), Failure> {
        if to.is_empty() {
            return Ok(());
        }
        let bytes = core::mem::size_of_val(to);
        // SAFETY: as many bytes are there, of which any are numbers of this type, and stay there until the stream has got so far.
        let code =
            unsafe { (self.functions.copy_out)(to.as_mut_ptr().cast(), address, bytes, stream.0) };
        let waited = self.synchronise(stream);
        self.checked(code, "copy from the GPU")?;
        waited
    }

    /// Copies from one place on the device to another.
    pub fn copy_within(
        &self,
        to: u64,
        from: u64,
        bytes: usize,
        stream: Stream,
    ) -> Result<(), Failure> {
        if bytes == 0 {
            return Ok(());
        }
        // SAFETY: addresses are the device's own; a wrong one ends in an error of the driver.
        let code = unsafe { (self.functions.copy_within)(to, from, bytes, stream.0) };
        self.checked(code, "copy on the GPU")
    }

    /// Fills memory with zeros, in words of four bytes.
    pub fn clear(&self, address: u64, words: usize, stream: Stream) -> Result<(), Failure> {
        if words == 0 {
            return Ok(());
        }
        // SAFETY: addresses are the device's own; a wrong one ends in an error of the driver.
        let code = unsafe { (self.functions.fill)(address, 0, words, stream.0) };
        self.checked(code, "filling memory of the GPU")
    }

    /// Whether a pointer is one that the driver has given out.
    pub fn is_known(&self, pointer: u64) -> bool {
        let mut kind: c_uint = 0;
        // SAFETY: a number of four bytes is written; the pointer is only looked up.
        let code = unsafe {
            (self.functions.pointer_attribute)((&raw mut kind).cast(), POINTER_MEMORY_TYPE, pointer)
        };
        code == 0
    }

    /// Starts `count` threads of a kernel with `count` and these arguments, in blocks of `block`.
    ///
    /// The arguments are those of the kernel: [`crate::entries::Entry`] goes with them.
    pub fn launch<A>(
        &self,
        function: Function,
        name: &str,
        count: u32,
        block: u32,
        arguments: &A,
        stream: Stream,
    ) -> Result<(), Failure> {
        if count == 0 {
            return Ok(());
        }
        let mut parameters = [
            core::ptr::from_ref(&count).cast::<c_void>().cast_mut(),
            core::ptr::from_ref(arguments).cast::<c_void>().cast_mut(),
        ];
        // SAFETY: the driver reads as many bytes of each parameter as the kernel's signature has, which are those of `u32` and `A`
        // (the tests hold each signature against its type), before it returns. What the kernel does, it does to the device's memory.
        let code = unsafe {
            (self.functions.launch)(
                function.0,
                count.div_ceil(block),
                1,
                1,
                block,
                1,
                1,
                0,
                stream.0,
                parameters.as_mut_ptr(),
                core::ptr::null_mut(),
            )
        };
        self.checked(code, name)
    }

    /// Waits until all that was given to a stream is done.
    pub fn synchronise(&self, stream: Stream) -> Result<(), Failure> {
        // SAFETY: the stream is the caller's.
        let code = unsafe { (self.functions.synchronise)(stream.0) };
        self.checked(code, "waiting for the GPU")
    }

    /// Fails where a pointer is not to the device's memory.
    pub fn require_known(&self, pointer: u64, name: &str) -> Result<(), Failure> {
        if self.is_known(pointer) {
            return Ok(());
        }
        fail(
            ELLGRAN_GPU_ERROR_POINTER,
            format!("{name} = {pointer:#x} is not a pointer to memory of the GPU: copy the array to the GPU, and give its address there"),
        )
    }
}

/// Types of which any bytes are a value.
pub trait Number: Copy {}
impl Number for u32 {}
impl Number for i32 {}
impl Number for f64 {}

/// A context that this thread is in.
pub struct Entered<'a>(&'a Driver);

impl Drop for Entered<'_> {
    fn drop(&mut self) {
        let mut context = core::ptr::null_mut();
        // SAFETY: the context was pushed when this was made; a handle is written.
        unsafe { (self.0.functions.pop_context)(&mut context) };
    }
}
