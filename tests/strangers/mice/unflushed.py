# Knows its path, never flushes its output and never reads a reply.
for side in [4, 4, 2, 2]:
    print("moveForward %d" % side)
    print("turnRight")
