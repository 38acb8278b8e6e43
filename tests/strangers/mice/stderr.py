# Writes more to stderr than a pipe holds, without an end of the line.
import sys

from follower import follow

for step in range(20000):
    sys.stderr.write("\rstep %d of 20000" % step)
follow()
