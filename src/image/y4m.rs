//! Frames as YUV4MPEG2, the uncompressed video that encoders read from a pipe (its format: `man 5 yuv4mpeg`, MJPEG tools).
//!
//! Colours are BT.709 in the range of studios (16 to 235), all three planes of full size (`C444`).

use super::Picture;
use super::tone::Look;
use std::io::{self, Write};

/// A sink that frames of one size are written to.
pub struct Video<W: Write> {
    sink: W,
    size: [u32; 2],
}

impl<W: Write> Video<W> {
    /// Begins a video of so many frames a second.
    ///
    /// # Errors
    /// The sink takes no more.
    pub fn new(mut sink: W, size: [u32; 2], frames_a_second: f64) -> io::Result<Self> {
        let [over, under] = ratio(frames_a_second);
        let [width, height] = size;
        writeln!(sink, "YUV4MPEG2 W{width} H{height} F{over}:{under} Ip A1:1 C444 XCOLORRANGE=LIMITED")?;
        Ok(Self { sink, size })
    }

    /// Adds a frame: the picture's colour through exposure and tone map.
    ///
    /// # Errors
    /// The sink takes no more, or the picture has another size or no colour.
    pub fn write(&mut self, picture: &Picture, look: Look) -> io::Result<()> {
        let [r, g, b] = picture.rgb("").ok_or_else(|| io::Error::other("the picture has no colour"))?;
        if [picture.width, picture.height] != self.size {
            return Err(io::Error::other("the picture has another size than the video"));
        }
        let pixels: Vec<[u8; 3]> = (0..picture.pixels()).map(|i| code(look.apply([r[i], g[i], b[i]]))).collect();
        self.sink.write_all(b"FRAME\n")?;
        for plane in 0..3 {
            let values: Vec<u8> = pixels.iter().map(|pixel| pixel[plane]).collect();
            self.sink.write_all(&values)?;
        }
        self.sink.flush()
    }
}

/// Y', Cb and Cr of a colour as screens show it: BT.709-6, items 3.2 to 3.4, at 8 bits.
fn code(rgb: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = rgb.map(|value| f64::from(value) / 255.0);
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let difference = |colour: f64, scale: f64| 128.0 + 224.0 * (colour - y) / scale;
    [16.0 + 219.0 * y, difference(b, 1.8556), difference(r, 1.5748)].map(|value| value.round() as u8)
}

/// A rate as a ratio of whole numbers: 24, 30000/1001, or to a thousandth.
fn ratio(rate: f64) -> [u64; 2] {
    let under = [1_u32, 1001].into_iter().find(|under| {
        let over = rate * f64::from(*under);
        over >= 1.0 && (over - over.round()).abs() < 1e-6 * over && (*under == 1 || over.round() % 1000.0 == 0.0)
    });
    let under = under.unwrap_or(1000);
    [((rate * f64::from(under)).round() as u64).max(1), u64::from(under)]
}

#[cfg(test)]
mod tests {
    use super::super::tone::ToneMap;
    use super::*;

    #[test]
    fn colours_of_known_codes() {
        // BT.709's bars of full amplitude.
        let known = [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
        ];
        for (rgb, expected) in known {
            assert_eq!(code(rgb), expected, "{rgb:?}");
        }
    }

    #[test]
    fn rates_are_ratios() {
        assert_eq!(
            [24.0, 30.0 / 1.001, 12.5, 0.5, 1e-9].map(ratio),
            [[24, 1], [30000, 1001], [12500, 1000], [500, 1000], [1, 1000]]
        );
    }

    #[test]
    fn a_video_is_its_header_and_its_frames() {
        let mut picture = Picture::new(3, 2);
        picture.insert_rgb("", [[1.0; 3]; 6]);
        let mut bytes = Vec::new();
        let mut video = Video::new(&mut bytes, [3, 2], 24.0).unwrap();
        let look = Look { tone: ToneMap::Srgb, stops: 0.0 };
        video.write(&picture, look).unwrap();
        video.write(&picture, look).unwrap();
        assert!(video.write(&Picture::new(3, 2), look).is_err(), "no colour");
        picture.width = 2;
        picture.height = 3;
        assert!(video.write(&picture, look).is_err(), "another size");
        let header = b"YUV4MPEG2 W3 H2 F24:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
        let frame = [&b"FRAME\n"[..], &[235; 6], &[128; 12]].concat();
        assert_eq!(bytes, [&header[..], &frame, &frame].concat());
    }
}
