//! Campaigns of commissionings, judged by the simulator's exact position.

mod campaign;
mod effects;
mod fault_injection;
mod judged;
mod reasons;
mod scenarios;
mod servos;
mod tally;
