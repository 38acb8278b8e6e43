# Shows each of the 17 colours of mms in a cell of its own; its README lists 15.
for place, letter in enumerate("kbacgorwyBCAGORVY"):
    print("setColor %d %d %s" % (place % 5, place // 5, letter))
