//! Text for a terminal: the brief sections of a page, without headings and figures.

pub mod style;
mod table;

use crate::present::{Block, Page};

/// The brief sections of a page in at most `width` characters a line of a table.
#[must_use]
pub fn brief(page: &Page, width: u16) -> String {
    let sections = page.sections.iter().filter(|section| section.is_brief);
    joined(sections.flat_map(|section| &section.blocks), width)
}

/// Blocks in at most `width` characters a line of a table.
#[must_use]
pub fn blocks(blocks: &[Block], width: u16) -> String {
    joined(blocks.iter(), width)
}

fn joined<'a>(blocks: impl Iterator<Item = &'a Block>, width: u16) -> String {
    let texts = blocks.filter_map(|block| self::block(block, width));
    texts.collect::<Vec<_>>().join("\n")
}

/// The verdict of a page: its status, and why.
#[must_use]
pub fn verdict(page: &Page) -> String {
    let verdict = &page.verdict;
    format!(
        "{}: {}",
        style::status(&verdict.status, verdict.tone),
        verdict.detail
    )
}

fn block(block: &Block, width: u16) -> Option<String> {
    let text = match block {
        Block::Text(text) => text.clone(),
        Block::Warning(text) => format!("{} {text}", style::warning()),
        Block::List(items) => {
            let items = items.iter().map(|item| format!("- {item}"));
            items.collect::<Vec<_>>().join("\n")
        }
        Block::Facts(facts) => {
            let facts = facts.iter().map(|(name, text)| format!("{name}: {text}"));
            facts.collect::<Vec<_>>().join("\n")
        }
        Block::Table(table) => {
            let text = table::within(table, width);
            match table.caption.as_str() {
                "" => text,
                caption => format!("\n{caption}\n{text}"),
            }
        }
        Block::Code { text, .. } => format!("{text}\n"),
        Block::Figures(_) => return None,
    };
    Some(text)
}
