//! Soft tissue as a cellular neural network.
#![no_std]

pub mod sample;
