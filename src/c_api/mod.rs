// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything `extern "C"`, and all `unsafe` of the crate. One file per domain.
//!
//! Rules of this border:
//! - every call that can fail returns an `int32_t` status; codes are numbered in blocks and never reused;
//! - output is written only on success; every pointer that must not be NULL is checked and named in the message;
//! - the message of the last failure in this thread is in `ellgran_last_error()`;
//! - a panic is caught here and becomes `ELLGRAN_ERROR_PANIC`;
//! - every struct begins with its size, so that it can grow (`growing`);
//! - handles come in `_new`/`_free` pairs; `EllgranLaws` is immutable, so threads share it; an `EllgranWorkspace`
//!   belongs to one thread at a time;
//! - no allocation, lock or I/O inside a step, but for a workspace that grows with the number of particles.

#![allow(unsafe_code)]
// The comments become the C header's, where [count] is an array's length and not a link.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod contact;
pub mod engine_walls;
pub mod grain_sums;
pub mod growing;
mod huge_pages;
pub mod law;
pub mod many_contacts;
pub mod motion;
pub mod neighbour_list;
pub mod particles;
pub mod plane;
pub mod recorded;
pub mod rigid_wall;
pub mod servo;
pub mod solid;
pub mod stable_step;
pub mod staged;
pub mod status;
pub mod stiffness;
pub mod tallies;
pub mod version;
pub mod without_history;
