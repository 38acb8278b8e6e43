// A flood-fill mouse for mms: it goes to the reachable neighbour nearest to the centre.
#include <iostream>
#include <queue>
#include <string>
#include <vector>

static std::string ask(const std::string& command) {
    std::cout << command << std::endl;
    std::string reply;
    std::getline(std::cin, reply);
    return reply;
}

int main() {
    const int dx[] = {0, 1, 0, -1}, dy[] = {1, 0, -1, 0};
    const char letters[] = "nesw";
    const int width = std::stoi(ask("mazeWidth")), height = std::stoi(ask("mazeHeight"));
    std::vector<int> walls(width * height, 0), distance(width * height);
    int x = 0, y = 0, heading = 0;
    auto is_goal = [&](int x, int y) {
        return (x == (width - 1) / 2 || x == width / 2) && (y == (height - 1) / 2 || y == height / 2);
    };
    auto inside = [&](int x, int y) { return x >= 0 && y >= 0 && x < width && y < height; };
    while (!is_goal(x, y)) {
        const char* commands[] = {"wallFront", "wallRight", nullptr, "wallLeft"};
        for (int turn = 0; turn < 4; turn++) {
            if (!commands[turn] || ask(commands[turn]) != "true") continue;
            int side = (heading + turn) % 4, nx = x + dx[side], ny = y + dy[side];
            walls[x * height + y] |= 1 << side;
            if (inside(nx, ny)) walls[nx * height + ny] |= 1 << (side + 2) % 4;
            std::cout << "setWall " << x << ' ' << y << ' ' << letters[side] << '\n';
        }
        std::fill(distance.begin(), distance.end(), -1);
        std::queue<int> queue;
        for (int x = 0; x < width; x++)
            for (int y = 0; y < height; y++)
                if (is_goal(x, y)) distance[x * height + y] = 0, queue.push(x * height + y);
        while (!queue.empty()) {
            int cell = queue.front(), cx = cell / height, cy = cell % height;
            queue.pop();
            for (int side = 0; side < 4; side++) {
                int nx = cx + dx[side], ny = cy + dy[side];
                if (!inside(nx, ny) || walls[cell] >> side & 1 || distance[nx * height + ny] >= 0) continue;
                distance[nx * height + ny] = distance[cell] + 1;
                queue.push(nx * height + ny);
            }
        }
        if (distance[x * height + y] < 0) {
            std::cerr << "the goal is unreachable" << std::endl;
            return 0;
        }
        const int order[] = {0, 1, 3, 2};
        for (int turn : order) {
            int side = (heading + turn) % 4, nx = x + dx[side], ny = y + dy[side];
            if (!inside(nx, ny) || walls[x * height + y] >> side & 1) continue;
            if (distance[nx * height + ny] != distance[x * height + y] - 1) continue;
            if (turn == 1 || turn == 2) ask("turnRight");
            if (turn == 2) ask("turnRight");
            if (turn == 3) ask("turnLeft");
            ask("moveForward");
            x = nx, y = ny, heading = side;
            break;
        }
    }
}
