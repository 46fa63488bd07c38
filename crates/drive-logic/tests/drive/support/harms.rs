//! Harms that may come to a drive.

use super::drive::Drive;
use drive_logic::Lines;

/// What comes between.
pub(crate) type Harm = fn(&mut Drive);

pub(crate) fn stop(drive: &mut Drive) {
    drive.done(drive_link::Command::Stop);
}

pub(crate) fn supply_sags(drive: &mut Drive) {
    drive.lines(|lines| lines.supply = false);
}

pub(crate) fn amplifier_fails(drive: &mut Drive) {
    drive.lines(|lines| lines.amplifier = false);
}

pub(crate) fn low_switch_opens(drive: &mut Drive) {
    drive.lines(|lines| lines.low_switch = false);
}

pub(crate) fn high_switch_opens(drive: &mut Drive) {
    drive.lines(|lines| lines.high_switch = false);
}

pub(crate) fn encoder_fails(drive: &mut Drive) {
    drive.bench.sensor_works.set(false);
}

pub(crate) fn stage_fails(drive: &mut Drive) {
    drive.bench.stage_works.set(false);
}

pub(crate) fn samples_are_late(drive: &mut Drive) {
    drive.bench.late.set(true);
}

/// Takes the causes of all of these away.
pub(crate) fn repaired(drive: &mut Drive) {
    let bench = drive.bench;
    bench.lines.set(Lines::HEALTHY);
    bench.sensor_works.set(true);
    bench.stage_works.set(true);
    bench.late.set(false);
}
