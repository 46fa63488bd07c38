//! A firmware that has every feature of the libraries.

#![no_std]
