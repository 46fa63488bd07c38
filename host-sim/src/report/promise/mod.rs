//! What a tuning found and what it promises: in words, as JSON and as a picture.

mod document;
mod picture;
mod words;

pub use document::{
    ConditionsDocument, Document, FeedForwardDocument, PromiseDocument, ServoDocument,
};
pub use picture::figures;
pub use words::{controller, feed_forward, remarks, rows, table};
