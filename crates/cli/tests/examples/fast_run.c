/* Prints the array that `mmsim fast-run --c-array` has written. */
#include <stdio.h>

#include "run.h"
#include "run.h" /* has a guard */

int main(void) {
    size_t i;
    printf("%c\n", FAST_RUN_DIRECTION);
    for (i = 0; i < FAST_RUN_COUNT; i++) {
        const struct fast_run_step *step = &fast_run[i];
        const char *side = step->side == FAST_RUN_LEFT ? "L" : "R";
        printf("%d %d %.2f %.1f ", step->steps, step->diagonal, (double)step->straight,
               (double)step->top_speed);
        if (step->turn == FAST_RUN_STOP) {
            printf("stop\n");
        } else {
            printf("%d%s %.2f %.1f\n", (int)step->turn, side, (double)step->arc,
                   (double)step->speed);
        }
    }
    return 0;
}
