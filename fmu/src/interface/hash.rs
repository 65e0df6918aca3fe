//! Identity of the variable table, checksum of saved states and of written frames.

/// The first 16 bytes of the BLAKE3 hash of `bytes`.
pub(crate) fn hash_128(bytes: &[u8]) -> [u8; 16] {
    let mut first = [0; 16];
    first.copy_from_slice(&blake3::hash(bytes).as_bytes()[..16]);
    first
}
