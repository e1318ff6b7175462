// SPDX-License-Identifier: MIT OR Apache-2.0
//! Structs that may grow: how a library and a program of different versions read each other's.
//!
//! Every struct of the interface begins with `size`, which the caller sets to its `sizeof` (`ELLGRAN_INIT` of the header
//! does). Fields are only ever added, at the end and where no earlier struct had padding, and zero is the value of a field
//! that is not given. So
//! - a shorter struct, of an older header, is read as if its missing fields were zero, and written as far as it goes;
//! - a longer struct, of a newer header, is read if the fields that this library does not know are zero, and written as
//!   far as this library knows it;
//! - in an array the size of the first element is the distance from one to the next.

use super::status::{required, required_mut, Failure, ELLGRAN_ERROR_ARGUMENT};
use core::fmt::Display;
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ops::Deref;

/// A struct that begins with its size.
///
/// # Safety
/// The struct is `repr(C)`, its first field is a `usize`, it ends in no padding, and zeros are a value of every field.
pub unsafe trait Growing: Copy {
    /// What to call it in a message.
    const NAME: &'static str;
    /// Size of its first version: no header has had a smaller one.
    const FIRST_SIZE: usize;
}

/// `growing!(EllgranBody)` for a struct whose first version this is; `growing!(EllgranLawParameters, tangential_damping)` for
/// one whose first version ended with this field.
macro_rules! growing {
    ($name:ident) => {
        const _: () = assert!(core::mem::offset_of!($name, size) == 0);
        // SAFETY: `size` is the first field; the layout test of the header holds that none ends in padding; all fields are
        // numbers and pointers.
        unsafe impl crate::c_api::growing::Growing for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = size_of::<$name>();
        }
    };
    // The last field of the first version is a double.
    ($name:ident, $last:ident) => {
        growing!($name, $last: f64);
    };
    // The last field of the first version is of this type.
    ($name:ident, $last:ident: $type:ty) => {
        const _: () = assert!(core::mem::offset_of!($name, size) == 0);
        // SAFETY: as above.
        unsafe impl crate::c_api::growing::Growing for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = core::mem::offset_of!($name, $last) + size_of::<$type>();
        }
    };
}
pub(super) use growing;

/// A struct that the caller gave.
#[doc(hidden)]
pub enum Given<'a, T> {
    /// His own.
    Whole(&'a T),
    /// Of an older header: the missing fields are zero.
    Older(T),
}

impl<T> Deref for Given<'_, T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        match self {
            Given::Whole(given) => given,
            Given::Older(filled) => filled,
        }
    }
}

/// What no struct of a later version will exceed: a greater size is memory that was never set.
const GROWTH: usize = 4096;

#[cold]
fn not_set<T: Growing>(size: usize, name: &dyn Display) -> Failure {
    Failure::new(
        ELLGRAN_ERROR_ARGUMENT,
        format!(
            "{name}: size = {size} is not set to the size of its struct: start from ELLGRAN_INIT({})",
            T::NAME
        ),
    )
}

fn check<T: Growing>(size: usize, name: &dyn Display) -> Result<(), Failure> {
    let possible = T::FIRST_SIZE..=size_of::<T>() + GROWTH;
    if possible.contains(&size) && size.is_multiple_of(align_of::<T>()) {
        Ok(())
    } else {
        Err(not_set::<T>(size, name))
    }
}

/// Reads a struct of which the size is `size`.
///
/// # Safety
/// `pointer` is valid for reads of `size` bytes for the lifetime that the caller gives it, if `size` is a possible one.
#[inline]
unsafe fn read<'a, T: Growing>(
    pointer: *const T,
    size: usize,
    name: &dyn Display,
) -> Result<Given<'a, T>, Failure> {
    let known = size_of::<T>();
    if size != known {
        check::<T>(size, name)?;
    }
    if size < known {
        let mut filled = MaybeUninit::<T>::zeroed();
        // SAFETY: promised by the caller; zeros are a value of the fields that are not copied.
        return Ok(Given::Older(unsafe {
            core::ptr::copy_nonoverlapping(pointer.cast::<u8>(), filled.as_mut_ptr().cast(), size);
            filled.assume_init()
        }));
    }
    // SAFETY: promised by the caller: there are `size` bytes.
    let unknown =
        unsafe { core::slice::from_raw_parts(pointer.cast::<u8>().add(known), size - known) };
    if unknown.iter().any(|byte| *byte != 0) {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "{name} sets fields of a newer {} ({size} bytes) than this library knows ({known} bytes): link the library \
                 of that ellgran.h, or leave them zero",
                T::NAME
            ),
        ));
    }
    // SAFETY: promised by the caller: at least a whole T is there.
    Ok(Given::Whole(unsafe { &*pointer }))
}

/// A struct that must be given.
///
/// # Safety
/// `pointer` is NULL or valid for reads of as many bytes as the struct's size says, for the lifetime that the caller gives
/// it.
#[doc(hidden)]
#[inline]
pub unsafe fn given<'a, T: Growing>(
    pointer: *const T,
    name: &str,
) -> Result<Given<'a, T>, Failure> {
    // SAFETY: promised by the caller; the size is the first field.
    unsafe {
        let size = *required(pointer.cast::<usize>(), name)?;
        read(pointer, size, &name)
    }
}

/// An array of structs.
pub(super) struct GivenArray<'a, T> {
    first: *const T,
    count: usize,
    size: usize,
    name: &'static str,
    lifetime: PhantomData<&'a T>,
}

impl<'a, T: Growing> GivenArray<'a, T> {
    /// # Safety
    /// `first` is NULL or valid for reads of `count` structs of the size that the first one says, for the lifetime that the
    /// caller gives it.
    pub(super) unsafe fn new(
        first: *const T,
        count: usize,
        name: &'static str,
    ) -> Result<Self, Failure> {
        let size = if count == 0 {
            0
        } else {
            // SAFETY: promised by the caller; the size is the first field.
            let size = *unsafe { required(first.cast::<usize>(), name) }?;
            check::<T>(size, &format_args!("{name}[0]"))?;
            size
        };
        Ok(GivenArray {
            first,
            count,
            size,
            name,
            lifetime: PhantomData,
        })
    }

    pub(super) fn get(&self, k: usize) -> Result<Given<'a, T>, Failure> {
        assert!(k < self.count);
        // SAFETY: promised when this was made: there are `count` structs of this size.
        unsafe {
            let pointer = self.first.byte_add(k * self.size);
            let size = *pointer.cast::<usize>();
            let name = format_args!("{}[{k}]", self.name);
            if size != self.size {
                return Err(not_set::<T>(size, &name));
            }
            read(pointer, size, &name)
        }
    }
}

/// A struct that the library writes, as far as the caller's header has it.
#[doc(hidden)]
pub struct Output<'a, T> {
    target: *mut T,
    size: usize,
    lifetime: PhantomData<&'a mut T>,
}

impl<T: Growing> Output<'_, T> {
    /// # Safety
    /// `target` is NULL or valid for reads and writes of as many bytes as the struct's size says, and not aliased, for the
    /// lifetime that the caller gives it.
    #[inline]
    pub unsafe fn new(target: *mut T, name: &str) -> Result<Self, Failure> {
        // SAFETY: promised by the caller; the size is the first field.
        let size = *unsafe { required_mut(target.cast::<usize>(), name) }?;
        if size != size_of::<T>() {
            check::<T>(size, &name)?;
        }
        Ok(Output {
            target,
            size,
            lifetime: PhantomData,
        })
    }

    /// The same where NULL means that it is not asked for.
    ///
    /// # Safety
    /// As for `new`.
    #[inline]
    pub(super) unsafe fn optional(target: *mut T, name: &str) -> Result<Option<Self>, Failure> {
        if target.is_null() {
            return Ok(None);
        }
        // SAFETY: promised by the caller.
        unsafe { Output::new(target, name) }.map(Some)
    }

    /// Writes all but the size, which stays the caller's.
    #[inline]
    pub fn write(&mut self, value: &T) {
        let first = size_of::<usize>();
        let end = self.size.min(size_of::<T>());
        // SAFETY: promised when this was made: the target has `size` bytes; they are copied as bytes, whatever they hold.
        unsafe {
            core::ptr::copy_nonoverlapping(
                core::ptr::from_ref(value)
                    .cast::<MaybeUninit<u8>>()
                    .add(first),
                self.target.cast::<MaybeUninit<u8>>().add(first),
                end - first,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::mem::offset_of;

    /// What an older header has of [`Now`].
    #[repr(C)]
    #[derive(Clone, Copy)]
    struct Before {
        size: usize,
        length: f64,
    }

    #[repr(C)]
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Now {
        size: usize,
        length: f64,
        added: f64,
    }

    // SAFETY: the size is first; numbers alone, without padding.
    unsafe impl Growing for Now {
        const NAME: &'static str = "Now";
        const FIRST_SIZE: usize = offset_of!(Now, added);
    }

    const OLDER: Before = Before {
        size: size_of::<Before>(),
        length: 3.0,
    };

    #[test]
    fn an_older_struct_lacks_what_was_added() {
        // SAFETY: as long as its size says.
        let read = unsafe { given(core::ptr::from_ref(&OLDER).cast::<Now>(), "x") };
        let read = read.expect("an older struct");
        assert_eq!((read.length, read.added), (3.0, 0.0));
    }

    #[test]
    fn an_older_struct_is_written_as_far_as_it_goes() {
        let mut two = [OLDER; 2];
        // SAFETY: as long as its size says.
        let output = unsafe { Output::new(two.as_mut_ptr().cast::<Now>(), "x") };
        output.expect("an older struct").write(&Now {
            size: 0,
            length: 5.0,
            added: 7.0,
        });
        assert_eq!((two[0].size, two[0].length), (OLDER.size, 5.0));
        assert_eq!((two[1].size, two[1].length), (OLDER.size, 3.0));
    }

    #[test]
    fn older_structs_in_an_array_are_as_far_apart_as_they_say() {
        let two = [
            OLDER,
            Before {
                length: 4.0,
                ..OLDER
            },
        ];
        // SAFETY: two of them, as long as the first says.
        let array = unsafe { GivenArray::new(two.as_ptr().cast::<Now>(), 2, "x") };
        let array = array.expect("an array");
        let second = array.get(1).expect("the second");
        assert_eq!((second.length, second.added), (4.0, 0.0));
    }

    #[test]
    fn a_size_between_two_versions_is_none() {
        let odd = Now {
            size: size_of::<Before>() + 1,
            length: 1.0,
            added: 0.0,
        };
        // SAFETY: longer than its size says.
        assert!(unsafe { given(&odd, "x") }.is_err());
    }
}
