//! The test of the memory, before anything is kept in it.

/// Tests all of the memory after a reset. A program whose memory fails stops there. Its outputs are not driven yet, and
/// it could not reliably report the failure.
///
/// Every word holds its address and then the complement, written and compared upwards and downwards. Each bit is thus
/// compared in both states and after its neighbours were written. This march test finds cells that are stuck, cells
/// that follow others, and lines of the address that are open or short.
#[macro_export]
macro_rules! test_memory_after_reset {
    () => {
        // SAFETY: the start-up code calls it before it uses any memory, and expects nothing in it afterwards.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn __pre_init() {
            core::arch::naked_asm!(
                "movw r0, #:lower16:_stack_end",
                "movt r0, #:upper16:_stack_end",
                "movw r1, #:lower16:_ram_end",
                "movt r1, #:upper16:_ram_end",
                "mov r2, r0",
                "2:",
                "str r2, [r2]",
                "add r2, r2, #4",
                "cmp r2, r1",
                "bne 2b",
                "mov r2, r0",
                "3:",
                "ldr r3, [r2]",
                "cmp r3, r2",
                "bne 9f",
                "mvn r3, r2",
                "str r3, [r2]",
                "add r2, r2, #4",
                "cmp r2, r1",
                "bne 3b",
                "4:",
                "sub r2, r2, #4",
                "ldr r3, [r2]",
                "mvn r3, r3",
                "cmp r3, r2",
                "bne 9f",
                "str r2, [r2]",
                "cmp r2, r0",
                "bne 4b",
                "5:",
                "ldr r3, [r2]",
                "cmp r3, r2",
                "bne 9f",
                "add r2, r2, #4",
                "cmp r2, r1",
                "bne 5b",
                "bx lr",
                "9:",
                "b 9b",
            )
        }
    };
}
