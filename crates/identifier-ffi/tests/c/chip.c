/* A Cortex-M under C's library: vectors, memory, FPU, and output by semihosting. */
#include <stdint.h>
#include <sys/stat.h>

extern uint32_t stack_end, data_from, data_begin, data_end, bss_begin, bss_end;
int main(void);

static int host(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static _Noreturn void leave(int well) {
    /* ADP_Stopped_ApplicationExit, or an error. */
    host(0x18, (const void *)(well ? 0x20026 : 0x20023));
    for (;;) {
    }
}

void reset(void) {
#ifdef __ARM_FP
    *(volatile uint32_t *)0xe000ed88 |= 0xf << 20;
    __asm__ volatile("dsb\nisb");
#endif
    for (uint32_t *to = &data_begin, *from = &data_from; to < &data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = &bss_begin; to < &bss_end;) {
        *to++ = 0;
    }
    leave(main() == 0);
}

static void fault(void) { leave(0); }

__attribute__((section(".vectors"), used)) static void *const VECTORS[] = {
    &stack_end, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault};

int _write(int file, const char *text, int length) {
    /* SYS_OPEN of the console to write, once, and SYS_WRITE. */
    static int console;
    if (console == 0) {
        const uint32_t name[] = {(uint32_t)(uintptr_t) ":tt", 4, 3};
        console = host(0x01, name);
    }
    const uint32_t what[] = {(uint32_t)console, (uint32_t)(uintptr_t)text, (uint32_t)length};
    host(0x05, what);
    (void)file;
    return length;
}

extern char heap_begin;
void *_sbrk(int more) {
    static char *end = &heap_begin;
    char *before = end;
    end += more;
    return before;
}

int _close(int file) { (void)file; return -1; }
int _fstat(int file, struct stat *of) { (void)file; of->st_mode = S_IFCHR; return 0; }
int _isatty(int file) { (void)file; return 1; }
int _lseek(int file, int to, int from) { (void)file; (void)to; (void)from; return 0; }
int _read(int file, char *to, int length) { (void)file; (void)to; (void)length; return 0; }
void _exit(int status) { leave(status == 0); }
int _kill(int process, int signal) { (void)process; (void)signal; return -1; }
int _getpid(void) { return 1; }
