//! Records drawn over the picture.

use hemicube::image::Picture;
use hemicube::reference::ward::Record;

/// Colours the pixels whose surface carries a record, bright against the picture.
pub fn records(picture: &mut Picture, records: &[Record]) {
    let Some([r, g, b]) = picture.rgb("") else { return };
    let mean = [r, g, b].iter().flat_map(|c| c.iter()).sum::<f32>() / (3 * r.len()) as f32;
    let bright = if mean > 0.0 { 4.0 * mean } else { 1.0 };
    for (channel, value) in [("R", bright), ("G", 0.6 * bright), ("B", 0.0)] {
        if let Some(pixels) = picture.channels.get_mut(channel) {
            records.iter().for_each(|record| pixels[record.pixel as usize] = value);
        }
    }
}
