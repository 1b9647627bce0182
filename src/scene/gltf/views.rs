//! Little-endian numbers in bytes, and ranges that cannot overflow.

use super::error::{Fault, Result};

/// `bytes[offset..offset + length]`, or a fault that says what is missing.
pub fn range<'a>(bytes: &'a [u8], offset: u64, length: u64, of: &str) -> Result<&'a [u8]> {
    let end = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64);
    let Some(end) = end else {
        return Err(Fault::invalid(format!(
            "reads {length} bytes at byte {offset} of {of}, which has {}",
            bytes.len()
        )));
    };
    Ok(&bytes[offset as usize..end as usize])
}

/// Width and meaning of a number in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// Bytes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`; integers scaled to [0, 1] or [−1, 1] where `normalized` (glTF 2.0 §3.6.2.2).
    pub fn to_f32(self, bytes: &[u8], normalized: bool) -> f32 {
        let integer = |value: f64, largest: f64| {
            if normalized { (value / largest).max(-1.0) as f32 } else { value as f32 }
        };
        match self {
            Self::I8 => integer(f64::from(bytes[0] as i8), 127.0),
            Self::U8 => integer(f64::from(bytes[0]), 255.0),
            Self::I16 => integer(f64::from(i16::from_le_bytes(head(bytes))), 32767.0),
            Self::U16 => integer(f64::from(u16::from_le_bytes(head(bytes))), 65535.0),
            Self::U32 => integer(f64::from(u32::from_le_bytes(head(bytes))), 4_294_967_295.0),
            Self::F32 => f32::from_le_bytes(head(bytes)),
        }
    }

    /// The unsigned integer at the start of `bytes`; 0 for other kinds, which callers refuse beforehand.
    pub fn to_u32(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U8 => u32::from(bytes[0]),
            Self::U16 => u32::from(u16::from_le_bytes(head(bytes))),
            Self::U32 => u32::from_le_bytes(head(bytes)),
            Self::I8 | Self::I16 | Self::F32 => 0,
        }
    }
}

/// First `N` bytes; zeros past the end, which callers rule out by checking ranges when an accessor is opened.
fn head<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}
