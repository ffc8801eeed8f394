//! A picture's colours brought down to a palette: median cut (Heckbert 1982).

use std::collections::HashMap;

/// Colours of a palette.
const COLORS: usize = 192;

/// A colour as bytes of red, green and blue.
type Color = [u8; 3];

/// Colours of the picture that are alike, with the number of their pixels.
type Alike = Vec<(Color, usize)>;

/// A picture of a few colours.
pub struct Indexed {
    /// Bytes of red, green and blue.
    pub palette: Vec<u8>,
    /// One byte a pixel.
    pub pixels: Vec<u8>,
}

/// The picture with the palette that suits it; `bytes` are red, green and blue.
pub fn reduce(bytes: &[u8]) -> Indexed {
    let (colors, _) = bytes.as_chunks::<3>();
    let mut counts: HashMap<Color, usize> = HashMap::new();
    colors.iter().for_each(|&color| *counts.entry(color).or_default() += 1);
    let mut all: Alike = counts.into_iter().collect();
    all.sort_unstable();
    let groups = cut(all);
    let palette: Vec<u8> = groups.iter().flat_map(mean).collect();
    let members = |(index, group): (usize, &Alike)| {
        group.iter().map(move |&(c, _)| (c, index as u8)).collect::<Vec<_>>()
    };
    let index_of: HashMap<Color, u8> = groups.iter().enumerate().flat_map(members).collect();
    Indexed { palette, pixels: colors.iter().map(|color| index_of[color]).collect() }
}

/// Splits the group that is spread most, until there are enough.
fn cut(all: Alike) -> Vec<Alike> {
    let mut groups = vec![all];
    while groups.len() < COLORS {
        let weight = |group: &Alike| {
            let pixels: usize = group.iter().map(|(_, count)| count).sum();
            widest(group).1 * pixels as f64
        };
        let most = (0..groups.len()).max_by(|&a, &b| weight(&groups[a]).total_cmp(&weight(&groups[b])));
        let Some(most) = most.filter(|&most| groups[most].len() > 1) else { break };
        let (low, high) = halves(std::mem::take(&mut groups[most]));
        groups[most] = low;
        groups.push(high);
    }
    groups
}

/// The channel in which a group is spread most, and how far.
fn widest(group: &Alike) -> (usize, f64) {
    let range = |channel: usize| {
        let values = || group.iter().map(|(color, _)| color[channel]);
        f64::from(values().max().unwrap_or(0) - values().min().unwrap_or(0))
    };
    (0..3).map(|channel| (channel, range(channel))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

/// Cuts a group of two colours or more at the middle of its widest channel.
fn halves(group: Alike) -> (Alike, Alike) {
    let (channel, _) = widest(&group);
    let values = || group.iter().map(|(color, _)| u32::from(color[channel]));
    let middle = (values().min().unwrap_or(0) + values().max().unwrap_or(0)) / 2;
    group.into_iter().partition(|(color, _)| u32::from(color[channel]) <= middle)
}

fn mean(group: &Alike) -> Color {
    let pixels: usize = group.iter().map(|(_, count)| count).sum();
    std::array::from_fn(|channel| {
        let sum: usize = group.iter().map(|(color, count)| usize::from(color[channel]) * count).sum();
        ((sum + pixels / 2) / pixels.max(1)) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_stay_as_they_are() {
        let picture = [250, 10, 10, 10, 10, 250, 250, 10, 10];
        let indexed = reduce(&picture);
        assert_eq!(indexed.palette.len(), 6);
        assert_eq!(indexed.pixels[0], indexed.pixels[2]);
        assert_eq!(indexed.palette[3 * usize::from(indexed.pixels[1])..][..3], picture[3..6]);
    }
}
