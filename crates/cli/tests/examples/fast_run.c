/* Prints the array that `mmsim fast-run --c-array` has written. */
#include <stdio.h>

#include "run.h"

int main(void) {
    size_t i;
    printf("%c\n", FAST_RUN_DIRECTION);
    for (i = 0; i < FAST_RUN_COUNT; i++) {
        const struct fast_run_step *step = &fast_run[i];
        const char *side = step->side == FAST_RUN_LEFT ? "L" : "R";
        if (step->turn == FAST_RUN_STOP) {
            printf("%d %.2f stop\n", step->steps, (double)step->straight);
        } else {
            printf("%d %.2f %d%s %.2f %.1f\n", step->steps, (double)step->straight,
                   (int)step->turn, side, (double)step->arc, (double)step->speed);
        }
    }
    return 0;
}
