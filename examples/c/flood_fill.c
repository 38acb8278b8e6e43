/* A flood-fill mouse: always goes to the neighbour nearest to the goal, with unknown walls open.

   Start a simulator with `mmsim`, then run this program, optionally with an endpoint such as
   tcp://127.0.0.1:6574. Only `ask` and `main` use ZeroMQ; the rest also runs on a real mouse. */
#include <stdio.h>
#include <stdlib.h>
#include <zmq.h>

#include "mmsim.h"

enum { WIDTH = 16, HEIGHT = 16, AREA = WIDTH * HEIGHT, UNREACHABLE = 0xffff, TIMEOUT_MS = 5000 };

static const mmsim_size size = {WIDTH, HEIGHT};
static const uint8_t wall_at[4] = {MMSIM_WALL_NORTH, MMSIM_WALL_EAST, MMSIM_WALL_SOUTH, MMSIM_WALL_WEST};

static mmsim_pose pose = {0, 0, MMSIM_NORTH};
static uint8_t known[WIDTH][HEIGHT]; /* sums of MMSIM_VISITED and MMSIM_WALL_... */
static uint16_t distances[WIDTH][HEIGHT];

static const char *endpoint = "tcp://127.0.0.1:6574";
static void *simulator;

static int is_goal(int x, int y) {
    return (x == 7 || x == 8) && (y == 7 || y == 8);
}

static int is_inside(mmsim_pose at) {
    return at.x < WIDTH && at.y < HEIGHT; /* west of 0 is 255 */
}

/* Returns the pose after a number of quarter turns to the right and a step forward. */
static mmsim_pose after(mmsim_pose from, int quarters) {
    const int east[4] = {0, 1, 0, -1}, north[4] = {1, 0, -1, 0};
    const int heading = (from.heading + quarters) % 4;
    const mmsim_pose to = {(uint8_t)(from.x + east[heading]), (uint8_t)(from.y + north[heading]), (uint8_t)heading};
    return to;
}

/* Sends a request and returns its reply. Exits if the reply is not of the expected kind. */
static mmsim_reply ask(const uint8_t *message, size_t length, mmsim_reply_kind expected) {
    static uint8_t bytes[256];
    mmsim_reply reply;
    int received;
    if (zmq_send(simulator, message, length, 0) < 0 ||
        (received = zmq_recv(simulator, bytes, sizeof bytes, 0)) < 0) {
        fprintf(stderr, "no reply from %s within %d s (start a simulator with `mmsim`)\n", endpoint, TIMEOUT_MS / 1000);
        exit(EXIT_FAILURE);
    }
    reply = mmsim_decode_reply(bytes, (size_t)received < sizeof bytes ? (size_t)received : sizeof bytes);
    if (reply.kind == MMSIM_ERROR) {
        fprintf(stderr, "the simulator refused the request: ");
        for (size_t i = 0; i < reply.text_length; i++) {
            const unsigned char c = (unsigned char)reply.text[i];
            fprintf(stderr, c < 0x20 || c >= 0x7f ? "\\x%02x" : "%c", c);
        }
        fprintf(stderr, "\n");
        exit(EXIT_FAILURE);
    }
    if (reply.kind != expected) {
        fprintf(stderr, "unexpected reply of %d bytes\n", received);
        exit(EXIT_FAILURE);
    }
    return reply;
}

/* Records a wall in the cells on both sides of the wall. */
static void record_wall(int quarters, uint8_t wall) {
    const mmsim_pose beyond = after(pose, quarters);
    if (!wall) return;
    known[pose.x][pose.y] |= wall_at[beyond.heading];
    if (is_inside(beyond)) known[beyond.x][beyond.y] |= wall_at[(beyond.heading + 2) % 4];
}

/* Reads the walls around the mouse. */
static void read_walls(void) {
    uint8_t message[4];
    const size_t length = mmsim_encode_walls(message, sizeof message, pose);
    const mmsim_reply walls = ask(message, length, MMSIM_WALLS);
    known[pose.x][pose.y] |= MMSIM_VISITED;
    record_wall(3, walls.left);
    record_wall(0, walls.front);
    record_wall(1, walls.right);
}

/* Computes the number of steps from each cell to the goal, with unknown walls open. */
static void flood(void) {
    static mmsim_pose queue[AREA]; /* holds each cell at most once; headings are unused */
    int first = 0, last = 0;
    for (uint8_t x = 0; x < WIDTH; x++) {
        for (uint8_t y = 0; y < HEIGHT; y++) {
            const mmsim_pose cell = {x, y, MMSIM_NORTH};
            distances[x][y] = is_goal(x, y) ? 0 : UNREACHABLE;
            if (is_goal(x, y)) queue[last++] = cell;
        }
    }
    while (first < last) {
        const mmsim_pose cell = queue[first++];
        for (int quarters = 0; quarters < 4; quarters++) {
            const mmsim_pose beyond = after(cell, quarters);
            if (known[cell.x][cell.y] & wall_at[beyond.heading]) continue;
            if (distances[beyond.x][beyond.y] != UNREACHABLE) continue;
            distances[beyond.x][beyond.y] = (uint16_t)(distances[cell.x][cell.y] + 1);
            queue[last++] = beyond;
        }
    }
}

/* Reports the pose, the distances and the known walls. */
static void report_state(void) {
    static uint8_t message[MMSIM_STATE_BYTES(WIDTH, HEIGHT)];
    const size_t length = mmsim_encode_state(message, sizeof message, size, pose, MMSIM_ORDER_F);
    for (uint8_t x = 0; x < WIDTH; x++)
        for (uint8_t y = 0; y < HEIGHT; y++)
            mmsim_set_cell(message, size, x, y, distances[x][y], known[x][y]);
    ask(message, length, MMSIM_OK);
}

/* Takes a step towards the goal. Returns whether there is a path. */
static int step(void) {
    const int quarters[4] = {0, 3, 1, 2}; /* front, left, right, back; on a tie, the first one is chosen */
    const mmsim_pose here = pose;
    uint16_t least = UNREACHABLE;
    for (int i = 0; i < 4; i++) {
        const mmsim_pose beyond = after(here, quarters[i]);
        if (known[here.x][here.y] & wall_at[beyond.heading]) continue;
        if (distances[beyond.x][beyond.y] < least) {
            least = distances[beyond.x][beyond.y];
            pose = beyond;
        }
    }
    return least != UNREACHABLE;
}

int main(int argc, char **argv) {
    const char *variable = getenv("MMSIM_ENDPOINT");
    /* `mmsim run` sets the variable. It holds replies while the mouse is paused. */
    const int timeout = variable ? -1 : TIMEOUT_MS, linger = 0;
    uint8_t message[8];
    if (variable) endpoint = variable;
    if (argc > 1) endpoint = argv[1];
    simulator = zmq_socket(zmq_ctx_new(), ZMQ_REQ);
    zmq_setsockopt(simulator, ZMQ_RCVTIMEO, &timeout, sizeof timeout);
    zmq_setsockopt(simulator, ZMQ_LINGER, &linger, sizeof linger);
    if (zmq_connect(simulator, endpoint) != 0) {
        fprintf(stderr, "cannot reach %s: %s (expected tcp://HOST:PORT)\n", endpoint, zmq_strerror(zmq_errno()));
        return EXIT_FAILURE;
    }
    ask(message, mmsim_encode_ping(message, sizeof message), MMSIM_PONG);
    ask(message, mmsim_encode_reset(message, sizeof message), MMSIM_OK);

    for (uint8_t x = 0; x < WIDTH; x++) known[x][0] |= MMSIM_WALL_SOUTH, known[x][HEIGHT - 1] |= MMSIM_WALL_NORTH;
    for (uint8_t y = 0; y < HEIGHT; y++) known[0][y] |= MMSIM_WALL_WEST, known[WIDTH - 1][y] |= MMSIM_WALL_EAST;
    for (int steps = 0;; steps++) {
        read_walls();
        flood();
        report_state();
        if (is_goal(pose.x, pose.y)) return printf("goal reached after %d steps\n", steps), EXIT_SUCCESS;
        if (!step()) return fprintf(stderr, "goal unreachable after %d steps\n", steps), EXIT_FAILURE;
    }
}
