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

/* A buffer of this size holds any request except annotations. */
#define MMSIM_MAX_BYTES MMSIM_STATE_BYTES(MMSIM_MAX_SIDE, MMSIM_MAX_SIDE)

/* The maximum length of an annotations request in bytes. */
#define MMSIM_MAX_ANNOTATIONS_BYTES 4096

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
    MMSIM_NO_REPLY, /* invalid reply, or the reply to info: see mmsim_has_annotations */
    MMSIM_PONG,     /* reply to ping */
    MMSIM_OK,       /* reply to reset, to a state and to annotations */
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

static inline int mmsim_is_cell(uint8_t x, uint8_t y) {
    return x < MMSIM_MAX_SIDE && y < MMSIM_MAX_SIDE;
}

/* Encodes a request for the walls to the left, in front and to the right in this pose. */
static inline size_t mmsim_encode_walls(uint8_t *buffer, size_t capacity, mmsim_pose pose) {
    if (!mmsim_is_cell(pose.x, pose.y) || pose.heading > MMSIM_WEST || capacity < 4) return 0;
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

/* Encodes `info`. Only send it to `mmsim`: the reference simulator never replies to it. Pass the
   reply to mmsim_has_annotations. */
static inline size_t mmsim_encode_info(uint8_t *buffer, size_t capacity) {
    if (capacity < 4) return 0;
    memcpy(buffer, "info", 4);
    return 4;
}

/* Returns 1 if the reply to `info` says that the simulator shows annotations. */
static inline int mmsim_has_annotations(const uint8_t *reply, size_t length) {
    static const char list[] = "\"extensions\":[", name[] = "\"annotations\"";
    int is_listed = 0;
    for (size_t i = 0; i < length; i++) {
        if (length - i >= sizeof list - 1 && memcmp(reply + i, list, sizeof list - 1) == 0) {
            is_listed = 1;
        } else if (is_listed && reply[i] == ']') {
            return 0;
        } else if (is_listed && length - i >= sizeof name - 1 &&
                   memcmp(reply + i, name, sizeof name - 1) == 0) {
            return 1;
        }
    }
    return 0;
}

/* Annotations are texts, colours, walls and log lines, which the simulator shows with the next
   state. Only send them to a simulator whose reply to `info` lists them: other simulators may never
   reply.

       uint8_t request[MMSIM_MAX_ANNOTATIONS_BYTES];
       size_t length = 0;
       length = mmsim_annotate_text(request, sizeof request, length, x, y, "1024");
       length = mmsim_annotate_colour(request, sizeof request, length, x, y, 'G');
       ... if `length` is not 0, send `length` bytes, expect `ok`, then send the state ...

   Each mmsim_annotate function appends an annotation to a request of `length` bytes, or begins a
   request if `length` is 0, and returns the new length. If an argument is out of range, it writes
   nothing and returns `length`. If the annotation is valid but does not fit into the rest of the
   request, it writes nothing and returns 0. To send more annotations than fit into one request:

       size_t next = mmsim_annotate_log(request, sizeof request, length, line);
       if (next == 0 && length > 0) {
           ... send `length` bytes and expect `ok` ...
           next = mmsim_annotate_log(request, sizeof request, 0, line);
       }
       length = next;

   A request of MMSIM_MAX_ANNOTATIONS_BYTES has room for any annotation. All texts are UTF-8 and
   consist of printable characters; log lines can also contain tabs. A character is a Unicode code
   point. All are printable except control characters, the line and paragraph separators U+2028 and
   U+2029, and the marks that change the direction of text, such as U+200F. */

/* Returns the length of the first character of a text in bytes, or 0 if annotations cannot contain
   the character: invalid UTF-8, and characters that are not printable. */
static inline size_t mmsim_character(const char *text, size_t length) {
    static const uint32_t min[5] = {0, 0x20, 0xa0, 0x800, 0x10000};
    const uint8_t first = (uint8_t)text[0];
    const size_t bytes = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    uint32_t c = bytes == 1 ? first : first & (0x7fu >> bytes);
    if (bytes > length || (first >= 0x80 && first < 0xc0) || first >= 0xf8) return 0;
    for (size_t i = 1; i < bytes; i++) {
        if (((uint8_t)text[i] & 0xc0) != 0x80) return 0;
        c = c << 6 | ((uint8_t)text[i] & 0x3fu);
    }
    if (c < min[bytes] || c == 0x7f || c > 0x10ffff || (c >= 0xd800 && c < 0xe000)) return 0;
    if (c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x2028 && c <= 0x202e)) return 0;
    return c >= 0x2066 && c <= 0x2069 ? 0 : bytes;
}

/* Appends a head of 1 to 5 bytes and a text. */
static inline size_t mmsim_annotate(uint8_t *request, size_t capacity, size_t length,
                                    const char *head, size_t head_length, const char *text,
                                    size_t text_length) {
    const size_t start = length > 0 ? length : 1;
    if (capacity > MMSIM_MAX_ANNOTATIONS_BYTES) capacity = MMSIM_MAX_ANNOTATIONS_BYTES;
    for (size_t i = 0, bytes; i < text_length; i += bytes) {
        const int is_tab = text[i] == '\t' && head[0] == 'L';
        bytes = is_tab ? 1 : mmsim_character(text + i, text_length - i);
        if (bytes == 0) return length;
    }
    if (capacity < start || capacity - start < head_length + text_length) return 0;
    request[0] = 'A';
    memcpy(request + start, head, head_length);
    if (text_length > 0) memcpy(request + start + head_length, text, text_length);
    return start + head_length + text_length;
}

/* Sets the text of a cell, at most 10 characters, or clears it if `text` is empty. */
static inline size_t mmsim_annotate_text(uint8_t *request, size_t capacity, size_t length,
                                         uint8_t x, uint8_t y, const char *text) {
    const size_t bytes = strlen(text);
    const char head[4] = {'T', (char)x, (char)y, (char)bytes};
    size_t characters = 0;
    for (size_t i = 0; i < bytes; i++) characters += ((uint8_t)text[i] & 0xc0) != 0x80;
    if (characters > 10 || bytes > 40 || !mmsim_is_cell(x, y)) return length;
    return mmsim_annotate(request, capacity, length, head, 4, text, bytes);
}

/* The letters of the colours of the simulator mms. */
#define MMSIM_COLOURS "kbacgorwyBCAGORVY"

/* Sets the colour of a cell to one of MMSIM_COLOURS, or clears it if `letter` is '-'. */
static inline size_t mmsim_annotate_colour(uint8_t *request, size_t capacity, size_t length,
                                           uint8_t x, uint8_t y, char letter) {
    const char head[4] = {'C', (char)x, (char)y, letter};
    if (!mmsim_is_cell(x, y) || letter == 0 || !strchr(MMSIM_COLOURS "-", letter)) return length;
    return mmsim_annotate(request, capacity, length, head, 4, "", 0);
}

/* Declares a wall of a cell, whatever the flags in the states say: '1' present, '0' absent,
   '?' unknown, '-' as in the states. */
static inline size_t mmsim_annotate_wall(uint8_t *request, size_t capacity, size_t length,
                                         mmsim_pose side, char state) {
    const char head[5] = {'D', (char)side.x, (char)side.y, "NESW"[side.heading & 3], state};
    if (!mmsim_is_cell(side.x, side.y) || side.heading > MMSIM_WEST) return length;
    if (state == 0 || !strchr("10?-", state)) return length;
    return mmsim_annotate(request, capacity, length, head, 5, "", 0);
}

/* Logs a line of at most 1000 bytes. */
static inline size_t mmsim_annotate_log(uint8_t *request, size_t capacity, size_t length,
                                        const char *line) {
    const size_t bytes = strlen(line);
    const char head[3] = {'L', (char)(bytes & 255), (char)(bytes >> 8)};
    if (bytes > 1000) return length;
    return mmsim_annotate(request, capacity, length, head, 3, line, bytes);
}

/* Names the mouse ('M') or its strategy ('S'), in at most 100 bytes. */
static inline size_t mmsim_annotate_name(uint8_t *request, size_t capacity, size_t length,
                                         char what, const char *name) {
    const size_t bytes = strlen(name);
    const char head[2] = {what, (char)bytes};
    if ((what != 'M' && what != 'S') || bytes > 100) return length;
    return mmsim_annotate(request, capacity, length, head, 2, name, bytes);
}

/* Clears all texts ('t'), colours ('c') or declared walls ('d'). */
static inline size_t mmsim_annotate_clear(uint8_t *request, size_t capacity, size_t length,
                                          char what) {
    if (what == 0 || !strchr("tcd", what)) return length;
    return mmsim_annotate(request, capacity, length, &what, 1, "", 0);
}

/* Says that the mouse was put back at its start. Without this annotation, the simulator compares
   the poses in two states to find out whether the mouse drove to the start. */
static inline size_t mmsim_annotate_restart(uint8_t *request, size_t capacity, size_t length) {
    return mmsim_annotate(request, capacity, length, "R", 1, "", 0);
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
