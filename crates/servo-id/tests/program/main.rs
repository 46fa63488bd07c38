//! The program from outside: its verbs, files, terminal, pages, drives and logs. One binary, so that it is linked once
//! and its longest tests share the cores.

mod advice;
mod command_line;
mod commission;
mod drive;
mod drive_settings;
mod effects;
mod export;
mod export_firmware;
mod faults;
mod fit;
mod guides;
mod identify;
mod log_dialects;
#[cfg(target_os = "linux")]
mod memory;
#[cfg(unix)]
mod monitor;
mod monitor_view;
#[cfg(target_os = "linux")]
mod outputs;
mod own_logs;
mod pictures_in_browser;
mod playground_in_browser;
mod predict;
mod replay;
mod report;
mod report_in_browser;
mod scenario_reader;
mod stop;
mod support;
#[cfg(target_os = "linux")]
mod terminal;
mod tune;
mod verdict;
