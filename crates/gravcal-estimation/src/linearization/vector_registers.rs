//! What a matrix product leaves behind in the processor.

/// Tells an x86 processor that nobody needs the upper halves of its vector registers any more.
///
/// faer's kernels leave numbers there. Until they are given up, all code for any x86 processor, such as residuals are compiled to,
/// has to carry them along, and is slower for it.
#[inline]
pub(super) fn give_up_upper_halves() {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx) = pulp::core_arch::x86::Avx::try_new() {
        avx._mm256_zeroupper();
    }
}
