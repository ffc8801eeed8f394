//! What a page consists of: words, tables, plots and pictures. Written as Markdown; the report is made of that.

use crate::report::table::Table;

/// A part of a page, with a heading.
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What stands below it.
    pub blocks: Vec<Block>,
}

/// A piece of a page.
pub enum Block {
    /// Paragraphs, lists and the like, as Markdown.
    Words(String),
    /// A table, which is kept as CSV too.
    Table(Table),
    /// A plot.
    Plot(Plot),
    /// A picture.
    Picture(Picture),
}

/// A drawing of lines.
pub struct Plot {
    /// Of its file.
    pub name: String,
    /// What is seen.
    pub caption: String,
    /// The drawing as SVG.
    pub svg: String,
}

/// A picture of pixels.
pub struct Picture {
    /// Of its file.
    pub name: String,
    /// What is seen.
    pub caption: String,
    /// The bytes of a PNG.
    pub png: Vec<u8>,
}

impl Section {
    /// With nothing below it yet.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), blocks: Vec::new() }
    }

    /// With more words, Markdown, below what there is.
    pub fn words(mut self, words: impl Into<String>) -> Self {
        self.blocks.push(Block::Words(words.into()));
        self
    }

    /// With a table below what there is.
    pub fn table(mut self, table: Table) -> Self {
        self.blocks.push(Block::Table(table));
        self
    }

    /// With a plot below what there is.
    pub fn plot(mut self, plot: Plot) -> Self {
        self.blocks.push(Block::Plot(plot));
        self
    }

    /// With a picture below what there is.
    pub fn picture(mut self, picture: Picture) -> Self {
        self.blocks.push(Block::Picture(picture));
        self
    }
}
