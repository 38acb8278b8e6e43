//! The instruction sets that a flood can use.

/// An instruction set for floods. All instruction sets give the same distances, so only benchmarks
/// need to choose one. All other code uses the [best](Self::best) available set.
///
/// ```
/// use mmsim_maze::{MazeSize, Walls};
/// use mmsim_solvers::{Distances, Instructions};
/// let (walls, goals) = (Walls::open(MazeSize::CLASSIC), MazeSize::CLASSIC.central_cells());
/// let expected = Distances::flood(&walls, &goals);
/// for instructions in Instructions::ALL {
///     assert_eq!(Distances::flood_with(*instructions, &walls, &goals), expected);
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Instructions {
    /// One byte per cell instead of one bit, which is the fastest way on processors with 32-bit
    /// registers. Mazes of more than 16×16 cells use [`Portable`](Self::Portable).
    Bytes,
    /// Operations on 64-bit words, which are available on every processor.
    Portable,
    /// SSE2, which every x86-64 processor has. Programs without an operating system may be compiled
    /// without SSE2.
    Sse2,
    /// AVX2 and BMI1, which most x86-64 processors since 2015 have.
    Avx2,
    /// AVX-512 with the BW and VL extensions, which most servers and some laptops have. AVX-512 is
    /// available only with the crate feature `avx512`.
    Avx512,
}

impl Instructions {
    /// All instruction sets. On processors with 64-bit registers, they are in ascending order of
    /// speed.
    pub const ALL: &'static [Self] =
        &[Self::Bytes, Self::Portable, Self::Sse2, Self::Avx2, Self::Avx512];

    /// True if the processor has 32-bit registers.
    // WebAssembly has 32-bit pointers, but 64-bit integers.
    pub(super) const PREFERS_BYTES: bool =
        !cfg!(any(target_pointer_width = "64", target_family = "wasm"));
    /// The instruction set to ask for if all are available.
    pub(super) const PREFERRED: Self = if Self::PREFERS_BYTES { Self::Bytes } else { Self::Avx512 };

    /// Returns the best available instruction set.
    #[must_use]
    pub fn best() -> Self {
        if Self::PREFERS_BYTES {
            return Self::Bytes;
        }
        let mut from_best = Self::ALL.iter().copied().rev();
        from_best.find(|instructions| instructions.is_available()).unwrap_or(Self::Portable)
    }

    /// Returns true if this processor supports the instruction set and this crate was built with
    /// support for it. Without the `std` feature, only instruction sets that every processor of the
    /// target supports are available.
    pub fn is_available(self) -> bool {
        match self {
            Self::Bytes | Self::Portable => true,
            Self::Sse2 => cfg!(all(target_arch = "x86_64", target_feature = "sse2")),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
            Self::Avx2 => {
                use std::arch::is_x86_feature_detected as has;
                has!("avx2") && has!("bmi1") && has!("popcnt")
            }
            #[cfg(all(
                target_arch = "x86_64",
                target_feature = "sse2",
                feature = "std",
                feature = "avx512"
            ))]
            Self::Avx512 => {
                use std::arch::is_x86_feature_detected as has;
                let has_avx512 = has!("avx512f") && has!("avx512bw") && has!("avx512vl");
                has_avx512 && has!("bmi1") && has!("popcnt")
            }
            #[allow(unreachable_patterns)] // depends on the target and the features
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Returns the name of the instruction set.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::Portable => "portable",
            Self::Sse2 => "SSE2",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        }
    }
}
