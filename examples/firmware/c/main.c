/* Firmware in C with the mouse of the static library. In place of sensors and motors, it has the
   text picture of a maze. It prints the number of steps through the debugger (semihosting). */
#include "mouse.h"

#include <stddef.h>

/* The picture of a 16x16 maze: 33 lines of 65 characters and a line feed. */
__asm__(".section .rodata.picture\n.global picture\npicture:\n.incbin \"" MAZE "\"\n");
extern const char picture[33][66];

/* Ready in the zeroed memory; mouse_new fills it in. */
static mouse_t mouse;

static bool has_wall(int x, int y, int heading) { /* 0 to 3: north, east, south, west */
    static const int down[4] = {-1, 0, 1, 0}, right[4] = {0, 2, 0, -2};
    return picture[31 - 2 * y + down[heading]][4 * x + 2 + right[heading]] != ' ';
}

/* Searches the maze and returns the number of steps, or -1 if the mouse cannot reach the goal. */
static int search(void) {
    int x = 0, y = 0, heading = 0;
    mouse_new(&mouse);
    for (int steps = 0;; steps++) {
        bool left = has_wall(x, y, (heading + 3) % 4), right = has_wall(x, y, (heading + 1) % 4);
        if (!mouse_see(&mouse, left, has_wall(x, y, heading), right)) return -1;
        uint8_t step = mouse_next_step(&mouse);
        if (step == 'G') return steps;
        if (step == 0 || !mouse_stepped(&mouse, step)) return -1;
        heading = (heading + (step == 'L' ? 3 : step == 'R' ? 1 : step == 'B' ? 2 : 0)) % 4;
        x += heading == 1 ? 1 : heading == 3 ? -1 : 0;
        y += heading == 0 ? 1 : heading == 2 ? -1 : 0;
    }
}

/* The rest starts the chip and talks to the debugger. */

extern uint32_t data_in_flash[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];

static int semihosting(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void print_number(int number) {
    char text[12], *digit = text + sizeof text;
    *--digit = 0;
    do *--digit = (char)('0' + number % 10); while ((number /= 10) > 0);
    semihosting(4, digit); /* SYS_WRITE0 */
}

void reset(void) {
    const uint32_t paint = 0xcccccccc;
    for (uint32_t *to = data_start, *from = data_in_flash; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_start; to < bss_end;) *to++ = 0;
    volatile uint32_t *free_memory = bss_end;
    uint32_t *here = __builtin_frame_address(0);
    for (volatile uint32_t *to = free_memory; to < here - 16; to++) *to = paint;
    int steps = search();
    while (*free_memory == paint) free_memory++;
    if (steps < 0) {
        semihosting(4, "goal unreachable\n");
    } else {
        print_number(steps);
        semihosting(4, " steps, ");
        print_number((int)((uintptr_t)here - (uintptr_t)free_memory));
        semihosting(4, " bytes of stack\n");
    }
    semihosting(0x18, (const void *)0x20026); /* SYS_EXIT, normally */
    for (;;) {}
}

static void fault(void) {
    semihosting(4, "fault\n");
    semihosting(0x18, (const void *)0x20023); /* SYS_EXIT, after an error */
    for (;;) {}
}

__attribute__((section(".vectors"), used)) static const void *vectors[4] = {
    stack_top, (const void *)reset, (const void *)fault, (const void *)fault,
};
