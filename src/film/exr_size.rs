//! What the headers of an OpenEXR file promise, against the bytes that are there: a reader makes room
//! for all pixels before it sees the first one, and a header is quickly damaged.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::Compression;

/// An entry in the table of offsets, the coordinate of a line and the size of the data: what each block of
/// a file takes at least.
const BLOCK_BYTES: u128 = 8 + 4 + 4;

/// DEFLATE expands its input at most 1032-fold. Wavelets with Huffman codes and runs (PIZ) stay below.
const DEFLATE: u128 = 1032;

/// Why a file is not worth reading.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PromiseError {
    /// It is no OpenEXR file.
    #[error("cannot be decoded: {0}")]
    Malformed(#[from] exr::error::Error),
    /// It has fewer bytes than its header must have behind it.
    #[error(
        "is too small for the {sizes} pixels that its header promises (it has {there} bytes; expected at least \
         {least})"
    )]
    TooSmall { sizes: String, there: usize, least: u128 },
}

/// Bytes of all samples of a file at full resolution.
///
/// # Errors
/// What is no OpenEXR file, or one that is too small for them.
pub(crate) fn promised_bytes(file: &[u8]) -> Result<u64, PromiseError> {
    let headers = MetaData::read_from_buffered(Cursor::new(file), false)?.headers;
    let least: u128 = headers.iter().map(least_bytes).sum();
    if least > file.len() as u128 {
        let sizes: Vec<_> = headers
            .iter()
            .map(|h| format!("{}x{}", h.layer_size.width(), h.layer_size.height()))
            .collect();
        let (sizes, there) = (sizes.join(" and "), file.len());
        return Err(PromiseError::TooSmall { sizes, there, least });
    }
    Ok(headers.iter().map(sample_bytes).sum::<u128>().try_into().unwrap_or(u64::MAX))
}

/// Bytes of a part's samples.
fn sample_bytes(header: &Header) -> u128 {
    let size = header.layer_size;
    let of_channel = |channel: &exr::prelude::ChannelDescription| {
        let columns = size.width() / channel.sampling.width().max(1);
        let rows = size.height() / channel.sampling.height().max(1);
        columns as u128 * rows as u128 * channel.sample_type.bytes_per_sample() as u128
    };
    header.channels.list.iter().map(of_channel).sum()
}

/// Bytes that a part takes in a file at least.
fn least_bytes(header: &Header) -> u128 {
    let expansion = match header.compression {
        Compression::Uncompressed => 1,
        // A run of 128 in two bytes.
        Compression::RLE => 64,
        // 32 bits are cut to 24 before.
        Compression::PXR24 => DEFLATE * 4 / 3,
        // 64 coefficients of which one is stored, and that by DEFLATE.
        Compression::DWAA(_) | Compression::DWAB(_) => DEFLATE * 64,
        _ => DEFLATE,
    };
    let blocks = header.chunk_count as u128 * BLOCK_BYTES;
    // Of deep data, whose pixels may be empty, nothing more is known.
    let samples = if header.deep { 0 } else { sample_bytes(header) / expansion };
    blocks.max(samples)
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    use super::*;

    fn file(encoding: Encoding) -> Vec<u8> {
        let samples = FlatSamples::F16(vec![f16::ONE; 64 * 32]);
        let channels = AnyChannels::sort(SmallVec::from_iter([AnyChannel::new("Y", samples)]));
        let layer = Layer::new((64, 32), LayerAttributes::named("y"), encoding, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("fits");
        bytes.into_inner()
    }

    /// The largest coordinates of the windows of a file, where `from` stands.
    fn resize(mut file: Vec<u8>, to: (i32, i32)) -> Vec<u8> {
        let from = [63_i32.to_le_bytes(), 31_i32.to_le_bytes()].concat();
        let to = [(to.0 - 1).to_le_bytes(), (to.1 - 1).to_le_bytes()].concat();
        let places: Vec<_> =
            (0..file.len() - 8).filter(|&i| file[i..].starts_with(&from)).collect();
        assert!(places.len() >= 2, "display window and data window");
        places.iter().for_each(|&i| file[i..i + 8].copy_from_slice(&to));
        file
    }

    #[test]
    fn what_is_there_is_believed_and_more_is_not() {
        let tiles = Blocks::Tiles(Vec2(16, 16));
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::ZIP16,
            Compression::PIZ,
            Compression::PXR24,
            Compression::B44,
            Compression::B44A,
        ] {
            for blocks in [Blocks::ScanLines, tiles] {
                let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
                let file = file(encoding);
                assert_eq!(promised_bytes(&file).expect("whole"), 64 * 32 * 2, "{encoding:?}");
                for to in [(4096, 65536), (65536, 4096), (1 << 29, 1 << 29)] {
                    let error = promised_bytes(&resize(file.clone(), to))
                        .expect_err("too small")
                        .to_string();
                    let promise = format!("is too small for the {}x{} pixels", to.0, to.1);
                    assert!(error.starts_with(&promise), "{encoding:?}: {error}");
                }
            }
        }
        let error = promised_bytes(b"no picture").expect_err("none");
        assert!(error.to_string().starts_with("cannot be decoded: "), "{error}");
    }
}
