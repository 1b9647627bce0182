//! A file's bytes, taken from its front.

/// What is left of a file.
pub struct Parts<'a>(pub &'a [u8]);

impl<'a> Parts<'a> {
    /// So many bytes; none where it ends before.
    pub fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, left) = self.0.split_at_checked(count)?;
        self.0 = left;
        Some(taken)
    }

    /// A number of 32 bits.
    pub fn word(&mut self) -> Option<u32> {
        self.bytes(4)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
    }

    /// A number of 64 bits.
    pub fn long(&mut self) -> Option<u64> {
        self.bytes(8)?.first_chunk().map(|bytes| u64::from_le_bytes(*bytes))
    }
}

/// FNV-1a (Fowler, Noll and Vo 1991) of 64 bits over pieces of bytes: another one wherever a single byte differs.
pub fn checksum(pieces: &[&[u8]]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    pieces.iter().copied().flatten().fold(0xcbf2_9ce4_8422_2325, step)
}
