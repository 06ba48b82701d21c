//! Where the lanes of a register come from in `expand` and `compress`, as tables.

/// For every byte, and each of its bits, how many bits below it are set: where `expand` takes a lane
/// from.
pub(super) static RANK: [[u8; 8]; 256] = ranks_and_set_bits()[0];
/// For every byte, the bits that are set, in order: where `compress` takes a lane from.
pub(super) static SET_BIT: [[u8; 8]; 256] = ranks_and_set_bits()[1];

const fn ranks_and_set_bits() -> [[[u8; 8]; 256]; 2] {
    let mut both = [[[0; 8]; 256]; 2];
    let mut bits = 0;
    while bits < 256 {
        let (mut bit, mut rank) = (0, 0);
        while bit < 8 {
            both[0][bits][bit] = rank;
            if bits >> bit & 1 == 1 {
                both[1][bits][rank as usize] = bit as u8;
                rank += 1;
            }
            bit += 1;
        }
        bits += 1;
    }
    both
}

/// Each of four bits twice, so that lanes of 64 bits are moved as pairs of 32.
#[inline(always)]
pub(super) fn twice_each(bits: u16) -> u16 {
    // Spread the bits to every other place; times 3 makes a pair of each.
    let apart = (bits | bits << 2) & 0b11_0011;
    ((apart | apart << 1) & 0b101_0101) * 3
}
