# Ends its lines with CR LF, like programs on Windows.
from follower import follow

follow(end="\r\n")
