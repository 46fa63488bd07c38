use heapless::Vec;
use identifier_core::fit::Block;
use serde::{Deserialize, Serialize};

/// The most blocks of a message.
const PART: usize = 48;

/// A part of the record of the last probing motion of a commissioning, for a fit on the host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotionRecord {
    /// Blocks of the whole record; 0 if there is none.
    pub total: u16,
    /// Samples of a block.
    pub samples: u16,
    /// Position of a count in it, rad.
    pub resolution: f64,
    /// Displacement (counts), mean command and [first moment](Block::first_moment) of each block of this part.
    pub blocks: Vec<[f32; 3], PART>,
}

impl MotionRecord {
    /// No record.
    pub const NONE: Self = Self {
        total: 0,
        samples: 0,
        resolution: 0.0,
        blocks: Vec::new(),
    };

    /// The part of a record from a block on. Samples of a block and the position of a count (rad) go with it.
    #[must_use]
    pub fn from((record, samples, resolution): (&[Block<f32>], u16, f64), first: u16) -> Self {
        let mut blocks = Vec::new();
        for block in record.iter().skip(usize::from(first)) {
            let block = [block.travel, block.command, block.first_moment];
            if blocks.push(block).is_err() {
                break;
            }
        }
        Self {
            total: record.len() as u16,
            samples,
            resolution,
            blocks,
        }
    }
}
