/* The flood of a textbook: a queue of cells, with the walls of each cell in one byte (1 north, 2
   east, 4 south, 8 west). */
#include <stdint.h>

uint8_t queue_flood(const uint8_t walls[256], const uint8_t *targets, uint32_t count,
                    uint8_t distances[256]) {
    static const int8_t offsets[4] = {16, 1, -16, -1};
    uint8_t queue[256];
    uint32_t head = 0, tail = 0;
    for (uint32_t i = 0; i < 256; i++) {
        distances[i] = 255;
    }
    for (uint32_t i = 0; i < count; i++) {
        distances[targets[i]] = 0;
        queue[tail++] = targets[i];
    }
    while (head < tail) {
        uint8_t cell = queue[head++];
        for (int side = 0; side < 4; side++) {
            uint8_t next = (uint8_t)(cell + offsets[side]);
            if (!(walls[cell] >> side & 1) && distances[next] == 255) {
                distances[next] = (uint8_t)(distances[cell] + 1);
                queue[tail++] = next;
            }
        }
    }
    return distances[0];
}
