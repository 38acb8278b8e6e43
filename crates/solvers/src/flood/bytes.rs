//! The flood with one byte per cell, for small mazes on processors with 32-bit registers.

pub(super) mod exploration;
pub(super) mod waves;
