/* A robot for `mmsim trial MAZE -- ./trial_robot`: goes where it has been least often, then races
   along the last direction in which it left each cell. */
#include <stdio.h>

int main(void) {
    static const int dx[] = {0, 1, 0, -1}, dy[] = {1, 0, -1, 0}; /* north, east, south, west */
    static int goal[32][32], visits[34][34], leave[32][32]; /* visits has a margin */
    int start_x, start_y, x, y, heading = 0, racing = 0, seen[3];
    char after;
    if (scanf("maze %*d %*d start %d %d %*c goals", &start_x, &start_y) != 2) return 1;
    while (scanf("%d %d%c", &x, &y, &after) == 3 && (goal[x][y] = 1, after == ' ')) {}
    x = start_x, y = start_y;
    for (; scanf("%d %d %d", &seen[0], &seen[1], &seen[2]) == 3; fflush(stdout)) {
        int best = 2, least = 0; /* turn right in a dead end */
        for (int turn = -1; turn <= 1; turn++) {
            int to = (heading + turn + 4) % 4, count = visits[x + dx[to] + 1][y + dy[to] + 1];
            if (seen[turn + 1] == 0 || (racing && leave[x][y] != to)) continue;
            if (best == 2 || count < least) best = turn, least = count;
        }
        if (goal[x][y] && !racing) {
            x = start_x, y = start_y, heading = 0, racing = 1;
            puts("reset");
        } else if (best == 2) {
            heading = (heading + 1) % 4;
            puts("90 0");
        } else {
            leave[x][y] = heading = (heading + best + 4) % 4;
            x += dx[heading], y += dy[heading];
            visits[x + 1][y + 1]++;
            printf("%d 1\n", 90 * best);
        }
    }
    return 0;
}
