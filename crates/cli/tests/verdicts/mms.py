"""A mouse for mms that sends commands and ends in a given way: mms.py COMMANDS ENDING."""
import os
import signal
import sys
import time

commands, ending = sys.argv[1:]
# The arguments of a command follow it.
for command in commands.replace(" 0 1 e", ",0,1,e").split():
    print(command.replace(",", " "), flush=True)
    if not command.startswith("setWall"):
        input()
if ending == "hangs":
    time.sleep(1000)
if ending == "crashes":
    sys.exit("a bad day")
if ending == "killed":
    os.kill(os.getpid(), signal.SIGKILL)
