//! Pictures without a GPU: polygons in the light of a sun, as small PNGs.

pub mod camera;
pub mod light;
mod palette;
mod raster;
pub mod render;
pub mod shapes;
pub mod solid;
pub mod vector;

/// Pictures of one size side by side; bytes of red, green and blue by rows.
pub fn beside(panels: &[Vec<u8>], [width, height]: [usize; 2]) -> Vec<u8> {
    let row = |y: usize| panels.iter().flat_map(move |panel| &panel[3 * width * y..3 * width * (y + 1)]);
    (0..height).flat_map(row).copied().collect()
}

/// A picture of bytes of red, green and blue by rows, as a PNG that is as small as it gets.
///
/// # Errors
/// Where the bytes are not those of so many pixels.
pub fn png(bytes: &[u8], size: [usize; 2]) -> Result<Vec<u8>, png::EncodingError> {
    let [width, height] = size.map(|pixels| pixels as u32);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    let indexed = palette::reduce(bytes);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(indexed.palette);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    // Neighbouring numbers in a palette mean nothing, so that differences between them gain nothing.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indexed.pixels)?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_beside_each_other_row_by_row() {
        let panel = |first: u8| (first..first + 12).collect::<Vec<u8>>();
        let both = beside(&[panel(0), panel(100)], [2, 2]);
        assert_eq!(both[..12], [0, 1, 2, 3, 4, 5, 100, 101, 102, 103, 104, 105]);
        assert_eq!(both[12..15], [6, 7, 8]);
    }
}
