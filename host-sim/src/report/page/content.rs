//! What a page says, before it is set: a verdict, then sections of text, tables and plots.

use super::Figure;

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// What was done, to what.
    pub title: String,
    /// What was found, in a sentence or two.
    pub verdict: Verdict,
    /// The sections, in their order.
    pub sections: Vec<Section>,
    /// The call that made it.
    pub command: String,
}

/// Where the run stands that a page is shown of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// It goes on, and the page follows it.
    Underway,
    /// It is over.
    Over,
}

impl Page {
    /// A page of the sections that have something to say.
    #[must_use]
    pub fn of<const N: usize>(
        title: &str,
        command: &str,
        verdict: Verdict,
        sections: [(&'static str, Vec<Block>); N],
    ) -> Self {
        let said = sections.into_iter().filter(|(_, said)| !said.is_empty());
        Self {
            title: title.to_owned(),
            verdict,
            sections: said
                .map(|(heading, blocks)| Section { heading, blocks })
                .collect(),
            command: command.to_owned(),
        }
    }

    /// The page of a run that goes on: what it says holds so far, by this clock.
    #[must_use]
    pub fn so_far(self, clock: String) -> Self {
        let Verdict {
            headline, detail, ..
        } = self.verdict;
        Self {
            verdict: Verdict {
                tone: Tone::Underway,
                status: clock,
                headline: format!("So far: {headline}"),
                detail,
            },
            ..self
        }
    }
}

/// What may be made of the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Whether it may be relied on.
    pub tone: Tone,
    /// Its name in results.
    pub status: String,
    /// What was found, in a sentence.
    pub headline: String,
    /// Why, in a sentence or two.
    pub detail: String,
}

/// Whether a result may be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// It may.
    Good,
    /// Something speaks against it.
    Doubtful,
    /// There is none.
    Failed,
    /// It is not there yet.
    Underway,
}

/// A section under a heading.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// The heading.
    pub heading: &'static str,
    /// What it says.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Steps or remarks.
    List(Vec<String>),
    /// Names and what they are.
    Facts(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// Text to be copied.
    Code {
        /// What it is.
        caption: String,
        /// The text.
        text: String,
    },
    /// Plots.
    Figures(Vec<Figure>),
}

/// A table whose first column names the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// The names of the columns.
    pub columns: Vec<Column>,
    /// The rows, with a cell for each column.
    pub rows: Vec<Vec<String>>,
    /// How bad the value of each cell is, from 0 to [`Table::WORST`]; empty where that is not told.
    pub levels: Vec<Vec<u8>>,
}

impl Table {
    /// The worst level of a cell.
    pub const WORST: u8 = 5;

    /// A table without levels.
    #[must_use]
    pub fn new(caption: &str, columns: Vec<Column>, rows: Vec<Vec<String>>) -> Self {
        Self {
            caption: caption.to_owned(),
            columns,
            rows,
            levels: Vec::new(),
        }
    }
}

/// The name of a column, and how its cells are set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The name.
    pub name: String,
    /// Whether its cells are set as figures, to the right.
    pub is_figures: bool,
}

impl Column {
    /// A column of words.
    #[must_use]
    pub fn words(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            is_figures: false,
        }
    }

    /// A column of figures.
    #[must_use]
    pub fn figures(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            is_figures: true,
        }
    }
}

impl Section {
    /// Whether it shows plots.
    #[must_use]
    pub fn is_drawn(&self) -> bool {
        let mut blocks = self.blocks.iter();
        blocks.any(|block| matches!(block, Block::Figures(_)))
    }
}
