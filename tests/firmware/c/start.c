/* Start-up of a Cortex-M7 without a C library: vectors, floating point, data, and the debugger's
 * channel (semihosting). */
#include "board.h"

extern uint32_t stack_top, data_in_flash, data_begin, data_end, bss_begin, bss_end;

void start(void);

/* Coprocessor access: CP10 and CP11 are the floating-point unit. */
#define CPACR (*(volatile uint32_t *)0xE000ED88u)

static void stuck(void)
{
    say("fault\n");
    leave(1);
}

/* Start of the stack, reset, and the faults; no interrupt is on. */
__attribute__((section(".vectors"), used)) static const uintptr_t vectors[16] = {
    (uintptr_t)&stack_top, (uintptr_t)start, (uintptr_t)stuck, (uintptr_t)stuck,
    (uintptr_t)stuck,      (uintptr_t)stuck, (uintptr_t)stuck, 0,
    0,                     0,                0,                (uintptr_t)stuck,
    (uintptr_t)stuck,      0,                (uintptr_t)stuck, (uintptr_t)stuck};

static uint32_t semihosting(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;

    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void say(const char *text)
{
    semihosting(0x04, text);
}

void leave(uint32_t code)
{
    /* ADP_Stopped_ApplicationExit. */
    const uint32_t reason[2] = {0x20026u, code};

    for (;;) {
        semihosting(0x20, reason);
    }
}

/* What the stack has not reached yet is painted so. */
#define PAINT 0x57ac4e55u
/* Words below the caller's frame that are left as they are. */
#define MARGIN 64

static void paint(void)
{
    volatile uint32_t *at = &bss_end;
    const uintptr_t end = (uintptr_t)__builtin_frame_address(0) - MARGIN * sizeof *at;

    while ((uintptr_t)at < end) {
        *at++ = PAINT;
    }
}

uint32_t stack_bytes(void)
{
    const volatile uint32_t *at = &bss_end;

    while (*at == PAINT) {
        at++;
    }
    return (uint32_t)((uintptr_t)&stack_top - (uintptr_t)at);
}

void start(void)
{
    const uint32_t *from = &data_in_flash;
    volatile uint32_t *to;

    CPACR |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    for (to = &data_begin; to < &data_end; to++) {
        *to = *from++;
    }
    for (to = &bss_begin; to < &bss_end; to++) {
        *to = 0;
    }
    paint();
    leave(press() ? 0 : 1);
}
