// SPDX-License-Identifier: MIT OR Apache-2.0
//! Large memory in large pages, where the system leaves the choice to the program: a step goes through all of it, and each
//! small page costs a look at the page tables.

/// Asks for large pages in `bytes` bytes of memory that were just allocated. No more than advice: nothing happens where
/// there is not a whole large page, or no such advice.
#[cfg(all(target_os = "linux", not(miri)))]
pub(super) fn advise(memory: *const u8, bytes: usize) {
    /// On x86-64, and on AArch64 with small pages of 4 KiB; of others less memory is advised than could be.
    const LARGE: usize = 2 << 20;
    let skipped = memory.align_offset(LARGE);
    let Some(inside) = bytes.checked_sub(skipped) else {
        return;
    };
    let length = inside / LARGE * LARGE;
    if length > 0 {
        // SAFETY: whole pages within an allocation that the caller owns; the advice changes no contents.
        unsafe {
            libc::madvise(
                memory.add(skipped).cast_mut().cast(),
                length,
                libc::MADV_HUGEPAGE,
            );
        }
    }
}

#[cfg(not(all(target_os = "linux", not(miri))))]
pub(super) fn advise(_: *const u8, _: usize) {}
