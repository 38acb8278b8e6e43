/* Runs the tasks that it reads from stdin with mmsim.h, and writes the results to stdout; see
   codec.rs. */
#include <stdio.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

#include "mmsim.h"

static uint8_t buffer[5000];

static uint8_t byte(void) {
    return (uint8_t)getchar();
}

static uint16_t number(void) {
    const uint16_t high = byte();
    return (uint16_t)(high << 8 | byte());
}

/* Writes the length of a request, its bytes, and whether the rest of the buffer is unchanged. */
static void write_request(size_t length) {
    int untouched = 1;
    putchar((int)(length >> 8)), putchar((int)(length & 255));
    fwrite(buffer, 1, length, stdout);
    for (size_t i = length; i < sizeof buffer; i++) untouched &= buffer[i] == 0xa5;
    putchar(untouched);
}

static mmsim_pose read_pose(void) {
    mmsim_pose pose;
    pose.x = byte(), pose.y = byte(), pose.heading = byte();
    return pose;
}

static size_t make_state(size_t capacity) {
    mmsim_size size;
    mmsim_pose pose;
    size_t length;
    int order;
    size.width = byte(), size.height = byte();
    pose = read_pose();
    order = byte();
    length = mmsim_encode_state(buffer, capacity, size, pose, order);
    if (length == 0) return 0;
    for (uint8_t y = 0; y < size.height; y++) {
        for (uint8_t x = 0; x < size.width; x++) {
            const uint16_t weight = number();
            mmsim_set_cell(buffer, size, x, y, weight, byte());
        }
    }
    mmsim_set_cell(buffer, size, size.width, 0, 1, 1);
    mmsim_set_cell(buffer, size, 0, size.height, 1, 1);
    return length;
}

/* Reads a zero-terminated string. */
static const char *read_text(void) {
    static char text[2000];
    size_t length = 0;
    int c;
    while ((c = getchar()) > 0 && length < sizeof text - 1) text[length++] = (char)c;
    text[length] = 0;
    return text;
}

/* Appends as many annotations as the next byte says. Writes for each of them whether it was
   appended ('+'), did not fit ('f'), was invalid ('-'), or could not begin a request ('0'). */
static size_t make_annotations(size_t capacity) {
    size_t length = 0;
    for (int count = byte(); count > 0; count--) {
        const char kind = (char)byte();
        const size_t before = length;
        if (kind == 'T') {
            const uint8_t x = byte(), y = byte();
            length = mmsim_annotate_text(buffer, capacity, length, x, y, read_text());
        } else if (kind == 'C') {
            const uint8_t x = byte(), y = byte();
            length = mmsim_annotate_colour(buffer, capacity, length, x, y, (char)byte());
        } else if (kind == 'D') {
            const mmsim_pose side = read_pose();
            length = mmsim_annotate_wall(buffer, capacity, length, side, (char)byte());
        } else if (kind == 'L') {
            length = mmsim_annotate_log(buffer, capacity, length, read_text());
        } else if (kind == 'M' || kind == 'S') {
            length = mmsim_annotate_name(buffer, capacity, length, kind, read_text());
        } else if (kind == 'R') {
            length = mmsim_annotate_restart(buffer, capacity, length);
        } else {
            length = mmsim_annotate_clear(buffer, capacity, length, kind);
        }
        putchar(length > before ? '+' : before == 0 ? '0' : length == 0 ? 'f' : '-');
        if (length == 0) length = before;
    }
    return length;
}

static void read_info(void) {
    const uint16_t length = number();
    for (uint16_t i = 0; i < length; i++) buffer[i] = byte();
    putchar(mmsim_has_annotations(buffer, length));
}

static void read_reply(void) {
    const uint16_t length = number();
    mmsim_reply reply;
    for (uint16_t i = 0; i < length; i++) buffer[i] = byte();
    reply = mmsim_decode_reply(buffer, length);
    putchar((int)reply.kind), putchar(reply.left), putchar(reply.front), putchar(reply.right);
    putchar((int)reply.text_length);
    fwrite(reply.text, 1, reply.text_length, stdout);
}

int main(void) {
#ifdef _WIN32
    _setmode(_fileno(stdin), _O_BINARY), _setmode(_fileno(stdout), _O_BINARY);
#endif
    for (int task = getchar(); task != EOF; task = getchar()) {
        size_t capacity = 0;
        memset(buffer, 0xa5, sizeof buffer);
        if (task != '?' && task != 'i') capacity = number();
        if (task == 'p') write_request(mmsim_encode_ping(buffer, capacity));
        if (task == 'r') write_request(mmsim_encode_reset(buffer, capacity));
        if (task == 'w') write_request(mmsim_encode_walls(buffer, capacity, read_pose()));
        if (task == 's') write_request(make_state(capacity));
        if (task == 'e') write_request(mmsim_encode_info(buffer, capacity));
        if (task == 'a') write_request(make_annotations(capacity));
        if (task == 'i') read_info();
        if (task == '?') read_reply();
    }
    return 0;
}
