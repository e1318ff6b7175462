// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the tests of the core share: scenes, random shapes, oracles that compute another way, an integrator.

// Each test target takes what it needs.
#![allow(dead_code)]

pub mod brute_force;
pub mod elliptic;
pub mod golden;
pub mod held_contact;
pub mod list;
pub mod motion;
pub mod perram_wertheim;
pub mod random;
pub mod scene;
pub mod stability;
pub mod strategies;
