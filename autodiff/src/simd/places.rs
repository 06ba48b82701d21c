//! Tables of the sources of lanes in `expand` and `compress`.

/// For each bit of every byte, the number of set bits below it: the source of a lane in `expand`.
pub(super) static RANK: [[u8; 8]; 256] = ranks_and_set_bits()[0];
/// For every byte, its set bits in order: the sources of lanes in `compress`.
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

/// Doubles each of four bits, so that lanes of 64 bits are moved as pairs of 32 bits.
#[inline(always)]
pub(super) fn twice_each(bits: u16) -> u16 {
    // Spread the bits to every other place. Multiplication by 3 makes a pair of each.
    let apart = (bits | bits << 2) & 0b11_0011;
    ((apart | apart << 1) & 0b101_0101) * 3
}
