//! Tables for `expand` and `compress`: from which lane each lane of the result comes.

/// For each byte (a mask), and for each of its bits, the number of set bits below that bit. In `expand`, this is the
/// source lane.
pub(super) static RANK: [[u8; 8]; 256] = ranks_and_set_bits()[0];
/// For each byte (a mask), the positions of its set bits in ascending order. In `compress`, these are the source lanes.
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

/// Writes each of four bits twice: bit `k` becomes bits `2 k` and `2 k + 1`. So a mask of four 64-bit lanes becomes a
/// mask of eight 32-bit lanes, which are moved in pairs.
#[inline(always)]
pub(super) fn twice_each(bits: u16) -> u16 {
    // Moves bit `k` to position `2 k`. Multiplying by 3 then copies it to position `2 k + 1`.
    let apart = (bits | bits << 2) & 0b11_0011;
    ((apart | apart << 1) & 0b101_0101) * 3
}
