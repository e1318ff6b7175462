// SPDX-License-Identifier: MIT OR Apache-2.0
//! A device's memory as a kernel sees it: arrays that all threads read, and arrays of which each thread has a part of its own.
//!
//! What holds for every kernel, and is for its caller to see to:
//! - an array is as long as its length says, of values of its type, aligned, and there until the
//!   kernel ends; of vectors there are so many, at the distances that are stated, no two components at the same place;
//! - nothing writes to an array of the first kind while the kernel runs, unless it is of atomic numbers, and no array of the second
//!   kind overlaps with another array of the call;
//! - the grid has one dimension, so that no two threads have the same index, and as many threads work as the kernel is told;
//! - a table of which a thread takes a number for itself ([`Own::within`]) has each number once;
//! - no number is in two of the ranges by which threads divide an array ([`Parts::range`]);
//! - a counter by which threads divide an array ([`Parts::taken`]) serves that array alone, and began at 0.

#![allow(unsafe_code)]

use core::alloc::{GlobalAlloc, Layout};
use core::arch::nvptx;
use core::marker::PhantomData;
use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};
use ellgran_kernels::arguments::Memory;

/// The memory of a device, on the device.
pub struct Here;

impl Memory for Here {
    type Shared<T> = Shared<T>;
    type Parts<T> = Parts<T>;
    type SharedVectors<const N: usize> = SharedVectors<N>;
    type OwnVectors<const N: usize> = OwnVectors<N>;
}

/// An array that all threads read.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Shared<T> {
    start: *const T,
    length: u64,
}

impl<T> Shared<T> {
    /// All of it.
    #[inline(always)]
    pub fn all(&self) -> &[T] {
        if self.length == 0 {
            return &[];
        }
        // SAFETY: the array is there, as long as that, and not written while the kernel runs (above).
        unsafe { core::slice::from_raw_parts(self.start, self.length as usize) }
    }
}

/// Vectors that all threads read: component `c` of vector `k` is `first[k * per_grain + c * per_component]`.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct SharedVectors<const N: usize> {
    first: *const f64,
    per_grain: u64,
    per_component: u64,
    count: u64,
}

impl<const N: usize> SharedVectors<N> {
    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count as usize
    }

    /// Vector `k`.
    #[inline(always)]
    pub fn get(&self, k: usize) -> [f64; N] {
        assert!((k as u64) < self.count);
        let (from, step) = (k * self.per_grain as usize, self.per_component as usize);
        // SAFETY: there are so many (just asserted), at these distances, and nothing writes to them while the kernel runs (above).
        core::array::from_fn(|c| unsafe { *self.first.add(from + c * step) })
    }

    /// Component `c` of vector `k`.
    #[inline(always)]
    pub fn component_of(&self, k: usize, c: usize) -> f64 {
        assert!((k as u64) < self.count && c < N);
        let at = k * self.per_grain as usize + c * self.per_component as usize;
        // SAFETY: as above.
        unsafe { *self.first.add(at) }
    }
}

/// Vectors of which each thread has some, or some components.
#[repr(C)]
pub struct OwnVectors<const N: usize> {
    first: *mut f64,
    per_grain: u64,
    per_component: u64,
    count: u64,
}

impl<const N: usize> OwnVectors<N> {
    /// A component of a vector, by their numbers: of a pair of numbers that this thread alone has.
    #[inline(always)]
    fn place(&mut self, k: usize, c: usize) -> &mut f64 {
        assert!((k as u64) < self.count && c < N);
        let at = k * self.per_grain as usize + c * self.per_component as usize;
        // SAFETY: it is there (just asserted), no two components are at the same place, and no other thread has this one: a kernel
        // takes vectors by numbers that one thread alone has, or components by such pairs of numbers. This thread has it once: the
        // vectors are borrowed for as long.
        unsafe { &mut *self.first.add(at) }
    }

    /// The vector that goes with a number of this thread.
    #[inline(always)]
    pub fn read(&mut self, own: &Own) -> [f64; N] {
        core::array::from_fn(|c| *self.place(own.number, c))
    }

    /// Writes it.
    #[inline(always)]
    pub fn write(&mut self, own: &Own, vector: [f64; N]) {
        // By value: what goes through an iterator of its own would be kept in memory.
        for (c, value) in vector.iter().enumerate() {
            *self.place(own.number, c) = *value;
        }
    }

    /// The one component of this thread.
    #[inline(always)]
    pub fn component<'t>(&'t mut self, own: &'t OwnComponent) -> &'t mut f64 {
        self.place(own.vector, own.component)
    }
}

/// An array of which each thread has a part.
#[repr(C)]
pub struct Parts<T> {
    start: *mut T,
    length: u64,
}

/// This thread, of which there is one: it cannot be made elsewhere, nor copied. Its index is a number of its own; what a thread owns of an
/// array is what it names with it.
pub struct Thread {
    own: Own,
    /// How many work.
    count: usize,
}

impl Deref for Thread {
    type Target = Own;

    #[inline(always)]
    fn deref(&self) -> &Own {
        &self.own
    }
}

/// A number that this thread alone has.
pub struct Own {
    number: usize,
    /// Not to be sent.
    here: PhantomData<*mut ()>,
}

impl Own {
    /// The number itself.
    #[inline(always)]
    pub fn number(&self) -> usize {
        self.number
    }

    /// What a table has for it; no other number has the same there.
    #[inline(always)]
    pub fn within(&self, table: impl FnOnce(usize) -> u32) -> Own {
        Own {
            number: table(self.number) as usize,
            here: PhantomData,
        }
    }
}

/// A component of a vector, of which this thread alone has the two numbers.
pub struct OwnComponent {
    vector: usize,
    component: usize,
    /// Not to be sent.
    here: PhantomData<*mut ()>,
}

impl OwnComponent {
    /// The vector's number.
    #[inline(always)]
    pub fn vector(&self) -> usize {
        self.vector
    }

    /// The component's number.
    #[inline(always)]
    pub fn component(&self) -> usize {
        self.component
    }

    /// Of vectors that have the components from `first` on.
    #[inline(always)]
    pub fn from(&self, first: usize) -> OwnComponent {
        OwnComponent {
            component: self.component - first,
            ..*self
        }
    }
}

/// This thread, of `count` that work.
#[inline(always)]
pub fn thread(count: u32) -> Thread {
    // SAFETY: these read registers that every thread has.
    let index = unsafe {
        nvptx::_block_idx_x() as u32 as usize * nvptx::_block_dim_x() as u32 as usize
            + nvptx::_thread_idx_x() as u32 as usize
    };
    Thread {
        own: Own {
            number: index,
            here: PhantomData,
        },
        count: count as usize,
    }
}

impl Thread {
    /// Its index, counted over all blocks.
    #[inline(always)]
    pub fn index(&self) -> usize {
        self.own.number
    }

    /// Its component, where each vector has `each` of them and each thread one.
    #[inline(always)]
    pub fn component_of(&self, each: usize) -> OwnComponent {
        OwnComponent {
            vector: self.index() / each,
            component: self.index() % each,
            here: PhantomData,
        }
    }

    /// The numbers below `end` that fall to this thread, each to one of those that work.
    #[inline(always)]
    pub fn numbers(&self, end: usize) -> impl Iterator<Item = Own> {
        (self.index()..end).step_by(self.count).map(|number| Own {
            number,
            here: PhantomData,
        })
    }
}

impl<T> Parts<T> {
    /// Whether the array has no elements.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// How many elements it has.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.length as usize
    }

    /// The row that goes with a number of this thread: `starts[k]` up to `starts[k + 1]` is row `k`, of `each` elements a place.
    #[inline(always)]
    pub fn row<'t>(&'t mut self, own: &'t Own, starts: &[u32], each: usize) -> &'t mut [T] {
        let k = own.number;
        let (from, to) = (starts[k] as usize, starts[k + 1] as usize);
        // Rows that do not follow each other would be two threads'.
        assert!(from <= to);
        self.between(from * each, (to - from) * each)
    }

    /// The part that goes with a number of this thread, of an array that has up to `each` elements for each number, for the last fewer.
    #[inline(always)]
    pub fn chunk<'t>(&'t mut self, own: &'t Own, each: usize) -> &'t mut [T] {
        let from = own.number * each;
        let count = (self.length as usize).saturating_sub(from).min(each);
        self.between(from, count)
    }

    /// The part that goes with a number of this thread, of an array in which each number has a range of its own.
    #[inline(always)]
    pub fn range<'t>(
        &'t mut self,
        own: &'t Own,
        firsts: &[u32],
        counts: &[u32],
    ) -> &'t mut [T] {
        let k = own.number;
        self.between(firsts[k] as usize, counts[k] as usize)
    }

    /// The part that goes with a number of this thread, `each` elements for each number.
    #[inline(always)]
    pub fn part<'t>(&'t mut self, own: &'t Own, each: usize) -> &'t mut [T] {
        self.between(own.number * each, each)
    }

    /// The one element that goes with a number of this thread.
    #[inline(always)]
    pub fn at<'t>(&'t mut self, own: &'t Own) -> &'t mut T {
        &mut self.part(own, 1)[0]
    }

    /// The next `count` elements that no thread has taken yet, by a counter of all threads: where they begin, and these.
    #[inline(always)]
    pub fn taken(&mut self, counter: &AtomicU32, count: usize) -> (usize, &mut [T]) {
        let from = counter.fetch_add(count as u32, Ordering::Relaxed) as usize;
        (from, self.between(from, count))
    }

    #[inline(always)]
    fn between(&mut self, from: usize, count: usize) -> &mut [T] {
        assert!(from + count <= self.length as usize);
        if count == 0 {
            return &mut [];
        }
        // SAFETY: these elements are there, and within this array (just asserted). No other thread has one of them: a kernel
        // divides an array in one way, so that parts are of one length and told apart by the threads' indices or by numbers that
        // one thread alone has, rows begin where the row before ends, ranges have no number in common, and neither do the elements that a
        // counter has handed out. This
        // thread has them once: the array is borrowed for as long.
        unsafe { core::slice::from_raw_parts_mut(self.start.add(from), count) }
    }
}

/// The library's messages and tables are on the heap. Kernels make none of them.
struct NoHeap;

// SAFETY: no memory is ever handed out.
unsafe impl GlobalAlloc for NoHeap {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }
    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static HEAP: NoHeap = NoHeap;

/// An index out of range ends the kernel with an error for the host.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it ends the kernel.
    unsafe { nvptx::trap() }
}

/// Entries of the module, by their names: nothing else has these names.
macro_rules! entries {
    ($($(#[$about:meta])* fn $name:ident($thread:ident $(, $argument:ident: $type:ty)* $(,)?) $body:block)*) => {$(
        $(#[$about])*
        // SAFETY: the name begins with that of the library, and is given once.
        #[allow(unsafe_code)]
        #[unsafe(no_mangle)]
        pub extern "ptx-kernel" fn $name(count: u32, $($argument: $type),*) {
            let $thread = $crate::memory::thread(count);
            // The last block may have more threads than there are grains left.
            if $thread.index() < count as usize {
                $body
            }
        }
    )*};
}
pub(crate) use entries;
