"""A mouse for mms that sends commands and ends in a given way: mms.py COMMANDS ENDING."""
import sys
import time

commands, ending = sys.argv[1:]
for command in commands.split():
    print(command, flush=True)
    input()
if ending == "hangs":
    time.sleep(1000)
if ending == "crashes":
    sys.exit("a bad day")
