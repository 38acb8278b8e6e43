/* A mouse in a static library (see ../src/lib.rs). In each cell, call mouse_see and mouse_next_step,
   drive the motors, and then call mouse_stepped. Define MOUSE_SHORTEST_PATH_SEARCH if the library
   has been built with the feature shortest-path-search. */
#ifndef MOUSE_H
#define MOUSE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MOUSE_STATE_BYTES 518

#ifdef MOUSE_SHORTEST_PATH_SEARCH
#define MOUSE_BYTES 1120
#else
#define MOUSE_BYTES 472
#endif

/* Memory for a mouse, for example in a static variable. Pointers must not be null, and a mouse must
   be initialized with mouse_new before any other call. */
typedef union {
    uint32_t alignment;
    uint8_t bytes[MOUSE_BYTES];
} mouse_t;

/* Initializes a mouse in the south-west corner of a 16x16 maze, heading north. */
void mouse_new(mouse_t *mouse);

/* Records whether there is a wall to the left, in front and to the right. Returns false if the
   reading contradicts earlier ones. */
bool mouse_see(mouse_t *mouse, bool left, bool front, bool right);

/* Returns the next step: 'F' front, 'L' left, 'R' right or 'B' back. For each step, the mouse turns
   and then moves one cell. Returns 'G' if the mouse is in the goal, and 0 if the goal is
   unreachable. */
uint8_t mouse_next_step(mouse_t *mouse);

/* Records that the mouse has taken a step. Returns false if this step is impossible. */
bool mouse_stepped(mouse_t *mouse, uint8_t step);

/* Encodes the state of the mouse as a request to a simulator. Call this function after
   mouse_next_step. */
void mouse_encode_state(const mouse_t *mouse, uint8_t message[MOUSE_STATE_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
