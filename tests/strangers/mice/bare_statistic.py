# Asks for a statistic by its name alone, as the crate mms-rs does.
from follower import ask

assert ask("turnRight") == "ack" and ask("total-turns") == "1"
