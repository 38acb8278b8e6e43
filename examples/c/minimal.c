#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

int main(void) {
    void *socket = zmq_socket(zmq_ctx_new(), ZMQ_REQ);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &(int){5000}, sizeof(int));
    zmq_connect(socket, getenv("MMSIM_ENDPOINT") ? getenv("MMSIM_ENDPOINT") : "tcp://127.0.0.1:6574");
    unsigned char state[518] = {[0] = 'S', [4] = 'F', [261] = 'F'}, wall[3], reply[2];
    zmq_send(socket, "reset", 5, 0);
    if (zmq_recv(socket, wall, 3, 0) < 0) return puts("no reply within 5 s"), 1;
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &(int){-1}, sizeof(int)); /* the mouse can be paused */
    for (int x = 0, y = 0, heading = 0, steps = 0;; steps++) { /* heading 0 to 3: N, E, S, W */
        unsigned char pose[4] = {'W', x, y, "NESW"[heading]};
        zmq_send(socket, pose, 4, 0);
        if (zmq_recv(socket, wall, 3, 0) != 3) return puts("expected three bytes of walls"), 1;
        memcpy(state + 1, pose + 1, 3);
        state[262 + 16 * x + y] = 1; /* visited; add 2, 4, 8, 16 for a wall east, south, west, north */
        zmq_send(socket, state, sizeof state, 0);
        if (zmq_recv(socket, reply, 2, 0) != 2) return puts("expected ok"), 1;
        if ((x == 7 || x == 8) && (y == 7 || y == 8)) return printf("goal reached after %d steps\n", steps), 0;
        heading = (heading + (!wall[0] ? 3 : !wall[1] ? 0 : !wall[2] ? 1 : 2)) % 4;
        x += heading == 1 ? 1 : heading == 3 ? -1 : 0, y += heading == 0 ? 1 : heading == 2 ? -1 : 0;
    }
}
