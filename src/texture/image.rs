//! Pixels of a file, in the file's own precision.

use half::f16;

/// A picture with one channel (grey) or three (red, green, blue).
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: usize,
    texels: Texels,
}

/// Rows from the top, pixels from the left, channels side by side.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 0 to 255 for 0 to 1.
    Unorm8(Vec<u8>),
    /// 0 to 65535 for 0 to 1.
    Unorm16(Vec<u16>),
    /// Linear values in half precision.
    Half(Vec<f16>),
    /// Linear values in single precision.
    Float(Vec<f32>),
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Unorm8(values) => values.len(),
            Self::Unorm16(values) => values.len(),
            Self::Half(values) => values.len(),
            Self::Float(values) => values.len(),
        }
    }
}

impl Image {
    /// `None` if the number of texels is not `width · height · channels`, if there are none, or if there
    /// are neither one nor three channels.
    #[must_use]
    pub fn new(width: u32, height: u32, channels: usize, texels: Texels) -> Option<Self> {
        let count = (width as usize).checked_mul(height as usize)?.checked_mul(channels)?;
        let fits = count > 0 && count == texels.len() && (channels == 1 || channels == 3);
        fits.then_some(Self { width, height, channels, texels })
    }

    /// The same picture with other values; `None` if they are not as many.
    #[must_use]
    pub fn with_texels(&self, texels: Texels) -> Option<Self> {
        Self::new(self.width, self.height, self.channels, texels)
    }

    /// Pixels from left to right.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels from top to bottom.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// 1 or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The values.
    #[must_use]
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Unorm8(values) => size_of_val(values.as_slice()),
            Texels::Unorm16(values) => size_of_val(values.as_slice()),
            Texels::Half(values) => size_of_val(values.as_slice()),
            Texels::Float(values) => size_of_val(values.as_slice()),
        }
    }
}
