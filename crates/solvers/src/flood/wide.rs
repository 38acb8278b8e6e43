//! The wide flood, which operates on one bit per cell, for processors with 64-bit registers.
//!
//! The cells are coloured like a chessboard, and a set of cells of one colour (`ParityPlane`) of a
//! small maze fits into one vector register.
//!
//! | file | processor |
//! |---|---|
//! | `words.rs` | every processor, with 64-bit words |
//! | `sse2.rs` | x86-64 with SSE2 or AVX2 |
//! | `avx512.rs` | x86-64 with AVX-512 |
//! | all others | all of these: generic, compiled once for each |

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
pub(super) mod avx512;
pub(super) mod bitboard;
pub(super) mod exploration;
pub(super) mod plane;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(super) mod sse2;
pub(super) mod waves;
mod words;
