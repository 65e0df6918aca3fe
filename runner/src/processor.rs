//! What of this machine's processor may change the last bits of a result.

/// The widest vector instructions that a model's kernels, and the mathematical functions of the C library, may use here.
pub fn vector_instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::is_x86_feature_detected!("avx512f") {
            return "avx512";
        }
        if std::is_x86_feature_detected!("avx2") {
            return "avx2";
        }
    }
    "baseline"
}
