//! FNV-1a in 128 bits: identity of the variable table, checksum of saved states.

/// Hash of `bytes`. Any change of a single byte changes it.
pub(crate) fn fnv1a_128(bytes: &[u8]) -> u128 {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.iter().fold(OFFSET, |hash, &byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    #[test]
    fn known_values() {
        // Of the published specification of FNV (RFC 9923).
        assert_eq!(super::fnv1a_128(b""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(super::fnv1a_128(b"a"), 0xd228cb696f1a8caf78912b704e4a8964);
    }
}
