// SPDX-License-Identifier: MIT OR Apache-2.0
//! A device with the kernels on it, and memory there.

use crate::driver_library::{driver, Context, Driver, Entered, Function, Module, Stream};
use crate::status::{
    ELLGRAN_GPU_ERROR_ASSEMBLER, ELLGRAN_GPU_ERROR_OLD_DEVICE, ELLGRAN_GPU_ERROR_OLD_DRIVER,
};
use core::ffi::CStr;
use core::marker::PhantomData;
use ellgran::c_api::status::Failure;
use ellgran_kernels::arguments::Memory;
use std::sync::{Arc, OnceLock};

/// A module of kernels, for any device of the generation that it names, or a later one.
#[derive(Clone, Copy, Debug)]
pub enum Kernels {
    /// Those of every scene.
    Grains,
    /// That of walls of cylinders and the like.
    Walls,
    /// Those of walls with triangles.
    Meshes,
    /// Those of energies and virial.
    Tallies,
}

impl Kernels {
    /// Its text, with a NUL at its end.
    pub fn text(self) -> &'static str {
        match self {
            Kernels::Grains => concat!(include_str!("../../ptx/ellgran.ptx"), "\0"),
            Kernels::Walls => concat!(include_str!("../../ptx/ellgran_walls.ptx"), "\0"),
            Kernels::Meshes => concat!(include_str!("../../ptx/ellgran_meshes.ptx"), "\0"),
            Kernels::Tallies => concat!(include_str!("../../ptx/ellgran_tallies.ptx"), "\0"),
        }
    }
}

/// The first version of CUDA whose driver reads PTX of version 7.0.
const LEAST_DRIVER: i32 = 11_000;

/// The generation that the kernels are for: 70 for sm_70.
fn target() -> Option<i32> {
    let (_, rest) = Kernels::Grains.text().split_once("\n.target sm_")?;
    rest.split(|c: char| !c.is_ascii_digit())
        .next()?
        .parse()
        .ok()
}

/// A device.
pub struct Device {
    driver: &'static Driver,
    context: Context,
    /// Of [`Kernels`], each from the first call on that needs it.
    modules: [OnceLock<Module>; 4],
    /// To be released, where this library has retained its context.
    retained: Option<i32>,
    /// Whether a pointer that the driver does not know is an error.
    pub checks_pointers: bool,
}

impl Device {
    /// The device of this number, in the context that all libraries share.
    ///
    /// # Errors
    /// A status of a GPU, and what to do.
    pub fn open(ordinal: i32) -> Result<Arc<Device>, Failure> {
        let driver = driver()?;
        let device = driver.device(ordinal)?;
        check_generation(driver, device)?;
        let context = driver.primary_context(device)?;
        let made = Device::new(driver, context, device, Some(device));
        if made.is_err() {
            driver.release(device);
        }
        made
    }

    /// The device of this thread's context, in that context, which stays the caller's.
    ///
    /// # Errors
    /// A status of a GPU, and what to do.
    pub fn of_this_thread() -> Result<Arc<Device>, Failure> {
        let driver = driver()?;
        let (context, device) = driver.current_context()?;
        check_generation(driver, device)?;
        Device::new(driver, context, device, None)
    }

    fn new(
        driver: &'static Driver,
        context: Context,
        device: i32,
        retained: Option<i32>,
    ) -> Result<Arc<Device>, Failure> {
        let mut made = Device {
            driver,
            context,
            modules: Default::default(),
            retained: None,
            checks_pointers: !driver.reads_memory_of_the_host(device),
        };
        made.module(Kernels::Grains)?;
        // Where this has failed the caller releases it.
        made.retained = retained;
        Ok(Arc::new(made))
    }

    /// Makes the device's context that of this thread.
    ///
    /// # Errors
    /// Of the driver.
    pub fn enter(&self) -> Result<Entered<'static>, Failure> {
        self.driver.enter(self.context)
    }

    /// The driver; the device's context must be entered.
    pub fn driver(&self) -> &'static Driver {
        self.driver
    }

    /// A kernel by its name; the first of a module has the driver assemble all of it.
    ///
    /// # Errors
    /// Of the driver.
    pub fn function(&self, kernels: Kernels, name: &str) -> Result<Function, Failure> {
        self.driver.function(self.module(kernels)?, name)
    }

    fn module(&self, kernels: Kernels) -> Result<Module, Failure> {
        let place = &self.modules[kernels as usize];
        if let Some(module) = place.get() {
            return Ok(*module);
        }
        let _entered = self.enter()?;
        let loaded = load(self.driver, kernels.text())?;
        let kept = *place.get_or_init(|| loaded);
        if kept != loaded {
            // Another thread was first.
            self.driver.unload(loaded);
        }
        Ok(kept)
    }
}

/// Has the driver assemble kernels. The context must be entered.
fn load(driver: &Driver, text: &str) -> Result<Module, Failure> {
    let text = CStr::from_bytes_with_nul(text.as_bytes()).map_err(|_| {
        Failure::new(
            ELLGRAN_GPU_ERROR_ASSEMBLER,
            "the text of a module of kernels holds a NUL",
        )
    })?;
    driver.load(text)
}

fn check_generation(driver: &Driver, device: i32) -> Result<(), Failure> {
    let version = driver.version();
    if version < LEAST_DRIVER {
        return Err(Failure::new(
            ELLGRAN_GPU_ERROR_OLD_DRIVER,
            format!(
                "NVIDIA's driver is of CUDA {}.{}, and the kernels need one of CUDA {}.{} or later: install a newer driver",
                version / 1000,
                version % 1000 / 10,
                LEAST_DRIVER / 1000,
                LEAST_DRIVER % 1000 / 10
            ),
        ));
    }
    let target = target()
        .ok_or_else(|| Failure::new(ELLGRAN_GPU_ERROR_ASSEMBLER, "ellgran.ptx names no target"))?;
    let generation = driver.generation(device)?;
    if generation < target {
        return Err(Failure::new(
            ELLGRAN_GPU_ERROR_OLD_DEVICE,
            format!(
                "{} is of generation sm_{generation}, and the kernels are for sm_{target} (Volta) and later: use a newer GPU",
                driver.name(device)?
            ),
        ));
    }
    Ok(())
}

impl Drop for Device {
    fn drop(&mut self) {
        // Where the context is lost, so is the module.
        if let Ok(_entered) = self.enter() {
            for module in self.modules.iter().filter_map(OnceLock::get) {
                self.driver.unload(*module);
            }
        }
        if let Some(device) = self.retained {
            self.driver.release(device);
        }
    }
}

/// An array on the device, as its host knows it: what the kernels take as a pointer and a length.
#[repr(C)]
pub struct Array<T> {
    address: u64,
    length: u64,
    of: PhantomData<fn() -> T>,
}

impl<T> Clone for Array<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Array<T> {}

impl<T> Array<T> {
    /// No elements.
    pub const EMPTY: Array<T> = Array {
        address: 0,
        length: 0,
        of: PhantomData,
    };

    /// So many elements from an address on; none where there is no address.
    pub fn at(address: u64, length: usize) -> Self {
        if address == 0 {
            return Array::EMPTY;
        }
        Array {
            address,
            length: length as u64,
            of: PhantomData,
        }
    }
}

/// Vectors of `N` numbers on the device, as their host knows them: what the kernels take as a pointer, two distances and a number of
/// vectors.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct VectorArray<const N: usize> {
    address: u64,
    per_grain: u64,
    per_component: u64,
    count: u64,
}

impl<const N: usize> VectorArray<N> {
    /// So many vectors from an address on, at these distances in numbers; both 0: one vector after the other.
    pub fn at(address: u64, per_grain: usize, per_component: usize, count: usize) -> Self {
        let (per_grain, per_component) = match (per_grain, per_component) {
            (0, 0) => (N, 1),
            stated => stated,
        };
        VectorArray {
            address,
            per_grain: per_grain as u64,
            per_component: per_component as u64,
            count: count as u64,
        }
    }

    /// Where a component of a vector is.
    pub fn place(&self, vector: usize, component: usize) -> u64 {
        let at = vector as u64 * self.per_grain + component as u64 * self.per_component;
        self.address + at * size_of::<f64>() as u64
    }
}

/// The memory of a device, on its host.
pub struct OnDevice;

impl Memory for OnDevice {
    type Shared<T> = Array<T>;
    type Parts<T> = Array<T>;
    type SharedVectors<const N: usize> = VectorArray<N>;
    type OwnVectors<const N: usize> = VectorArray<N>;
}

/// Memory on the device that is owned here.
pub struct Buffer<T> {
    device: Arc<Device>,
    address: u64,
    capacity: usize,
    length: usize,
    of: PhantomData<fn() -> T>,
}

impl<T> Buffer<T> {
    /// None yet.
    pub fn new(device: &Arc<Device>) -> Self {
        Buffer {
            device: Arc::clone(device),
            address: 0,
            capacity: 0,
            length: 0,
            of: PhantomData,
        }
    }

    /// Room for so many elements. What was in it is lost where it grows; new room has a quarter more than was asked for.
    ///
    /// # Errors
    /// Too little memory: the buffer is then empty.
    pub fn resize(&mut self, length: usize) -> Result<(), Failure> {
        if length > self.capacity {
            self.release();
            // Where a quarter more is not to be had, what is needed is.
            let wanted = length + length / 4;
            let size = size_of::<T>();
            (self.address, self.capacity) = match self.device.driver.allocate(wanted * size) {
                Ok(address) => (address, wanted),
                Err(_) => (self.device.driver.allocate(length * size)?, length),
            };
        }
        self.length = length;
        Ok(())
    }

    /// The same without more room than was asked for.
    ///
    /// # Errors
    /// Too little memory: the buffer is then empty.
    pub fn resize_exactly(&mut self, length: usize) -> Result<(), Failure> {
        if length > self.capacity {
            self.release();
            let bytes = length * size_of::<T>();
            (self.address, self.capacity) = (self.device.driver.allocate(bytes)?, length);
        }
        self.length = length;
        Ok(())
    }

    fn release(&mut self) {
        if self.address != 0 {
            self.device.driver.free(self.address);
        }
        (self.address, self.capacity, self.length) = (0, 0, 0);
    }

    /// All of it, for a kernel.
    pub fn all(&self) -> Array<T> {
        Array::at(self.address, self.length)
    }

    /// All of it as elements of another type that takes the same bytes.
    pub fn all_as<U>(&self) -> Array<U> {
        const {
            assert!(size_of::<T>() == size_of::<U>() && align_of::<T>() == align_of::<U>());
        }
        Array::at(self.address, self.length)
    }

    /// Where it begins on the device.
    pub fn address(&self) -> u64 {
        self.address
    }

    /// How many elements there are.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.capacity * size_of::<T>()
    }

    /// Fills it with zeros.
    ///
    /// # Errors
    /// Of the driver.
    pub fn clear(&self, stream: Stream) -> Result<(), Failure> {
        const { assert!(size_of::<T>().is_multiple_of(4)) }
        let words = self.length * (size_of::<T>() / 4);
        self.device.driver.clear(self.address, words, stream)
    }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        if self.address != 0 {
            let device = Arc::clone(&self.device);
            // Where the context is lost, so is the memory.
            if let Ok(_entered) = device.enter() {
                self.release();
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_name_their_generation() {
        assert_eq!(target(), Some(70));
    }
}
