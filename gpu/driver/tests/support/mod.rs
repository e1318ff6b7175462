// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stand-in for a driver, and an engine that has its arrays in the memory of its GPU.
//!
//! With ELLGRAN_TEST_GPU_DRIVER, the file of NVIDIA's driver (`libcuda.so.1`), all is on a GPU instead.

#![allow(unsafe_code, dead_code)]
// Each block calls a function of the driver or of the interface with pointers to locals that outlive the call.
#![allow(clippy::undocumented_unsafe_blocks)]

use core::ffi::{c_char, c_void, CStr};
use ellgran::c_api::law::{
    ellgran_law_parameters_parse, ellgran_laws_new, EllgranLawParameters, EllgranLaws,
};
use ellgran::c_api::status::ellgran_last_error;
use ellgran_gpu::arrays::{EllgranGpuLoads, EllgranGpuVectors};
use ellgran_gpu::c_api::gpu::{ellgran_gpu_open, EllgranGpu};
use std::cell::Cell;
use std::ffi::CString;
use std::marker::PhantomData;
use std::path::PathBuf;
use std::process::Command;

/// The variable that makes a test run its body: it names the test.
const CHILD: &str = "ELLGRAN_GPU_TEST";
const DRIVER: &str = "ELLGRAN_GPU_DRIVER";

/// Names the driver of a GPU to be tested.
const ON_A_GPU: &str = "ELLGRAN_TEST_GPU_DRIVER";

/// The driver of a GPU, if tests are to run there.
fn driver_of_a_gpu() -> Option<PathBuf> {
    std::env::var_os(ON_A_GPU).map(PathBuf::from)
}

fn driver_file() -> PathBuf {
    driver_of_a_gpu().unwrap_or_else(stand_in)
}

/// The stand-in, which cargo has built beside the tests.
pub fn stand_in() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let name = format!(
        "{}ellgran_gpu_stand_in{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let places = tests.ancestors().skip(1).take(2);
    let mut found = places.map(|place| place.join(&name)).filter(|p| p.exists());
    found
        .next()
        .unwrap_or_else(|| panic!("no {name} beside {}", tests.display()))
}

/// Runs the body of the test `name` in a process of its own, with the stand-in for a driver and these variables.
pub fn with_driver(name: &str, settings: &[(&str, &str)], body: impl FnOnce()) {
    if std::env::var(CHILD).is_ok_and(|child| child == name) {
        return body();
    }
    let output = Command::new(std::env::current_exe().unwrap())
        .args([name, "--exact", "--nocapture", "--test-threads=1"])
        .env(CHILD, name)
        .env(DRIVER, driver_file())
        .envs(settings.iter().copied())
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
        .concat();
    assert!(
        output.status.success() && text.contains("1 passed"),
        "{name}: {}\n{text}",
        output.status
    );
}

pub fn last_error() -> String {
    unsafe { CStr::from_ptr(ellgran_last_error()) }
        .to_string_lossy()
        .into_owned()
}

/// A call that must succeed.
#[track_caller]
pub fn succeed(status: i32) {
    assert_eq!(status, 0, "{}", last_error());
}

/// A call that must fail with this status, and a message that has these words.
#[track_caller]
pub fn fail(status: i32, expected: i32, words: &[&str]) {
    let message = last_error();
    assert_eq!(status, expected, "{message}");
    for word in words {
        assert!(message.contains(word), "no '{word}' in: {message}");
    }
}

/// A new struct of the interface: its size, and zeros.
pub fn new<T: ellgran::c_api::growing::Growing>() -> T {
    let mut value = core::mem::MaybeUninit::<T>::zeroed();
    unsafe {
        value.as_mut_ptr().cast::<usize>().write(size_of::<T>());
        value.assume_init()
    }
}

/// A law for each type, parted by ` | `; what two types have with each other is mixed.
pub fn laws(words: &str) -> *mut EllgranLaws {
    let own: Vec<EllgranLawParameters> = words.split(" | ").map(parameters).collect();
    let n = own.len();
    let table: Vec<_> = (0..n * n).map(|k| own[k / n]).collect();
    let is_set: Vec<u8> = (0..n * n).map(|k| u8::from(k % (n + 1) == 0)).collect();
    let mut laws = core::ptr::null_mut();
    unsafe {
        succeed(ellgran_laws_new(
            n as i32,
            table.as_ptr(),
            is_set.as_ptr(),
            0,
            &mut laws,
        ));
    }
    laws
}

fn parameters(words: &str) -> EllgranLawParameters {
    let words: Vec<CString> = words.split(' ').map(|w| CString::new(w).unwrap()).collect();
    let pointers: Vec<*const c_char> = words.iter().map(|w| w.as_ptr()).collect();
    let mut parameters = new::<EllgranLawParameters>();
    unsafe {
        succeed(ellgran_law_parameters_parse(
            pointers.len(),
            pointers.as_ptr(),
            core::ptr::null_mut(),
            &mut parameters,
        ));
    }
    parameters
}

pub fn open() -> *mut EllgranGpu {
    let mut gpu = core::ptr::null_mut();
    succeed(unsafe { ellgran_gpu_open(0, &mut gpu) });
    gpu
}

type Handle = *mut c_void;

/// What an engine calls of the driver.
pub struct Engine {
    library: libloading::Library,
    context: Handle,
    pub stream: Handle,
    /// How many calls of steps there were.
    calls: Cell<usize>,
}

/// A mark in a stream.
pub struct Event(Handle);

/// An array on the device.
pub struct Array<T> {
    pub address: u64,
    length: usize,
    of: PhantomData<T>,
}

impl<T> Array<T> {
    pub fn pointer<P>(&self) -> *mut P {
        core::ptr::without_provenance_mut(self.address as usize)
    }
}

impl<const N: usize> Array<[f64; N]> {
    /// One vector after the other.
    pub fn vectors(&self) -> EllgranGpuVectors {
        EllgranGpuVectors {
            first: self.pointer(),
            per_grain: 0,
            per_component: 0,
        }
    }

    /// Three components of each row, from `first` on.
    fn part(&self, first: usize) -> EllgranGpuVectors {
        EllgranGpuVectors {
            first: self.pointer::<f64>().wrapping_add(first),
            per_grain: N,
            per_component: 1,
        }
    }
}

impl Array<[f64; 6]> {
    /// Forces and then torques, one row for each grain: overwritten.
    pub fn loads(&self) -> EllgranGpuLoads {
        EllgranGpuLoads {
            forces: self.part(0),
            torques: self.part(3),
            ..new()
        }
    }
}

/// What the stand-in counts.
#[derive(Clone, Copy, Debug)]
pub enum Tally {
    Allocations = 0,
    Frees = 1,
    Launches = 2,
    BytesIn = 3,
    BytesOut = 4,
    BytesWithin = 5,
    OnDefaultStream = 6,
    Waits = 7,
}

impl Engine {
    /// In the context that all libraries share, with a stream of its own.
    pub fn new() -> Engine {
        let library = unsafe { libloading::Library::new(driver_file()) }.unwrap();
        let mut engine = Engine {
            library,
            context: core::ptr::null_mut(),
            stream: core::ptr::null_mut(),
            calls: Cell::new(0),
        };
        unsafe {
            let start = engine.function::<extern "system" fn(u32) -> u32>("cuInit");
            assert_eq!(start(0), 0);
            let retain = engine.function::<extern "system" fn(*mut Handle, i32) -> u32>(
                "cuDevicePrimaryCtxRetain",
            );
            assert_eq!(retain(&mut engine.context, 0), 0);
        }
        engine.enter();
        unsafe {
            let create =
                engine.function::<extern "system" fn(*mut Handle, u32) -> u32>("cuStreamCreate");
            assert_eq!(create(&mut engine.stream, 0), 0);
        }
        engine
    }

    unsafe fn function<F: Copy>(&self, name: &str) -> F {
        *unsafe { self.library.get::<F>(name) }.unwrap()
    }

    /// Makes the context that of this thread.
    pub fn enter(&self) {
        unsafe {
            let push = self.function::<extern "system" fn(Handle) -> u32>("cuCtxPushCurrent_v2");
            assert_eq!(push(self.context), 0);
        }
    }

    /// And no longer.
    pub fn leave(&self) {
        let mut context: Handle = core::ptr::null_mut();
        unsafe {
            let pop = self.function::<extern "system" fn(*mut Handle) -> u32>("cuCtxPopCurrent_v2");
            assert_eq!(pop(&mut context), 0);
        }
        assert_eq!(context, self.context);
    }

    pub fn tally(&self, which: Tally) -> u64 {
        unsafe {
            let tally = self.function::<extern "C" fn(u32) -> u64>("ellgran_stand_in_tally");
            tally(which as u32)
        }
    }

    /// An array with these elements.
    pub fn put<T: Copy>(&self, elements: &[T]) -> Array<T> {
        let mut address = 0u64;
        unsafe {
            let allocate =
                self.function::<extern "system" fn(*mut u64, usize) -> u32>("cuMemAlloc_v2");
            assert_eq!(
                allocate(&mut address, core::mem::size_of_val(elements).max(8)),
                0
            );
        }
        let array = Array {
            address,
            length: elements.len(),
            of: PhantomData,
        };
        self.write(&array, 0, elements);
        array
    }

    /// Writes elements from `first` on.
    pub fn write<T: Copy>(&self, array: &Array<T>, first: usize, elements: &[T]) {
        if elements.is_empty() {
            return;
        }
        assert!(first + elements.len() <= array.length);
        let at = array.address + (first * size_of::<T>()) as u64;
        unsafe {
            let copy = self
                .function::<extern "system" fn(u64, *const c_void, usize, Handle) -> u32>(
                    "cuMemcpyHtoDAsync_v2",
                );
            let bytes = core::mem::size_of_val(elements);
            assert_eq!(copy(at, elements.as_ptr().cast(), bytes, self.stream), 0);
        }
    }

    /// All elements.
    pub fn read<T: Copy + Default>(&self, array: &Array<T>) -> Vec<T> {
        self.read_at(array.address, array.length)
    }

    pub fn read_at<T: Copy + Default>(&self, address: u64, length: usize) -> Vec<T> {
        let mut elements = vec![T::default(); length];
        if length > 0 {
            unsafe {
                let copy = self
                    .function::<extern "system" fn(*mut c_void, u64, usize, Handle) -> u32>(
                        "cuMemcpyDtoHAsync_v2",
                    );
                let bytes = core::mem::size_of_val(&elements[..]);
                assert_eq!(
                    copy(elements.as_mut_ptr().cast(), address, bytes, self.stream),
                    0
                );
            }
        }
        elements
    }

    /// Bytes of the GPU that nobody has taken.
    fn free_memory(&self) -> usize {
        let (mut free, mut total) = (0usize, 0usize);
        unsafe {
            let ask = self
                .function::<extern "system" fn(*mut usize, *mut usize) -> u32>("cuMemGetInfo_v2");
            assert_eq!(ask(&mut free, &mut total), 0);
        }
        free
    }

    /// What the GPU is called.
    pub fn name(&self) -> String {
        let mut name = [0 as c_char; 100];
        unsafe {
            let ask = self
                .function::<extern "system" fn(*mut c_char, i32, i32) -> u32>("cuDeviceGetName");
            assert_eq!(ask(name.as_mut_ptr(), name.len() as i32, 0), 0);
            CStr::from_ptr(name.as_ptr()).to_string_lossy().into_owned()
        }
    }

    /// A mark in the stream that knows when it was reached.
    pub fn event(&self) -> Event {
        let mut event = Event(core::ptr::null_mut());
        unsafe {
            let create =
                self.function::<extern "system" fn(*mut Handle, u32) -> u32>("cuEventCreate");
            assert_eq!(create(&mut event.0, 0), 0);
        }
        event
    }

    /// Puts it into the stream.
    pub fn record(&self, event: &Event) {
        unsafe {
            let record =
                self.function::<extern "system" fn(Handle, Handle) -> u32>("cuEventRecord");
            assert_eq!(record(event.0, self.stream), 0);
        }
    }

    /// Time between two that were reached.
    pub fn milliseconds(&self, from: &Event, to: &Event) -> f64 {
        let mut time = 0f32;
        unsafe {
            let elapsed = self.function::<extern "system" fn(*mut f32, Handle, Handle) -> u32>(
                "cuEventElapsedTime",
            );
            assert_eq!(elapsed(&mut time, from.0, to.0), 0);
        }
        f64::from(time)
    }

    /// Makes calls of a step: they allocate nothing, copy nothing, wait for nothing, and keep to the stream. On a GPU the first of
    /// these is what can be seen.
    #[track_caller]
    pub fn in_a_step(&self, calls: impl FnOnce()) {
        if driver_of_a_gpu().is_some() {
            // The driver loads a kernel when it is first started; calls of the first steps do that.
            let before = self.free_memory();
            calls();
            self.calls.set(self.calls.get() + 1);
            if self.calls.get() > 20 {
                assert_eq!(
                    self.free_memory(),
                    before,
                    "is the GPU used by somebody else?"
                );
            }
            return;
        }
        use Tally::{
            Allocations, BytesIn, BytesOut, BytesWithin, Frees, Launches, OnDefaultStream, Waits,
        };
        let all = [
            Allocations,
            Frees,
            BytesIn,
            BytesOut,
            BytesWithin,
            OnDefaultStream,
            Waits,
        ];
        let before = all.map(|which| self.tally(which));
        let launches = self.tally(Launches);
        calls();
        assert_eq!(all.map(|which| self.tally(which)), before, "{all:?}");
        assert!(self.tally(Launches) > launches);
    }
}
