// SPDX-License-Identifier: MIT OR Apache-2.0
//! The memory of a device that is none, and how the kernels' entries see it: as on a device, with every address looked up.

#![allow(unsafe_code)]

use crate::settings;
use core::marker::PhantomData;
use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};
use ellgran_kernels::arguments::Memory;
use std::alloc::{alloc, dealloc, Layout};
use std::collections::BTreeMap;
use std::panic::panic_any;
use std::sync::{PoisonError, RwLock};

/// The first address, which no memory of the host has.
const FIRST: u64 = 0x4000_0000_0000_0000;
/// Of each allocation, as on a device.
const ALIGNMENT: usize = 256;
/// Addresses between two allocations that belong to none.
const GAP: u64 = 4096;

struct Block {
    bytes: usize,
    layout: Layout,
    host: *mut u8,
}

// SAFETY: the pointer is to memory that the block owns.
unsafe impl Send for Block {}
// SAFETY: as above; what is written there is ordered by the callers of the driver.
unsafe impl Sync for Block {}

struct Blocks {
    by_address: BTreeMap<u64, Block>,
    next: u64,
    taken: usize,
}

static BLOCKS: RwLock<Blocks> = RwLock::new(Blocks {
    by_address: BTreeMap::new(),
    next: FIRST,
    taken: 0,
});

/// A kernel has been given, or has made, an address of something else.
pub struct IllegalAddress(pub String);

/// Memory, if there is so much left.
pub fn allocate(bytes: usize) -> Option<u64> {
    let mut blocks = BLOCKS.write().unwrap_or_else(PoisonError::into_inner);
    if blocks.taken + bytes > settings::memory() {
        return None;
    }
    let layout = Layout::from_size_align(bytes, ALIGNMENT).ok()?;
    // SAFETY: the driver's function has refused 0 bytes.
    let host = unsafe { alloc(layout) };
    if host.is_null() {
        return None;
    }
    // SAFETY: just allocated, so long.
    unsafe { host.write_bytes(0xff, bytes) };
    let address = blocks.next;
    blocks.next = (address + bytes as u64 + GAP).next_multiple_of(ALIGNMENT as u64);
    blocks.taken += bytes;
    let block = Block {
        bytes,
        layout,
        host,
    };
    blocks.by_address.insert(address, block);
    Some(address)
}

/// Gives back what an allocation took; whether there was one.
pub fn free(address: u64) -> bool {
    let mut blocks = BLOCKS.write().unwrap_or_else(PoisonError::into_inner);
    let Some(block) = blocks.by_address.remove(&address) else {
        return false;
    };
    blocks.taken -= block.bytes;
    // SAFETY: allocated with this layout, and known to nobody any more.
    unsafe { dealloc(block.host, block.layout) };
    true
}

/// Bytes that are free.
pub fn left() -> usize {
    let blocks = BLOCKS.read().unwrap_or_else(PoisonError::into_inner);
    settings::memory().saturating_sub(blocks.taken)
}

/// Where so many bytes are on the host, if one allocation holds all of them.
pub fn on_host(address: u64, bytes: usize) -> Option<*mut u8> {
    let blocks = BLOCKS.read().unwrap_or_else(PoisonError::into_inner);
    let (first, block) = blocks.by_address.range(..=address).next_back()?;
    let offset = usize::try_from(address - first).ok()?;
    let end = offset.checked_add(bytes)?;
    if end > block.bytes || offset >= block.bytes {
        return None;
    }
    // SAFETY: within the block.
    Some(unsafe { block.host.add(offset) })
}

fn elements<T>(start: u64, length: usize) -> *mut T {
    let bytes = length.checked_mul(size_of::<T>());
    let found = bytes.and_then(|bytes| on_host(start, bytes));
    let aligned = start.is_multiple_of(align_of::<T>() as u64);
    match found {
        Some(host) if aligned => host.cast(),
        _ => panic_any(IllegalAddress(format!(
            "{length} elements of {} at {start:#x}",
            std::any::type_name::<T>()
        ))),
    }
}

/// The memory of the stand-in, as its kernels see it.
pub struct Here;

impl Memory for Here {
    type Shared<T> = Shared<T>;
    type Parts<T> = Parts<T>;
    type SharedVectors<const N: usize> = SharedVectors<N>;
    type OwnVectors<const N: usize> = OwnVectors<N>;
}

/// An array that all threads read.
#[repr(C)]
pub struct Shared<T> {
    start: u64,
    length: u64,
    of: PhantomData<fn() -> T>,
}

impl<T> Shared<T> {
    /// All of it.
    pub fn all(&self) -> &[T] {
        if self.length == 0 {
            return &[];
        }
        let length = self.length as usize;
        let start = elements::<T>(self.start, length);
        // SAFETY: so many are there, aligned; nothing writes to them while this thread of the kernel runs, and no other thread runs.
        unsafe { core::slice::from_raw_parts(start, length) }
    }
}

/// Vectors that all threads read.
pub type SharedVectors<const N: usize> = Vectors<N>;
/// Vectors of which each thread has some, or some components.
pub type OwnVectors<const N: usize> = Vectors<N>;

/// Vectors at distances that the caller has stated.
#[repr(C)]
pub struct Vectors<const N: usize> {
    first: u64,
    per_grain: u64,
    per_component: u64,
    count: u64,
}

impl<const N: usize> Vectors<N> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// The components of vector `k`, of which the first is at the first place and the others `per_component` apart.
    fn place(&self, k: usize) -> *mut f64 {
        assert!((k as u64) < self.count);
        let (from, step) = (k * self.per_grain as usize, self.per_component as usize);
        let start = self.first + (from * size_of::<f64>()) as u64;
        elements::<f64>(start, (N - 1) * step + 1)
    }

    /// Vector `k`.
    pub fn get(&self, k: usize) -> [f64; N] {
        let first = self.place(k);
        // SAFETY: all from the first component to the last is there; no other thread runs.
        core::array::from_fn(|c| unsafe { first.add(c * self.per_component as usize).read() })
    }

    /// Component `c` of vector `k`.
    pub fn component_of(&self, k: usize, c: usize) -> f64 {
        self.get(k)[c]
    }

    /// The vector that goes with a number of this thread.
    pub fn read(&mut self, own: &Own) -> [f64; N] {
        self.get(own.number)
    }

    /// Writes it.
    pub fn write(&mut self, own: &Own, vector: [f64; N]) {
        let first = self.place(own.number);
        for (c, value) in vector.into_iter().enumerate() {
            // SAFETY: as above.
            unsafe { first.add(c * self.per_component as usize).write(value) };
        }
    }

    /// The one component of this thread.
    pub fn component<'t>(&'t mut self, own: &'t OwnComponent) -> &'t mut f64 {
        assert!(own.component < N);
        let first = self.place(own.vector);
        // SAFETY: as above, and borrowed once.
        unsafe { &mut *first.add(own.component * self.per_component as usize) }
    }
}

/// An array of which each thread has a part.
#[repr(C)]
pub struct Parts<T> {
    start: u64,
    length: u64,
    of: PhantomData<fn() -> T>,
}

/// A thread.
pub struct Thread {
    own: Own,
    count: usize,
}

impl Deref for Thread {
    type Target = Own;

    fn deref(&self) -> &Own {
        &self.own
    }
}

/// A number that one thread alone has.
pub struct Own {
    number: usize,
}

impl Own {
    /// The number itself.
    pub fn number(&self) -> usize {
        self.number
    }
    /// What a table has for it.
    pub fn within(&self, table: impl FnOnce(usize) -> u32) -> Own {
        Own {
            number: table(self.number) as usize,
        }
    }
}

/// A component of a vector, of which one thread alone has the two numbers.
pub struct OwnComponent {
    vector: usize,
    component: usize,
}

impl OwnComponent {
    /// The vector's number.
    pub fn vector(&self) -> usize {
        self.vector
    }
    /// The component's number.
    pub fn component(&self) -> usize {
        self.component
    }
    /// Of vectors that have the components from `first` on.
    pub fn from(&self, first: usize) -> OwnComponent {
        OwnComponent {
            component: self.component - first,
            ..*self
        }
    }
}

impl Thread {
    pub fn new(index: usize, count: u32) -> Self {
        Thread {
            own: Own { number: index },
            count: count as usize,
        }
    }
    /// Its component, where each vector has `each` of them and each thread one.
    pub fn component_of(&self, each: usize) -> OwnComponent {
        OwnComponent {
            vector: self.index() / each,
            component: self.index() % each,
        }
    }
    /// The numbers below `end` that fall to this thread.
    pub fn numbers(&self, end: usize) -> impl Iterator<Item = Own> {
        (self.index()..end)
            .step_by(self.count)
            .map(|number| Own { number })
    }
    /// Its index, counted over all blocks.
    pub fn index(&self) -> usize {
        self.own.number
    }
}

impl<T> Parts<T> {
    /// Whether the array has no elements.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// How many elements it has.
    pub fn len(&self) -> usize {
        self.length as usize
    }

    /// The row that goes with a number of this thread.
    pub fn row<'t>(&'t mut self, own: &'t Own, starts: &[u32], each: usize) -> &'t mut [T] {
        let k = own.number;
        let (from, to) = (starts[k] as usize, starts[k + 1] as usize);
        assert!(from <= to);
        self.between(from * each, (to - from) * each)
    }

    /// The part that goes with a number of this thread, of an array that has up to `each` elements for each number, for the last fewer.
    pub fn chunk<'t>(&'t mut self, own: &'t Own, each: usize) -> &'t mut [T] {
        let from = own.number * each;
        let count = (self.length as usize).saturating_sub(from).min(each);
        self.between(from, count)
    }

    /// The part that goes with a number of this thread, of an array in which each number has a range of its own.
    pub fn range<'t>(&'t mut self, own: &'t Own, firsts: &[u32], counts: &[u32]) -> &'t mut [T] {
        let k = own.number;
        self.between(firsts[k] as usize, counts[k] as usize)
    }

    /// The part that goes with a number of this thread.
    pub fn part<'t>(&'t mut self, own: &'t Own, each: usize) -> &'t mut [T] {
        self.between(own.number * each, each)
    }

    /// The one element that goes with a number of this thread.
    pub fn at<'t>(&'t mut self, own: &'t Own) -> &'t mut T {
        &mut self.part(own, 1)[0]
    }

    /// The next elements that no thread has taken yet.
    pub fn taken(&mut self, counter: &AtomicU32, count: usize) -> (usize, &mut [T]) {
        let from = counter.fetch_add(count as u32, Ordering::Relaxed) as usize;
        (from, self.between(from, count))
    }

    fn between(&mut self, from: usize, count: usize) -> &mut [T] {
        assert!(from + count <= self.length as usize);
        if count == 0 {
            return &mut [];
        }
        let start = elements::<T>(self.start, self.length as usize);
        // SAFETY: these are there, aligned, and borrowed once: by this array, while no other thread runs.
        unsafe { core::slice::from_raw_parts_mut(start.add(from), count) }
    }
}

/// A kernel on the host.
pub struct HostEntry {
    /// Size and alignment of its parameters.
    pub parameters: [(usize, usize); 2],
    /// Its thread: index, number of grains, arguments.
    pub run: unsafe fn(usize, u32, *const u8),
}

/// Before the name of each kernel among what this library exports: the library of the host has functions of the same names.
macro_rules! entries {
    ($($(#[$about:meta])* fn $name:ident($thread:ident, $argument:ident: $type:ty $(,)?) $body:block)*) => {$(
        $(#[$about])*
        // SAFETY: no other library has names with this beginning.
        #[allow(unsafe_code, non_upper_case_globals)]
        #[export_name = concat!("ellgran_stand_in_entry_", stringify!($name))]
        pub static $name: $crate::memory::HostEntry = $crate::memory::HostEntry {
            parameters: [(4, 4), (size_of::<$type>(), align_of::<$type>())],
            run: {
                #[allow(unused_mut)]
                unsafe fn run(index: usize, count: u32, arguments: *const u8) {
                    let $thread = $crate::memory::Thread::new(index, count);
                    if $thread.index() < count as usize {
                        // SAFETY: `modules` gives a pointer to arguments of this size and alignment, which are numbers.
                        let $argument: $type = unsafe { arguments.cast::<$type>().read() };
                        $body
                    }
                }
                run
            },
        };
    )*};
}
pub(crate) use entries;
