use host_sim::provenance::Kept;
use serde::Serialize;

use super::fault::Fault;
use super::standard_output::show;

/// Compares a result with a kept one.
///
/// # Errors
/// If they differ.
pub(super) fn compare(kept: &Kept, result: &impl Serialize, silent: bool) -> Result<(), Fault> {
    /// Differences that are shown.
    const SHOWN: usize = 10;
    let file = kept.file.display();
    let differences = kept.differences(result);
    let differences = differences.map_err(|error| Fault::Other(format!("{file}: {error}")))?;
    match differences {
        None if silent => Ok(()),
        None => show!("{file} holds no result to compare with"),
        Some(differences) if differences.is_empty() => match silent {
            true => Ok(()),
            false => show!("the same result as in {file}, bit by bit"),
        },
        Some(differences) => {
            let mut lines: Vec<String> = differences.iter().take(SHOWN).cloned().collect();
            if let Some(more) = differences
                .len()
                .checked_sub(SHOWN)
                .filter(|more| *more > 0)
            {
                lines.push(format!("and {more} more"));
            }
            Err(Fault::Other(format!(
                "the result differs from that in {file}:\n  {}",
                lines.join("\n  ")
            )))
        }
    }
}
