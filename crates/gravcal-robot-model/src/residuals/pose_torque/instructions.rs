//! The processor's vector instructions, where they are as wide as a batch of poses.

use gravcal_dynamics::Vectorized;
use pulp::{Arch, Simd, WithSimd};

/// The processor's instructions, where their registers have [`LANES`](gravcal_dynamics::LANES) lanes: AVX2's have. (With its feature
/// `x86-v4`, pulp would choose AVX-512, whose have twice as many.)
pub(super) fn batch_instructions() -> Option<Arch> {
    let instructions = Arch::new();
    instructions.dispatch(HaveLanes).then_some(instructions)
}

struct HaveLanes;

impl WithSimd for HaveLanes {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        Vectorized::new(simd).is_some()
    }
}
