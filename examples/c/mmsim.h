/* mmsim.h: encodes and decodes the messages between a micromouse and a maze simulator such as
   mmsim. Copy this file into your project.

   The header is C99 or C++, does not allocate, has no global state, and needs no library, so you
   can use it in firmware. You can choose any transport, such as ZeroMQ (see flood_fill.c) or a
   serial line to a program that forwards the bytes. Each request gets one reply.

       uint8_t message[MMSIM_MAX_BYTES];
       const mmsim_pose pose = {0, 0, MMSIM_NORTH};
       size_t length = mmsim_encode_walls(message, sizeof message, pose);
       ... send `length` bytes, receive a reply into `message` and set `length` to its size ...
       mmsim_reply reply = mmsim_decode_reply(message, length);
       if (reply.kind == MMSIM_WALLS && !reply.front) ...

   Cell (0, 0) is the south-west corner, x grows east, y grows north. The mouse starts in
   cell (0, 0), heading north. Mazes have up to 32x32 cells, usually 16x16. */
#ifndef MMSIM_H
#define MMSIM_H

#include <stdint.h>
#include <string.h>

#define MMSIM_MAX_SIDE 32

/* The length of a state request in bytes: 518 for a maze of 16x16 cells. */
#define MMSIM_STATE_BYTES(width, height) (6 + 2 * (width) * (height))

/* A buffer of this size holds any request. */
#define MMSIM_MAX_BYTES MMSIM_STATE_BYTES(MMSIM_MAX_SIDE, MMSIM_MAX_SIDE)

/* Headings, clockwise: each is a quarter turn to the right of the previous one. */
enum { MMSIM_NORTH, MMSIM_EAST, MMSIM_SOUTH, MMSIM_WEST };

/* The flags for what a mouse knows about a cell. Add the flags that apply. */
enum {
    MMSIM_VISITED = 1,
    MMSIM_WALL_EAST = 2,
    MMSIM_WALL_SOUTH = 4,
    MMSIM_WALL_WEST = 8,
    MMSIM_WALL_NORTH = 16
};

/* The order of the cells in a state: C is row by row from the south, F is column by column from the
   west. You can use either order; viewers show the same maze. */
enum { MMSIM_ORDER_C = 'C', MMSIM_ORDER_F = 'F' };

typedef struct {
    uint8_t width, height;
} mmsim_size;

typedef struct {
    uint8_t x, y, heading;
} mmsim_pose;

/* The kinds of reply. */
typedef enum {
    MMSIM_NO_REPLY, /* invalid reply */
    MMSIM_PONG,     /* reply to ping */
    MMSIM_OK,       /* reply to reset and to a state */
    MMSIM_WALLS,    /* reply to walls: left, front and right are 1 for a wall, else 0 */
    MMSIM_ERROR     /* the request was refused and changed nothing; the text says why */
} mmsim_reply_kind;

typedef struct {
    mmsim_reply_kind kind;
    uint8_t left, front, right;
    const char *text; /* points into the message, not zero-terminated; print it with "%.*s" */
    size_t text_length;
} mmsim_reply;

/* Each mmsim_encode function writes a request to a buffer of `capacity` bytes and returns its
   length. If the buffer is too small or an argument is out of range, it writes nothing and returns
   0. */

/* Encodes `ping`, which checks that a simulator replies. */
static inline size_t mmsim_encode_ping(uint8_t *buffer, size_t capacity) {
    if (capacity < 4) return 0;
    memcpy(buffer, "ping", 4);
    return 4;
}

/* Encodes `reset`, which deletes all states and begins a new search. */
static inline size_t mmsim_encode_reset(uint8_t *buffer, size_t capacity) {
    if (capacity < 5) return 0;
    memcpy(buffer, "reset", 5);
    return 5;
}

/* Encodes a request for the walls to the left, in front and to the right in this pose. */
static inline size_t mmsim_encode_walls(uint8_t *buffer, size_t capacity, mmsim_pose pose) {
    if (capacity < 4 || pose.heading > MMSIM_WEST) return 0;
    buffer[0] = 'W';
    buffer[1] = pose.x;
    buffer[2] = pose.y;
    buffer[3] = (uint8_t)"NESW"[pose.heading];
    return 4;
}

/* Encodes a state with this pose. Call mmsim_set_cell for each cell afterwards; other cells have
   weight 0 and no walls. */
static inline size_t mmsim_encode_state(uint8_t *buffer, size_t capacity, mmsim_size size,
                                        mmsim_pose pose, int order) {
    const size_t area = (size_t)size.width * size.height, length = 6 + 2 * area;
    if (size.width > MMSIM_MAX_SIDE || size.height > MMSIM_MAX_SIDE) return 0;
    if (pose.x >= size.width || pose.y >= size.height || pose.heading > MMSIM_WEST) return 0;
    if (order != MMSIM_ORDER_C && order != MMSIM_ORDER_F) return 0;
    if (capacity < length) return 0;
    memset(buffer, 0, length);
    mmsim_encode_walls(buffer, capacity, pose); /* the pose has the same offset in both requests */
    buffer[0] = 'S';
    buffer[4] = buffer[5 + area] = (uint8_t)order;
    return length;
}

/* Sets one cell of a state for a maze of this size. `weight` can mean anything, such as the
   distance to the goal; values above 255 are sent as 255. `known` is what the mouse knows about
   the cell. Cells outside the maze are ignored. */
static inline void mmsim_set_cell(uint8_t *state, mmsim_size size, uint8_t x, uint8_t y,
                                  uint16_t weight, uint8_t known) {
    const size_t area = (size_t)size.width * size.height;
    const size_t by_rows = (size_t)y * size.width + x, by_columns = (size_t)x * size.height + y;
    const size_t index = state[4] == MMSIM_ORDER_C ? by_rows : by_columns;
    if (x >= size.width || y >= size.height) return;
    state[5 + index] = weight < 255 ? (uint8_t)weight : 255;
    state[6 + area + index] = known;
}

/* Decodes a reply of `length` bytes. */
static inline mmsim_reply mmsim_decode_reply(const uint8_t *message, size_t length) {
    mmsim_reply reply = {MMSIM_NO_REPLY, 0, 0, 0, "", 0};
    if (length == 4 && memcmp(message, "pong", 4) == 0) {
        reply.kind = MMSIM_PONG;
    } else if (length == 2 && memcmp(message, "ok", 2) == 0) {
        reply.kind = MMSIM_OK;
    } else if (length == 3 && message[0] < 2 && message[1] < 2 && message[2] < 2) {
        reply.kind = MMSIM_WALLS;
        reply.left = message[0];
        reply.front = message[1];
        reply.right = message[2];
    } else if (length >= 7 && memcmp(message, "error: ", 7) == 0) {
        reply.kind = MMSIM_ERROR;
        reply.text = (const char *)message + 7;
        reply.text_length = length - 7;
    }
    return reply;
}

#endif
