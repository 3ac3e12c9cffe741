//! Damage to files, the same everywhere.

/// Pieces that are likely to matter in a scene file.
const PIECES: [&str; 25] = [
    "\"",
    "<",
    ">",
    "/>",
    "&",
    "$",
    "\\$",
    "$spp",
    "-",
    "1e308",
    "1e-320",
    "nan",
    "inf",
    "99999999999999999999",
    "-1",
    "0",
    "é",
    "\0",
    "<ref id=\"two\"/>",
    "<scene version=\"3.0.0\">",
    "type=\"cube\"",
    "<!--",
    "]]>",
    "value",
    "1e39",
];

/// What numbers of a format become.
const NUMBERS: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    u64::MAX,
];

/// A small generator of numbers (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }
}

/// A file with up to four faults.
pub(crate) fn damage(file: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        let end = (at + random.below(12)).min(bytes.len());
        match random.below(10) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => drop(bytes.splice(at..end, PIECES[random.below(PIECES.len())].bytes())),
            4 => drop(bytes.splice(at..at, PIECES[random.below(PIECES.len())].bytes())),
            5 => number(&mut bytes, at, random),
            6 => number(&mut bytes, at, random),
            // Another part of the same file: names, types and values change places.
            7 => {
                let from = random.below(bytes.len());
                let word: Vec<u8> = bytes[from..].iter().copied().take(random.below(12)).collect();
                drop(bytes.splice(at..end, word));
            }
            8 => {
                let copied = bytes[at..(at + random.below(200)).min(bytes.len())].to_vec();
                let to = random.below(bytes.len());
                drop(bytes.splice(to..to, copied));
            }
            _ if random.below(3) == 0 => bytes.truncate(at),
            _ => bytes[at] = bytes[at].wrapping_add(1),
        }
    }
    bytes
}

/// Writes a number of up to eight bytes over what is there, in either order.
fn number(bytes: &mut [u8], at: usize, random: &mut Random) {
    let size = 1 << random.below(4);
    let mut number = NUMBERS[random.below(NUMBERS.len())].to_le_bytes()[..size].to_vec();
    if random.below(2) == 0 {
        number.reverse();
    }
    bytes[at..].iter_mut().zip(number).for_each(|(byte, new)| *byte = new);
}

/// Makes the sums of a PNG file's chunks right, so that more of the decoder is reached.
pub(crate) fn png_with_sums(mut file: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(head) = file.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(end) = (at + 8).checked_add(length).filter(|&e| e + 4 <= file.len()) else {
            break;
        };
        let mut crc = flate2::Crc::new();
        crc.update(&file[at + 4..end]);
        file[end..end + 4].copy_from_slice(&crc.sum().to_be_bytes());
        at = end + 4;
    }
    file
}
