//! The table of a campaign.

use std::fmt::Write as _;

use super::identify::Settings;
use super::judge::Judgement;

/// One table of judgements under several settings, in rows by the number of effects.
pub(super) fn table(settings: &[Settings], judged: &[Vec<Judgement>]) -> String {
    let mut table = String::new();
    for (settings, judged) in settings.iter().zip(judged) {
        writeln!(
            table,
            "{}\n\
             effects  logs | converged: right wrong | refused: right wrong none | its first name: right wrong none | \
             all names: right wrong | b off %: 50 %    90 % | converged within 1, 2, 3 σ | refused within 1, 2, 3 σ | \
             noise off %: 50 %  90 % | shift off: known 50 %  90 % | s a log",
            settings.name
        )
        .expect("a String takes all");
        for (name, effects) in [
            ("none", 0..=0),
            ("1-2", 1..=2),
            ("3-5", 3..=5),
            ("all", 0..=usize::MAX),
        ] {
            let of_row = |judgement: &&Judgement| effects.contains(&judgement.present.len());
            let row: Vec<&Judgement> = judged.iter().filter(of_row).collect();
            if !row.is_empty() {
                table += &line(name, &row);
            }
        }
    }
    table
}

/// The number of judgements with a property.
pub(super) fn count(judged: &[&Judgement], is: impl Fn(&Judgement) -> bool) -> usize {
    judged.iter().filter(|judgement| is(judgement)).count()
}

fn line(name: &str, row: &[&Judgement]) -> String {
    let count = |is: &dyn Fn(&Judgement) -> bool| count(row, is);
    let refused = |judgement: &Judgement| !judgement.is_converged;
    let first = |is_right| count(&|j| refused(j) && j.first_name_is_right() == is_right);
    let names = |is_right| {
        let names = row.iter().flat_map(|judgement| &judgement.names);
        names.filter(|(_, right)| *right == is_right).count()
    };
    let covered = |is_converged: bool| {
        let judged = row.iter().filter(|j| j.is_converged == is_converged);
        let deviations: Vec<f64> = judged.flat_map(|j| j.deviations.clone()).collect();
        let within = |limit: f64| {
            let inside = deviations.iter().filter(|deviation| **deviation <= limit);
            100.0 * inside.count() as f64 / deviations.len().max(1) as f64
        };
        format!(
            "{:6.1} {:5.1} {:5.1}",
            within(1.0),
            within(2.0),
            within(3.0)
        )
    };
    let magnitudes = |of: &dyn Fn(&Judgement) -> Option<f64>| {
        let mut all: Vec<f64> = row.iter().filter_map(|j| of(j)).map(f64::abs).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let (off_b, off_noise, off_shift) = (
        magnitudes(&|j| Some(j.off_b.unwrap_or(f64::INFINITY))),
        magnitudes(&|j| j.off_noise),
        magnitudes(&|j| j.off_shift),
    );
    let seconds: f64 = row.iter().map(|judgement| judgement.seconds).sum();
    format!(
        "{name:7} {:5} | {:16} {:5} | {:14} {:5} {:4} | {:21} {:5} {:4} | {:16} {:5} | {:14.4} {:7.3} | {:>26} | {:>24} | \
         {:17.1} {:5.0} | {:16} {:5.2} {:5.2} | {:7.2}\n",
        row.len(),
        count(&|j| j.is_converged && j.is_right()),
        count(&|j| j.is_converged && !j.is_right()),
        count(&|j| refused(j) && j.is_right()),
        count(&|j| refused(j) && !j.is_right() && j.wrongness.is_some()),
        count(&|j| refused(j) && j.wrongness.is_none()),
        first(Some(true)),
        first(Some(false)),
        first(None),
        names(true),
        names(false),
        100.0 * quantile(&off_b, 0.5),
        100.0 * quantile(&off_b, 0.9),
        covered(true),
        covered(false),
        100.0 * quantile(&off_noise, 0.5),
        100.0 * quantile(&off_noise, 0.9),
        off_shift.len(),
        quantile(&off_shift, 0.5),
        quantile(&off_shift, 0.9),
        seconds / row.len() as f64,
    )
}

/// A quantile of sorted values; NaN of none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied().unwrap_or(f64::NAN)
}
