//! The check of the program in the flash. `cargo xtask image` builds and seals one. A program from another build has no
//! seal.

use core::ptr::addr_of;
use core::slice;

use drive_link::Fault;
use drive_logic::{UNSEALED, check_image};

/// Written by the host once the program is linked.
#[used]
#[unsafe(link_section = ".seal")]
static SEAL: u32 = UNSEALED;

unsafe extern "C" {
    static __vector_table: u8;
    static _vectors_end: u8;
    static __stext: u8;
    static __etext: u8;
    static __srodata: u8;
    static __erodata: u8;
    static __sidata: u8;
    static __sdata: u8;
    static __edata: u8;
}

/// Checks the program: vectors, code, constants, and the initial values of the memory. False if it has no seal.
///
/// # Errors
/// [`Fault::ImageDamaged`].
pub fn check() -> Result<bool, Fault> {
    // SAFETY: the symbols are the linker's, and what they enclose is flash that nothing writes.
    unsafe {
        let part = |from: *const u8, to: *const u8| {
            let length = (to as usize).saturating_sub(from as usize);
            slice::from_raw_parts(from, length)
        };
        let data = (addr_of!(__edata) as usize).saturating_sub(addr_of!(__sdata) as usize);
        let values = addr_of!(__sidata);
        let parts = [
            part(addr_of!(__vector_table), addr_of!(_vectors_end)),
            part(addr_of!(__stext), addr_of!(__etext)),
            part(addr_of!(__srodata), addr_of!(__erodata)),
            slice::from_raw_parts(values, data),
        ];
        check_image(parts, addr_of!(SEAL).read_volatile())
    }
}
