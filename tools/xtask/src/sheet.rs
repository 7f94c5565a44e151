//! A picture of labelled tiles in a grid, as bytes of 8-bit sRGB.

use font8x8::UnicodeFonts;

type Colour = [u8; 3];

const BACKGROUND: Colour = [24, 24, 24];
const FAILED: Colour = [72, 24, 24];
const TEXT: Colour = [230, 230, 230];
const REMARK: Colour = [230, 180, 90];

/// Width and height of a character.
const CELL: usize = 8;
/// From one line of text to the next.
const LINE: usize = 10;
/// Between tiles.
const GAP: usize = 4;

/// What a tile shows above its label.
pub enum Face {
    /// The bytes of a picture of the tile's size.
    Picture(Vec<u8>),
    /// Why there is none.
    Text(String),
}

/// One tile.
pub struct Tile {
    /// Name, below the picture; cut off in front if it is too long.
    pub name: String,
    /// A line below the name.
    pub remark: String,
    /// The picture.
    pub face: Face,
}

/// Pixels with a width.
pub struct Sheet {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Red, green and blue of each pixel.
    pub bytes: Vec<u8>,
}

impl Sheet {
    /// Puts tiles of `width` x `height` pixels, without their labels, into rows of `columns`.
    pub fn of(tiles: &[Tile], columns: usize, width: usize, height: usize) -> Self {
        let columns = columns.clamp(1, tiles.len().max(1));
        let rows = tiles.len().div_ceil(columns);
        let (across, down) = (width + GAP, height + 2 * LINE + GAP);
        let (total_width, total_height) = (columns * across + GAP, rows * down + GAP);
        let bytes = BACKGROUND.repeat(total_width * total_height);
        let mut sheet = Self { width: total_width, height: total_height, bytes };
        for (i, tile) in tiles.iter().enumerate() {
            let (x, y) = (GAP + i % columns * across, GAP + i / columns * down);
            let letters = width / CELL;
            match &tile.face {
                Face::Picture(picture) => {
                    for (row, pixels) in picture.chunks_exact(3 * width).enumerate().take(height) {
                        let at = 3 * ((y + row) * total_width + x);
                        sheet.bytes[at..at + pixels.len()].copy_from_slice(pixels);
                    }
                }
                Face::Text(text) => {
                    for row in 0..height {
                        for column in 0..width {
                            sheet.put(x + column, y + row, FAILED);
                        }
                    }
                    for (line, text) in wrapped(text, letters).iter().enumerate().take(height / LINE) {
                        sheet.write(x, y + 2 + line * LINE, text, TEXT);
                    }
                }
            }
            sheet.write(x, y + height + 2, &end_of(&tile.name, letters), TEXT);
            sheet.write(x, y + height + 2 + LINE, &end_of(&tile.remark, letters), REMARK);
        }
        sheet
    }

    fn put(&mut self, x: usize, y: usize, colour: Colour) {
        if x < self.width && y < self.height {
            let at = 3 * (y * self.width + x);
            self.bytes[at..at + 3].copy_from_slice(&colour);
        }
    }

    fn write(&mut self, x: usize, y: usize, text: &str, colour: Colour) {
        for (i, letter) in text.chars().enumerate() {
            for (row, bits) in glyph(letter).into_iter().enumerate() {
                for column in (0..CELL).filter(|column| bits >> column & 1 == 1) {
                    self.put(x + CELL * i + column, y + row, colour);
                }
            }
        }
    }
}

/// The rows of a character, the lowest bit on the left; a question mark for one that the font lacks.
fn glyph(letter: char) -> [u8; 8] {
    let found = font8x8::BASIC_FONTS.get(letter).or_else(|| font8x8::LATIN_FONTS.get(letter));
    found.or_else(|| font8x8::BASIC_FONTS.get('?')).unwrap_or_default()
}

/// The last characters of a text, with a mark if there are more.
fn end_of(text: &str, letters: usize) -> String {
    let count = text.chars().count();
    if count <= letters {
        return text.to_string();
    }
    let kept = text.chars().skip(count + 1 - letters);
    std::iter::once('~').chain(kept).collect()
}

/// Lines of at most so many characters, broken between words where they fit.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let letters = letters.max(1);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        while !word.is_empty() {
            let Some(line) = lines.last_mut() else { break };
            let used = line.chars().count();
            let gap = usize::from(used > 0);
            if used + gap + word.len() <= letters {
                line.extend(std::iter::repeat_n(' ', gap).chain(word.drain(..)));
            } else if used > 0 {
                lines.push(String::new());
            } else {
                line.extend(word.drain(..letters));
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_wrapped_and_cut() {
        assert_eq!(wrapped("a bc def toolongword x", 6), ["a bc", "def", "toolon", "gword", "x"]);
        assert_eq!(end_of("folder/name.glb", 8), "~ame.glb");
        assert_eq!(end_of("name.glb", 8), "name.glb");
    }

    #[test]
    fn tiles_lie_where_they_should() {
        let picture = |colour: Colour| Face::Picture(colour.repeat(16 * 16));
        let tile = |face| Tile { name: "n".into(), remark: String::new(), face };
        let tiles = [tile(picture([1, 2, 3])), tile(picture([4, 5, 6])), tile(Face::Text("why not".into()))];
        let sheet = Sheet::of(&tiles, 2, 16, 16);
        let at = |x: usize, y: usize| &sheet.bytes[3 * (y * sheet.width + x)..][..3];
        assert_eq!((at(GAP, GAP), at(GAP + 15, GAP + 15)), (&[1, 2, 3][..], &[1, 2, 3][..]));
        assert_eq!(at(2 * GAP + 16, GAP), [4, 5, 6]);
        let second_row = GAP + 16 + 2 * LINE + GAP;
        assert_eq!(at(GAP + 15, second_row + 15), FAILED);
        // The label is written in the colour of text.
        assert!((0..8).any(|y| (0..8).any(|x| at(GAP + x, GAP + 16 + 2 + y) == TEXT)));
        assert_eq!(sheet.bytes.len(), 3 * sheet.width * sheet.height);
    }
}
