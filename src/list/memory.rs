// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory that grows only when the number of particles or of pairs does, and of which the caller is told.

/// See [`Workspace::allocated`].
pub type Allocated = fn(*const u8, usize);

/// Room for `length` entries, of which the caller is told before it is touched.
pub(super) fn reserve<T>(vector: &mut Vec<T>, length: usize, allocated: Allocated) {
    let before = vector.capacity();
    vector.reserve(length.saturating_sub(vector.len()));
    if vector.capacity() != before {
        allocated(vector.as_ptr().cast(), vector.capacity() * size_of::<T>());
    }
}
