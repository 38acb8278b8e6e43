/* The brain of a mouse, see src/lib.rs. In each cell, in this order: mouse_see,
   mouse_next_step, the motors, mouse_stepped. */
#ifndef MOUSE_H
#define MOUSE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MOUSE_STATE_BYTES 518

/* Room for a mouse, for one of your own static variables. No function takes a null pointer, and
   none but mouse_new takes a mouse that has not been through mouse_new. */
typedef union {
    uint64_t alignment;
    uint8_t bytes[4096];
} mouse_t;

/* A mouse in the south-west corner of a 16x16 maze, heading north. */
void mouse_new(mouse_t *mouse);

/* Is there a wall to the left, in front, to the right? False if that cannot be true. */
bool mouse_see(mouse_t *mouse, bool left, bool front, bool right);

/* 'F' front, 'L' left, 'R' right, 'B' back: a turn, then one cell. 'G' in the goal; 0 if there is
   no way to it. */
uint8_t mouse_next_step(mouse_t *mouse);

/* The motors have taken this step. False if there is no open way there. */
bool mouse_stepped(mouse_t *mouse, uint8_t step);

/* The message that reports the state to a simulator, after mouse_next_step. */
void mouse_encode_state(const mouse_t *mouse, uint8_t message[MOUSE_STATE_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
