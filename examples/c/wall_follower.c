/* A whole mouse: follows the wall at its left hand through a 16x16 maze. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

static void *simulator;
static char reply[256];

static void ask(const void *request, size_t bytes) {
    memset(reply, 0, sizeof reply); /* so that an error text ends in a zero */
    if (zmq_send(simulator, request, bytes, 0) < 0 || zmq_recv(simulator, reply, sizeof reply - 1, 0) < 0)
        snprintf(reply, sizeof reply, "error: %s", zmq_strerror(zmq_errno()));
    if (strncmp(reply, "error: ", 7) == 0) { fprintf(stderr, "%s\n", reply); exit(1); }
}

int main(int argc, char **argv) {
    simulator = zmq_socket(zmq_ctx_new(), ZMQ_REQ);
    if (zmq_connect(simulator, argc > 1 ? argv[1] : "tcp://127.0.0.1:6574") != 0) { perror("connect"); return 1; }
    const int east[] = {0, 1, 0, -1}, north[] = {1, 0, -1, 0}; /* a step in heading 0 to 3: N, E, S, W */
    int x = 0, y = 0, heading = 0;
    unsigned char state[518] = {[0] = 'S', [4] = 'F', [261] = 'F'};
    unsigned char *weights = state + 5, *walls = state + 262; /* order F: cell (x, y) at x * 16 + y */
    ask("reset", 5);
    for (int steps = 0; steps <= 1000; steps++) {
        unsigned char pose[4] = {'W', x, y, "NESW"[heading]};
        ask(pose, 4); /* the reply: a wall to the left, in front, to the right */
        int turn = !reply[0] ? 3 : !reply[1] ? 0 : !reply[2] ? 1 : 2;
        memcpy(state + 1, pose + 1, 3);
        if (weights[x * 16 + y] < 255) weights[x * 16 + y]++; /* how often it has been here */
        walls[x * 16 + y] = 1; /* visited; add 2, 4, 8, 16 for a wall east, south, west, north */
        ask(state, sizeof state);
        if ((x == 7 || x == 8) && (y == 7 || y == 8)) { printf("goal reached after %d steps\n", steps); return 0; }
        heading = (heading + turn) % 4;
        x += east[heading], y += north[heading];
    }
    fprintf(stderr, "goal not reached after 1000 steps\n");
    return 1;
}
