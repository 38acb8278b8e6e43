/* Prints the array that `mmsim fast-run --c-array` has written. */
#include <stdio.h>

#include "final.h"
#include "final.h" /* has a guard */
#include "first.h"

#ifdef FAST_RUN_FIRST_DIAGONAL_BRAKING
#error "the vehicle does not drive diagonally"
#endif

int main(void) {
    size_t i;
    printf("%c\n", FAST_RUN_FINAL_DIRECTION);
    for (i = 0; i < FAST_RUN_FINAL_COUNT; i++) {
        const struct fast_run_step *step = &fast_run_final[i];
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
    printf("%d %d %.0f\n", (int)FAST_RUN_FIRST_COUNT, (int)fast_run_first[0].turn,
           (double)FAST_RUN_FIRST_JERK);
    return 0;
}
