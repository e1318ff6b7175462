// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists of a search: on the heap, as long as is needed, or in room that is lent, as on a device, where memory is set aside before.
//!
//! What does not fit into such room is left out, and the list says so: what was found with it counts for nothing.

#[cfg(not(feature = "std"))]
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::{Deref, DerefMut};

/// Where lists are. Public for the kernels in `gpu/`; no interface for others.
#[doc(hidden)]
pub trait Lists: Sized {
    /// A list there.
    type List<T: Copy + Debug + 'static>: List<T>;
    /// Boxes in a node of a tree that is not divided.
    const LEAF: usize;
}

/// What a search does with a list beside reading it as a slice.
#[doc(hidden)]
pub trait List<T: Copy>: DerefMut<Target = [T]> {
    /// Whether something did not fit.
    fn lacks_room(&self) -> bool;
    /// Takes out all.
    fn clear(&mut self);
    /// One more at the end.
    fn push(&mut self, element: T);
    /// Keeps so many.
    fn truncate(&mut self, length: usize);
    /// Keeps those that are so.
    fn retain(&mut self, is_kept: impl FnMut(&T) -> bool);
    /// Brings all into an order; of equal ones either may come first.
    fn sort_with(&mut self, order: impl FnMut(&T, &T) -> Ordering);

    /// Several more at the end.
    #[inline(always)]
    fn add_all(&mut self, elements: impl IntoIterator<Item = T>) {
        elements.into_iter().for_each(|element| self.push(element));
    }

    /// So many of them, all equal.
    #[inline(always)]
    fn set_all(&mut self, count: usize, element: T) {
        self.clear();
        self.add_all(core::iter::repeat_n(element, count));
    }

    /// Brings all into their ascending order.
    #[inline(always)]
    fn sort(&mut self)
    where
        T: Ord,
    {
        self.sort_with(T::cmp);
    }

    /// Keeps one of those that follow each other and are equal.
    #[inline(always)]
    fn dedup(&mut self)
    where
        T: PartialEq,
    {
        let mut last = None;
        self.retain(|element| last.replace(*element) != Some(*element));
    }
}

/// Lists on the heap.
#[derive(Clone, Copy, Debug, Default)]
pub struct OnHeap;

impl Lists for OnHeap {
    type List<T: Copy + Debug + 'static> = Vec<T>;
    /// To test so few boxes costs about as much as to go down one level more.
    const LEAF: usize = 4;
}

impl<T: Copy> List<T> for Vec<T> {
    #[inline(always)]
    fn lacks_room(&self) -> bool {
        false
    }
    #[inline(always)]
    fn clear(&mut self) {
        Vec::clear(self);
    }
    #[inline(always)]
    fn push(&mut self, element: T) {
        Vec::push(self, element);
    }
    #[inline(always)]
    fn truncate(&mut self, length: usize) {
        Vec::truncate(self, length);
    }
    #[inline(always)]
    fn retain(&mut self, is_kept: impl FnMut(&T) -> bool) {
        Vec::retain(self, is_kept);
    }
    #[inline(always)]
    fn sort_with(&mut self, order: impl FnMut(&T, &T) -> Ordering) {
        self.sort_unstable_by(order);
    }
    #[inline(always)]
    fn add_all(&mut self, elements: impl IntoIterator<Item = T>) {
        Extend::extend(self, elements);
    }
    #[inline(always)]
    fn set_all(&mut self, count: usize, element: T) {
        Vec::clear(self);
        self.resize(count, element);
    }
    #[inline(always)]
    fn sort(&mut self)
    where
        T: Ord,
    {
        self.sort_unstable();
    }
    #[inline(always)]
    fn dedup(&mut self)
    where
        T: PartialEq,
    {
        Vec::dedup(self);
    }
}

/// Lists in room that is lent for as long.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct InRoom<'m>(PhantomData<&'m mut ()>);

impl<'m> Lists for InRoom<'m> {
    type List<T: Copy + Debug + 'static> = Lent<'m, T>;
    /// There are few boxes, and to divide them would need calls of a function by itself, of whose depth a device knows nothing.
    const LEAF: usize = usize::MAX;
}

/// A list in room that is lent.
#[doc(hidden)]
#[derive(Debug)]
pub struct Lent<'m, T> {
    room: &'m mut [T],
    length: usize,
    lacks_room: bool,
}

impl<'m, T> Lent<'m, T> {
    /// An empty one.
    #[inline(always)]
    pub fn new(room: &'m mut [T]) -> Self {
        Lent {
            room,
            length: 0,
            lacks_room: false,
        }
    }
}

impl<T> Deref for Lent<'_, T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.room[..self.length]
    }
}

impl<T> DerefMut for Lent<'_, T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.room[..self.length]
    }
}

/// Up to so many elements are sorted by insertion alone, as in the standard library: of equal ones the first stays the first.
const FEW: usize = 20;
/// Distances of the elements that are compared (Ciura 2001), the largest first.
const GAPS: [usize; 8] = [1750, 701, 301, 132, 57, 23, 10, 4];

impl<T: Copy> List<T> for Lent<'_, T> {
    #[inline(always)]
    fn lacks_room(&self) -> bool {
        self.lacks_room
    }
    #[inline(always)]
    fn clear(&mut self) {
        self.length = 0;
    }
    #[inline(always)]
    fn push(&mut self, element: T) {
        match self.room.get_mut(self.length) {
            Some(place) => {
                *place = element;
                self.length += 1;
            }
            None => self.lacks_room = true,
        }
    }
    #[inline(always)]
    fn truncate(&mut self, length: usize) {
        self.length = self.length.min(length);
    }
    #[inline(always)]
    fn retain(&mut self, mut is_kept: impl FnMut(&T) -> bool) {
        let mut kept = 0;
        for k in 0..self.length {
            let element = self.room[k];
            if is_kept(&element) {
                self.room[kept] = element;
                kept += 1;
            }
        }
        self.length = kept;
    }
    /// Shell's method, which calls no function by itself.
    #[cfg_attr(not(feature = "std"), inline(never))]
    fn sort_with(&mut self, mut order: impl FnMut(&T, &T) -> Ordering) {
        let all = &mut self.room[..self.length];
        let many = all.len() > FEW;
        for gap in GAPS.into_iter().filter(|_| many).chain([1]) {
            for k in gap..all.len() {
                let element = all[k];
                let mut place = k;
                while place >= gap && order(&element, &all[place - gap]).is_lt() {
                    all[place] = all[place - gap];
                    place -= gap;
                }
                all[place] = element;
            }
        }
    }
}

/// What a struct of lists on the heap is said to have.
macro_rules! on_heap {
    ($name:ident: $($field:ident)*) => {
        impl Default for $name<$crate::geometry::lists::OnHeap> {
            fn default() -> Self {
                $name { $($field: Default::default(),)* }
            }
        }
        impl Clone for $name<$crate::geometry::lists::OnHeap> {
            fn clone(&self) -> Self {
                $name { $($field: self.$field.clone(),)* }
            }
        }
        impl core::fmt::Debug for $name<$crate::geometry::lists::OnHeap> {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field))*.finish()
            }
        }
    };
}
pub(crate) use on_heap;

#[cfg(test)]
mod tests {
    use super::*;

    /// The same calls give the same lists, on the heap and in room.
    #[test]
    fn lists_in_room_are_as_on_the_heap() {
        let mut state = 7u64;
        let mut number = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % below
        };
        for count in [0, 1, 2, 19, 20, 21, 100, 3000] {
            let numbers: Vec<[u64; 2]> = (0..count).map(|k| [number(count / 2 + 1), k]).collect();
            let mut room = vec![[0; 2]; count as usize];
            let mut lent = Lent::new(&mut room);
            let mut heap = Vec::new();
            fn act(list: &mut impl List<[u64; 2]>, numbers: &[[u64; 2]]) {
                list.clear();
                list.add_all(numbers.iter().copied());
                list.sort();
                list.retain(|n| n[0] % 3 != 0);
                list.iter_mut().for_each(|n| n[1] = n[0]);
                list.dedup();
                list.sort_with(|a, b| b[0].cmp(&a[0]));
                list.truncate(numbers.len() / 4 + 1);
            }
            act(&mut lent, &numbers);
            act(&mut heap, &numbers);
            assert_eq!(*lent, *heap);
            assert!(!lent.lacks_room() && !heap.lacks_room());
            lent.set_all(count as usize, [1; 2]);
            assert!(lent.len() == count as usize && !lent.lacks_room());
            lent.push([2; 2]);
            assert!(lent.len() == count as usize && lent.lacks_room());
            lent.clear();
            assert!(lent.is_empty() && lent.lacks_room());
        }
    }

    /// Up to the number that the standard library sorts so, too.
    #[test]
    fn of_few_equal_elements_the_first_stays_the_first() {
        for count in 0..=FEW as u32 {
            let mut room: Vec<[u32; 2]> = (0..count).map(|k| [k * 7 % 3, k]).collect();
            let mut stable = room.clone();
            stable.sort_by_key(|n| n[0]);
            let mut lent = Lent::new(&mut room);
            lent.length = count as usize;
            lent.sort_with(|a, b| a[0].cmp(&b[0]));
            assert_eq!(*lent, *stable);
        }
    }
}
