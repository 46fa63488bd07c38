//! A page before it is rendered: a verdict, then sections of text, tables and figures.

use identifier_log::verdict::Status;

use super::Figure;

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// The experiment and its object.
    pub title: String,
    /// The conclusion.
    pub verdict: Verdict,
    /// The sections, in their order.
    pub sections: Vec<Section>,
    /// The command line that made it.
    pub command: String,
}

impl Page {
    /// A page of those sections that have any content.
    #[must_use]
    pub fn new(
        title: &str,
        command: &str,
        verdict: Verdict,
        sections: impl IntoIterator<Item = Section>,
    ) -> Self {
        let has_content = |section: &Section| !section.blocks.is_empty();
        Self {
            title: title.to_owned(),
            verdict,
            sections: sections.into_iter().filter(has_content).collect(),
            command: command.to_owned(),
        }
    }

    /// Its figures, which a picture shows.
    #[must_use]
    pub fn figures(&self) -> &[Figure] {
        let mut blocks = self.sections.iter().flat_map(|section| &section.blocks);
        let figures = blocks.find_map(|block| match block {
            Block::Figures(figures) => Some(figures.as_slice()),
            _ => None,
        });
        figures.unwrap_or_default()
    }
}

/// The conclusion of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Reliability of the result.
    pub tone: Tone,
    /// Name of the status in results.
    pub status: String,
    /// The conclusion, in a sentence.
    pub headline: String,
    /// The reason, in a sentence or two.
    pub detail: String,
}

/// Reliability of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// It can be relied on.
    Good,
    /// The result is uncertain.
    Doubtful,
    /// There is no result.
    Failed,
}

impl From<Status> for Tone {
    fn from(status: Status) -> Self {
        match status {
            Status::Converged => Self::Good,
            Status::Aborted => Self::Failed,
            Status::Partial | Status::Unexplained | Status::NoInformation | Status::Moving => {
                Self::Doubtful
            }
        }
    }
}

/// A section under a heading.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// The heading.
    pub heading: &'static str,
    /// Its content.
    pub blocks: Vec<Block>,
    /// True if it belongs to the brief form of the page, which a terminal prints.
    pub is_brief: bool,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Steps or remarks.
    List(Vec<String>),
    /// Names with their explanations.
    Facts(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// A remark that a reader must not miss.
    Warning(String),
    /// Text to be copied.
    Code {
        /// Its subject.
        caption: String,
        /// The text.
        text: String,
    },
    /// Figures of a common abscissa, once on a page.
    Figures(Vec<Figure>),
}

impl Block {
    /// A paragraph.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }

    /// Names with their explanations.
    #[must_use]
    pub fn facts(facts: impl IntoIterator<Item = (&'static str, String)>) -> Self {
        let facts = facts.into_iter();
        Self::Facts(facts.map(|(name, text)| (name.to_owned(), text)).collect())
    }
}

/// A table whose first column names the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Its subject.
    pub caption: String,
    /// The names of the columns.
    pub columns: Vec<Column>,
    /// The rows, with a cell for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table.
    #[must_use]
    pub fn new(caption: &str, columns: Vec<Column>, rows: Vec<Vec<String>>) -> Self {
        Self {
            caption: caption.to_owned(),
            columns,
            rows,
        }
    }
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// True if its cells are figures, aligned to the right.
    pub is_figures: bool,
    /// Order in which a narrow terminal leaves columns out, the highest first; none for a column that stays.
    pub drop_order: Option<u8>,
}

impl Column {
    /// A column of words.
    #[must_use]
    pub fn words(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            is_figures: false,
            drop_order: None,
        }
    }

    /// A column of figures.
    #[must_use]
    pub fn figures(name: &str) -> Self {
        Self {
            is_figures: true,
            ..Self::words(name)
        }
    }

    /// Columns of words, then of figures, then of words again.
    #[must_use]
    pub fn all(words: &[&str], figures: &[&str], last: &[&str]) -> Vec<Self> {
        let words = words.iter().map(|name| Self::words(name));
        let figures = figures.iter().map(|name| Self::figures(name));
        let last = last.iter().map(|name| Self::words(name));
        words.chain(figures).chain(last).collect()
    }

    /// The same, left out where there is too little room, before columns of a lower rank.
    #[must_use]
    pub fn drop_order(self, rank: u8) -> Self {
        Self {
            drop_order: Some(rank),
            ..self
        }
    }
}

impl Section {
    /// A section that only the whole page shows.
    #[must_use]
    pub fn full(heading: &'static str, blocks: Vec<Block>) -> Self {
        Self {
            heading,
            blocks,
            is_brief: false,
        }
    }

    /// A section that the brief form of the page shows too.
    #[must_use]
    pub fn brief(heading: &'static str, blocks: Vec<Block>) -> Self {
        Self {
            is_brief: true,
            ..Self::full(heading, blocks)
        }
    }
}
