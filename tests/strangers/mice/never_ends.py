# Goes on reading walls in the goal, like a mouse whose main loop has no end.
from follower import ask, follow

follow()
while True:
    ask("wallFront")
