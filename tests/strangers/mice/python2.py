# A mouse in Python 2.
import sys

from follower import follow

print "turnRight"
sys.stdout.flush()
assert raw_input() == "ack"
print "turnLeft"
sys.stdout.flush()
assert raw_input() == "ack"
follow()
