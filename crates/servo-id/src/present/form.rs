//! Gains in the form of a drive's firmware.

use identifier_log::result::FormResult;

use super::Block;
use super::number::{figure, sentence};

/// The parameters, the behaviour of their loop, and remarks.
pub(super) fn form(of: &FormResult, remarks: &[String]) -> Vec<Block> {
    let parameters = of.parameters.iter().map(|of| {
        // As it is stored, with every digit.
        let line = format!("{} = {} {}", of.name, of.value, of.unit);
        line.trim_end().to_owned()
    });
    let text = parameters.collect::<Vec<_>>().join("\n");
    let ms = |time: f64| figure(1e3 * time);
    let [fall, rise] = of.margins.gain_margins.map(figure);
    let (period, sensitivity) = (ms(of.sample_time), figure(of.margins.sensitivity));
    let mut list = vec![
        format!("For {}, with a loop every {period} ms.", of.firmware),
        format!("Conversion: {}.", of.exactness),
        format!("Largest sensitivity Ms: {sensitivity}. Gain margins: {fall} and {rise}."),
    ];
    for step in &of.steps {
        let through = match step.smoothing {
            0.0 => "straight to the target".to_owned(),
            time => format!("through a filter of {} ms in your program", ms(time)),
        };
        let rise = ms(step.rise_time.unwrap_or(f64::INFINITY));
        let overshoot = figure(100.0 * step.overshoot);
        list.push(format!(
            "A step {through} has a rise time of {rise} ms and an overshoot of {overshoot} %."
        ));
    }
    if !of.first_trial.is_empty() {
        let first = of.first_trial.iter();
        let first: Vec<_> = first
            .map(|of| format!("{} = {}", of.name, of.value))
            .collect();
        list.push(format!(
            "First trial, a quarter of the bandwidth: {}. A small step must come to rest with these; if it does not, it will \
             not with the others.",
            first.join(", ")
        ));
    }
    list.extend(remarks.iter().map(|remark| sentence(remark)));
    list.extend(of.remarks.iter().cloned());
    let caption = of.firmware.to_owned();
    vec![Block::Code { caption, text }, Block::List(list)]
}
